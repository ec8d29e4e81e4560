#include "fastdds_client.hpp"

#include <unistd.h>

#include <thread>

namespace peers {

namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

}  // namespace

Network private_network(const std::string& transport, const std::string& reliability) {
    // Above 232 the ports of a domain end beyond 65535, above 100 they are those of connections.
    const auto process = static_cast<std::uint32_t>(::getpid());
    return {transport, reliability, 1 + process % 100, "peers-" + std::to_string(process) + "/"};
}

Caller::Caller(const Exchange& exchange) : exchange_(exchange) {
    if (!is_oneway(exchange_)) reply_ = exchange_.reply.type->createData();
}

Caller::~Caller() {
    if (reply_ != nullptr) exchange_.reply.type->deleteData(reply_);
}

void Caller::start(Participant& participant) {
    if (!is_oneway(exchange_)) {
        reader_ = participant.reader("reply/" + exchange_.key, exchange_.reply, this);
    }
    writer_ = participant.writer("request/" + exchange_.key, exchange_.request);
}

void Caller::wait_until_ready() {
    const auto deadline = Clock::now() + 20s;
    while (!has_counterpart(*writer_) || (reader_ != nullptr && !has_counterpart(*reader_))) {
        throw_if_interrupted();
        if (Clock::now() >= deadline) throw std::runtime_error("the server is not found");
        std::this_thread::sleep_for(5ms);
    }
}

void Caller::send() {
    if (!writer_->write(exchange_.request.sample.get())) {
        throw std::runtime_error("Fast DDS does not write");
    }
}

/// When it returns, the former one is no longer running.
void Caller::set_on_reply(OnReply call) {
    const std::lock_guard lock{mutex_};
    on_reply_ = std::move(call);
}

void Caller::on_data_available(dds::DataReader* reader) {
    dds::SampleInfo info;
    while (reader->take_next_sample(reply_, &info) ==
           eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
        const std::lock_guard lock{mutex_};
        if (info.valid_data && on_reply_) on_reply_(info);
    }
}

}  // namespace peers
