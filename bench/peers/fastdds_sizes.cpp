#include "fastdds_sizes.hpp"

#include <samplesPubSubTypes.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <optional>
#include <thread>

#include "child_process.hpp"
#include "fastdds_client.hpp"
#include "octets.hpp"
#include "packet_capture.hpp"
#include "rtps_datagram.hpp"

namespace peers {

namespace {

using namespace std::chrono_literals;
using nlohmann::ordered_json;

Message value(float number) {
    Samples::Number sample;
    sample.value(number);
    return message<Samples::NumberPubSubType>(sample);
}

Message text(const std::string& characters) {
    Samples::Text sample;
    sample.value(characters);
    return message<Samples::TextPubSubType>(sample);
}

Message channel(std::uint16_t index) {
    Samples::Channel sample;
    sample.index(index);
    return message<Samples::ChannelPubSubType>(sample);
}

Message attribute() {
    Samples::SetAttributeValueUL sample;
    sample.attrName("TemperatureSetPoint");
    sample.idxVal(7);
    sample.attrValue(1500);
    return message<Samples::SetAttributeValueULPubSubType>(sample);
}

Message push() {
    Samples::Push sample;
    sample.id(1025);
    sample.value(21.5F);
    return message<Samples::PushPubSubType>(sample);
}

Message status() {
    Samples::Status sample;
    sample.value(Samples::State::running);
    return message<Samples::StatusPubSubType>(sample);
}

Message block() {
    Samples::Block sample;
    for (std::size_t i = 0; i < 256; ++i) {
        sample.value().push_back(static_cast<std::uint8_t>(i * 7 % 256));
    }
    return message<Samples::BlockPubSubType>(sample);
}

Message limits() {
    Samples::Limits sample;
    sample.low(18.0F);
    sample.high(24.0F);
    return message<Samples::LimitsPubSubType>(sample);
}

/// Which of the exceptions of CORBA is for the two sides to agree on.
Message no_permission() {
    Samples::SystemException sample;
    sample.minor(0);
    sample.kind(6);
    sample.completed(0);
    return message<Samples::SystemExceptionPubSubType>(sample);
}

std::vector<Exchange> exchanges() {
    std::string name;
    for (int i = 0; i < 8; ++i) name += "abcdefgh";
    return {
        {"ping", nothing(), nothing()},
        {"set_attribute_ul", attribute(), nothing()},
        {"read", nothing(), value(21.5F)},
        {"push", push(), {}},
        {"get_level", nothing(), value(0.75F)},
        {"set_level", value(0.75F), nothing()},
        {"status", nothing(), status()},
        {"rename_64", text(name), nothing()},
        {"load_256", block(), nothing()},
        {"limits", nothing(), limits()},
        {"user_exception", channel(9), channel(9)},
        {"system_exception", nothing(), no_permission()},
        {"attach_nil", text(""), nothing()},
        {"attach_reference", text("corbaloc:caniop:2/1"), nothing()},
    };
}

ordered_json captured(const Octets& datagram, const RtpsDatagram& parsed) {
    ordered_json result = to_json(datagram);
    result["octets_without_statistics"] = datagram.size() - statistics_octets(parsed);
    result["submessages"] = to_json(parsed.submessages);
    return result;
}

/// The first datagram with data of this writer, and the first with an acknowledgement for it. More
/// may follow: a reliable writer repeats what is not acknowledged in time.
struct Delivery {
    ordered_json data;
    ordered_json acknowledgement;
};

Delivery delivery_of(const std::vector<Octets>& datagrams, const Guid& writer) {
    Delivery delivery;
    for (const auto& datagram : datagrams) {
        const auto parsed = parse_rtps(datagram);
        if (!parsed) continue;
        if (delivery.data.is_null()) {
            if (parsed->writer == writer) delivery.data = captured(datagram, *parsed);
        } else if (delivery.acknowledgement.is_null() && parsed->acknowledged == writer) {
            delivery.acknowledgement = captured(datagram, *parsed);
        }
    }
    return delivery;
}

ordered_json to_json(Delivery delivery, bool reliable) {
    if (delivery.data.is_null()) {
        throw std::runtime_error("a sample is not among the captured datagrams");
    }
    if (reliable) delivery.data["acknowledgement"] = std::move(delivery.acknowledgement);
    return std::move(delivery.data);
}

Guid to_guid(const eprosima::fastrtps::rtps::GUID_t& guid) {
    Guid result{};
    const auto end = std::copy_n(guid.guidPrefix.value, 12, result.begin());
    std::copy_n(guid.entityId.value, 4, end);
    return result;
}

/// Sends a request. Returns who wrote the reply, if there is one.
std::optional<Guid> call(Caller& caller, bool oneway) {
    std::mutex mutex;
    std::condition_variable changed;
    std::optional<Guid> answering;
    const ReplyHandler handler{
        caller, [&](const dds::SampleInfo& info) {
            const std::lock_guard lock{mutex};
            answering = to_guid(eprosima::fastrtps::rtps::iHandle2GUID(info.publication_handle));
            changed.notify_one();
        }};
    caller.send();
    std::unique_lock lock{mutex};
    if (!oneway) {
        wait_for(changed, lock, [&] { return answering.has_value(); }, 5s, "no reply comes");
    }
    return answering;
}

ordered_json exchange_once(Caller& caller, bool oneway, bool reliable, PacketCapture& capture) {
    capture.take();  // of others
    const auto answering = call(caller, oneway);
    const Guid asking = to_guid(caller.writer().guid());
    const auto deadline = std::chrono::steady_clock::now() + 500ms;
    std::vector<Octets> datagrams;
    const auto is_complete = [&](const Guid& writer) {
        const Delivery delivery = delivery_of(datagrams, writer);
        return !delivery.data.is_null() && (!reliable || !delivery.acknowledgement.is_null());
    };
    while (!is_complete(asking) || (answering && !is_complete(*answering))) {
        if (std::chrono::steady_clock::now() >= deadline) break;
        std::this_thread::sleep_for(1ms);  // acknowledgements come later
        std::ranges::move(capture.take(), std::back_inserter(datagrams));
    }
    ordered_json result;
    result["request"] = to_json(delivery_of(datagrams, asking), reliable);
    result["reply"] =
        answering ? to_json(delivery_of(datagrams, *answering), reliable) : ordered_json(nullptr);
    return result;
}

}  // namespace

void answer_all(const std::string& reliability, const std::string& domain,
                const std::string& name) {
    answer_until_signal({"udp", reliability, static_cast<std::uint32_t>(std::stoul(domain)), name},
                        exchanges());
}

ordered_json rtps_sizes(const std::string& reliability) {
    PacketCapture capture;
    const Network network = private_network("udp", reliability);
    Child server{{own_program(), "answer", "--reliability", reliability, "--domain",
                  std::to_string(network.domain), "--name", network.name}};
    std::vector<std::unique_ptr<Caller>> callers;
    Participant participant{network};
    const auto all = exchanges();
    for (const auto& exchange : all) {
        callers.push_back(std::make_unique<Caller>(exchange));
        callers.back()->start(participant);
    }
    for (const auto& caller : callers) caller->wait_until_ready();
    server.read_line();
    std::this_thread::sleep_for(200ms);  // the first heartbeats and their answers

    ordered_json result;
    for (std::size_t i = 0; i < all.size(); ++i) {
        result[all[i].key] =
            exchange_once(*callers[i], is_oneway(all[i]), reliability == "reliable", capture);
    }
    return result;
}

}  // namespace peers
