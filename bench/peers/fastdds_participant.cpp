#include "fastdds_participant.hpp"

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.h>
#include <samplesPubSubTypes.h>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <stdexcept>

namespace peers {

namespace {

namespace rtps = eprosima::fastdds::rtps;

constexpr auto ok = eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK;

template <typename Entity>
Entity* require(Entity* entity, const char* what) {
    if (entity == nullptr) throw std::runtime_error(std::string{"Fast DDS makes no "} + what);
    return entity;
}

dds::DomainParticipantQos participant_qos(const Network& network) {
    auto qos = dds::PARTICIPANT_QOS_DEFAULT;
    qos.transport().use_builtin_transports = false;
    if (network.transport == "udp") {
        auto udp = std::make_shared<rtps::UDPv4TransportDescriptor>();
        udp->interfaceWhiteList.emplace_back("127.0.0.1");
        qos.transport().user_transports.push_back(udp);
    } else {
        qos.transport().user_transports.push_back(
            std::make_shared<rtps::SharedMemTransportDescriptor>());
    }
    return qos;
}

template <typename Qos>
Qos endpoint_qos(const Network& network, Qos qos) {
    qos.reliability().kind = network.reliability == "reliable" ? dds::RELIABLE_RELIABILITY_QOS
                                                               : dds::BEST_EFFORT_RELIABILITY_QOS;
    if (network.transport == "data_sharing") {
        qos.data_sharing().on("");
    } else {
        qos.data_sharing().off();
    }
    return qos;
}

}  // namespace

Message nothing() {
    return message<Samples::NothingPubSubType>({});
}

Participant::Participant(Network network)
    : network_(std::move(network)),
      participant_(require(dds::DomainParticipantFactory::get_instance()->create_participant(
                               network_.domain, participant_qos(network_)),
                           "participant")),
      publisher_(require(participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT), "publisher")),
      subscriber_(
          require(participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT), "subscriber")) {}

Participant::~Participant() {
    participant_->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
}

dds::Topic* Participant::topic(const std::string& name, const Message& message) {
    const std::string& type = message.type->getName();
    if (participant_->find_type(type).empty() && participant_->register_type(message.type) != ok) {
        throw std::runtime_error("Fast DDS does not register " + type);
    }
    return require(participant_->create_topic(network_.name + name, type, dds::TOPIC_QOS_DEFAULT),
                   "topic");
}

dds::DataWriter* Participant::writer(const std::string& name, const Message& message) {
    const auto qos = endpoint_qos(network_, dds::DATAWRITER_QOS_DEFAULT);
    return require(publisher_->create_datawriter(topic(name, message), qos), "writer");
}

dds::DataReader* Participant::reader(const std::string& name, const Message& message,
                                     dds::DataReaderListener* listener) {
    const auto qos = endpoint_qos(network_, dds::DATAREADER_QOS_DEFAULT);
    return require(subscriber_->create_datareader(topic(name, message), qos, listener), "reader");
}

bool has_counterpart(dds::DataWriter& writer) {
    dds::PublicationMatchedStatus status;
    return writer.get_publication_matched_status(status) == ok && status.current_count > 0;
}

bool has_counterpart(dds::DataReader& reader) {
    dds::SubscriptionMatchedStatus status;
    return reader.get_subscription_matched_status(status) == ok && status.current_count > 0;
}

}  // namespace peers
