// Calls on the paced bus, beside frames that no ORB has made.

#include <poll.h>

#include <array>
#include <memory>
#include <stdexcept>
#include <thread>
#include <variant>
#include <vector>

#include "calls.hpp"
#include "orb/can/frame_length.hpp"
#include "orb/can/link/sim_link.hpp"
#include "orb/caniop/identifier.hpp"
#include "orb/giop/message.hpp"
#include "processes.hpp"

namespace canorb::bench {
namespace {

using namespace std::chrono_literals;

constexpr NodeId client_node{1};
constexpr NodeId server_node{2};
constexpr std::array<std::uint32_t, 4> bitrates{125'000, 250'000, 500'000, 1'000'000};

// The frames of ping(), as the ORBs send them.

can::Frame request(RequestId id) {
    std::array<std::uint8_t, giop::request_header_size> octets{};
    giop::write_request_header(octets, id, ObjectKey{server_node, 1}.value(), 0, 0);
    return can::Frame::standard(caniop::Identifier::to_node(server_node, client_node).can_id(),
                                octets);
}

can::Frame reply(RequestId id) {
    std::array<std::uint8_t, giop::reply_header_size> octets{};
    giop::write_reply_header(octets, id, giop::ReplyStatus::no_exception, 0);
    return can::Frame::standard(caniop::Identifier::to_node(client_node, server_node).can_id(),
                                octets);
}

std::unique_ptr<can::Controller> attach(const std::string& path, const char* name,
                                        std::uint32_t hears) {
    auto link = can::open_sim_link({path});
    if (!link) throw std::runtime_error{link.error()};
    auto controller = (*link)->attach(name);
    if (!controller) throw std::runtime_error{controller.error()};
    const std::array<can::Filter, 1> filter{can::Filter{.mask = 0x7FF, .value = hears}};
    if (!(*controller)->set_filters(filter)) throw std::runtime_error{"no filter"};
    return std::move(*controller);
}

/// The next frame for it.
can::Frame receive(can::Controller& controller) {
    for (;;) {
        while (const auto event = controller.poll()) {
            if (const auto* received = std::get_if<can::Received>(&*event)) return received->frame;
        }
        pollfd descriptor{controller.event_fd(), POLLIN, 0};
        ::poll(&descriptor, 1, -1);
    }
}

void send(can::Controller& controller, const can::Frame& frame) {
    if (!std::holds_alternative<can::TransmitHandle>(controller.send(frame))) {
        throw std::runtime_error{"the controller takes no frame"};
    }
}

RequestId id_of(const can::Frame& request) {
    return read_be16(request.data.data() + giop::request_id_offset);
}

void answer_frames(const std::string& path) {
    pin_to(1);
    const auto controller = attach(path, "pong", request(0).id);
    for (;;) send(*controller, reply(id_of(receive(*controller))));
}

Statistics bare_ping_pong(const std::string& path, std::size_t round_trips) {
    const Child server{[&] { answer_frames(path); }};
    pin_to(0);
    const auto controller = attach(path, "ping", reply(0).id);
    std::this_thread::sleep_for(100ms);  // until the other one listens
    Statistics times{round_trips};
    for (std::size_t i = 0; i < round_trips; ++i) {
        const auto id = static_cast<RequestId>(i);
        const TimePoint begin = can::monotonic_now();
        send(*controller, request(id));
        if (id_of(receive(*controller)) != id) throw std::runtime_error{"not its answer"};
        times.add(can::monotonic_now() - begin);
    }
    pin_to(-1);
    return times;
}

Statistics calls(const std::string& address, std::size_t round_trips) {
    const Child server{[&] { serve_device(address, server_node.value(), 1); }};
    pin_to(0);
    const auto bus = open_bus(address);
    Orb client{*bus, {.node = client_node.value()}};
    const auto device = device_at(client, server_node.value());
    await(device);
    Statistics times = time_calls(device, round_trips);
    pin_to(-1);
    return times;
}

/// Of request and reply back to back, intermissions included, on the average of all request ids.
double wire_time(std::uint32_t bitrate) {
    std::uint64_t bits = 0;
    constexpr std::uint32_t ids = 65'536;
    for (std::uint32_t id = 0; id < ids; ++id) {
        bits += can::frame_length(request(static_cast<RequestId>(id))) +
                can::frame_length(reply(static_cast<RequestId>(id)));
    }
    return static_cast<double>(bits) / ids / bitrate * 1e9;
}

nlohmann::json round_trips(std::uint32_t bitrate, bool quick) {
    progress("round trips at " + std::to_string(bitrate) + " bit/s");
    const double wire = wire_time(bitrate);
    const auto count = static_cast<std::size_t>((quick ? 0.3e9 : 2e9) / wire);
    // By turns, so that both have the same machine; the better of each, as noise only adds.
    constexpr int rounds = 3;
    nlohmann::json frames;
    nlohmann::json orb;
    for (int i = 0; i < rounds; ++i) {
        const auto with_daemon = [&](auto measure) {
            // One for each: it begins with a clock that has not slipped.
            const Daemon daemon{bitrate, true, 1};
            return measure(daemon).json();
        };
        const auto bare =
            with_daemon([&](const Daemon& daemon) { return bare_ping_pong(daemon.path(), count); });
        const auto called =
            with_daemon([&](const Daemon& daemon) { return calls(daemon.address(), count); });
        if (i == 0 || bare["mean_ns"] < frames["mean_ns"]) frames = bare;
        if (i == 0 || called["mean_ns"] < orb["mean_ns"]) orb = called;
    }
    const double of_frames = frames["mean_ns"];
    const double of_calls = orb["mean_ns"];
    return {{"bitrate", bitrate},
            {"wire_ns", wire},
            {"bare_frames", frames},
            {"calls", orb},
            {"calls_to_bare_frames", of_frames / of_calls},
            {"wire_part_of_call", wire / of_calls},
            {"software_ns", of_calls - wire}};
}

/// Clients that do nothing but call, each its own server.
nlohmann::json pairs(int count, bool quick) {
    progress(std::to_string(count) + " clients and their servers at 1 Mbit/s");
    constexpr std::uint32_t bitrate = 1'000'000;
    const Daemon daemon{bitrate, true, 1};
    std::vector<std::unique_ptr<Child>> children;
    const auto client = [&](int node) {
        pin_to(0);
        const auto bus = open_bus(daemon.address());
        Orb orb{*bus, {.node = node}};
        const auto device = device_at(orb, node + count);
        await(device);
        for (;;) device.ping();
    };
    for (int i = 1; i <= count; ++i) {
        children.push_back(
            std::make_unique<Child>([&] { serve_device(daemon.address(), i + count, 0); }));
        children.push_back(std::make_unique<Child>([&client, i] { client(i); }));
    }
    std::this_thread::sleep_for(500ms);
    const auto report = [&] {
        auto got = can::request_bus_report({daemon.path()});
        if (!got) throw std::runtime_error{got.error().reason};
        return std::move(*got);
    };
    const TimePoint begin = can::monotonic_now();
    const can::BusReport from = report();
    std::this_thread::sleep_for(quick ? 1s : 5s);
    const can::BusReport to = report();
    const std::chrono::duration<double> elapsed = can::monotonic_now() - begin;
    for (const auto& child : children) {
        if (!child->is_running()) throw std::runtime_error{"a client or a server has ended"};
    }
    // Of the machine's time: a bus that falls behind is not busy.
    const double bits = elapsed.count() * bitrate;
    const double busy = static_cast<double>(to.bus.busy_bits - from.bus.busy_bits);
    const double frames = static_cast<double>(to.bus.frames - from.bus.frames);
    return {{"pairs", count},
            {"bitrate", bitrate},
            {"load_percent", 100 * busy / bits},
            {"calls_per_second", frames / 2 / elapsed.count()}};
}

}  // namespace

nlohmann::json on_the_paced_bus(bool quick) {
    nlohmann::json result;
    for (const std::uint32_t bitrate : bitrates) {
        if (quick && bitrate != 125'000 && bitrate != 1'000'000) continue;
        result["round_trips"].push_back(round_trips(bitrate, quick));
    }
    for (const int count : {1, 2, 4}) result["pairs"].push_back(pairs(count, quick));
    return result;
}

}  // namespace canorb::bench
