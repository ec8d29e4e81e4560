// A participant of Fast DDS that talks over one kind of transport, and what it writes and reads.
#pragma once

#include <cstdint>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <memory>
#include <string>

namespace peers {

namespace dds = eprosima::fastdds::dds;

/// What both sides must agree on.
struct Network {
    std::string transport;    // udp, shm (shared memory), data_sharing (shared history)
    std::string reliability;  // best_effort, reliable
    std::uint32_t domain = 0;
    std::string name;  // begins the names of all topics
};

/// A type, and a sample of it.
struct Message {
    dds::TypeSupport type;
    std::shared_ptr<void> sample;
};

template <typename PubSubType>
Message message(typename PubSubType::type sample) {
    using Sample = typename PubSubType::type;
    return {dds::TypeSupport{new PubSubType}, std::make_shared<Sample>(std::move(sample))};
}

/// The smallest message there is, for calls without parameters.
Message nothing();

class Participant {
  public:
    explicit Participant(Network network);
    ~Participant();
    Participant(const Participant&) = delete;
    Participant& operator=(const Participant&) = delete;

    dds::DataWriter* writer(const std::string& topic, const Message& message);
    /// The listener must outlive the participant.
    dds::DataReader* reader(const std::string& topic, const Message& message,
                            dds::DataReaderListener* listener);

  private:
    dds::Topic* topic(const std::string& name, const Message& message);

    Network network_;
    dds::DomainParticipant* participant_;
    dds::Publisher* publisher_;
    dds::Subscriber* subscriber_;
};

/// Whether each has its counterpart in the other process.
bool has_counterpart(dds::DataWriter& writer);
bool has_counterpart(dds::DataReader& reader);

}  // namespace peers
