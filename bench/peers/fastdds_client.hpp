// The client's side over DDS.
#pragma once

#include <chrono>
#include <condition_variable>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <functional>
#include <mutex>

#include "child_process.hpp"
#include "fastdds_answerer.hpp"

namespace peers {

/// A network for this process and its children alone, unless others make up the same name.
Network private_network(const std::string& transport, const std::string& reliability);

/// Waits for a condition that a listener makes true. Throws when that takes too long.
template <typename Lock, typename Condition>
void wait_for(std::condition_variable& changed, Lock& lock, Condition condition,
              std::chrono::milliseconds timeout, const char* what) {
    const auto deadline = std::chrono::steady_clock::now() + timeout;
    while (!condition()) {
        throw_if_interrupted();
        if (std::chrono::steady_clock::now() >= deadline) throw std::runtime_error(what);
        changed.wait_for(lock, std::chrono::milliseconds{50}, condition);
    }
}

/// Writes requests and reads replies of one exchange.
class Caller final : public dds::DataReaderListener {
  public:
    explicit Caller(const Exchange& exchange);
    ~Caller() override;
    Caller(const Caller&) = delete;
    Caller& operator=(const Caller&) = delete;

    /// Must be called before the participant ends, which uses this object as long as it lives.
    void start(Participant& participant);
    /// Waits until both the writer and the reader have found the server's.
    void wait_until_ready();

    void send();
    dds::DataWriter& writer() const { return *writer_; }
    using OnReply = std::function<void(const dds::SampleInfo&)>;

    void on_data_available(dds::DataReader* reader) override;

  private:
    friend class ReplyHandler;

    void set_on_reply(OnReply call);

    Exchange exchange_;
    void* reply_ = nullptr;
    dds::DataWriter* writer_ = nullptr;
    dds::DataReader* reader_ = nullptr;
    std::mutex mutex_;
    OnReply on_reply_;
};

/// As long as it lives, the reader's thread calls this for each reply.
class ReplyHandler {
  public:
    ReplyHandler(Caller& caller, Caller::OnReply call) : caller_(caller) {
        caller_.set_on_reply(std::move(call));
    }
    ~ReplyHandler() { caller_.set_on_reply(nullptr); }
    ReplyHandler(const ReplyHandler&) = delete;
    ReplyHandler& operator=(const ReplyHandler&) = delete;

  private:
    Caller& caller_;
};

}  // namespace peers
