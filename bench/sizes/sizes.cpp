// How many octets, frames and bits each operation of bench/operations.idl takes, request and reply,
// in GIOP/CAN as two Orbs send it on a simulated bus; and what messages of others would take there.
//
//     sizes [--peers FILE]
//
// FILE is what peer_omniorb and peer_fastdds captured, put together by ./run bench: a JSON object
// of protocols, of operations with `request` and `reply`, with the octets of the message in `hex`.
// Each is put into CAN frames by ISO-TP, bit by bit as it was captured.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <fstream>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

#include "bench/device.hpp"
#include "bench/peers/octets.hpp"
#include "can_cost.hpp"
#include "canorb/simulation.hpp"
#include "orb/caniop/identifier.hpp"
#include "published_formats.hpp"

namespace canorb::bench {
namespace {

using Json = nlohmann::ordered_json;
using namespace std::chrono_literals;

std::vector<std::uint8_t> from_hex(const std::string& text) {
    std::vector<std::uint8_t> octets;
    for (std::size_t i = 0; i + 1 < text.size(); i += 2) {
        octets.push_back(static_cast<std::uint8_t>(std::stoul(text.substr(i, 2), nullptr, 16)));
    }
    return octets;
}

/// A message in the frames that were seen on the bus.
class SeenMessage {
  public:
    void add(const can::Frame& frame) {
        const Bytes payload = frame.payload();
        // The first frame begins with the message, the others with a sequence octet.
        const Bytes octets = frames_.empty() ? payload : payload.subspan(1);
        message_.insert(message_.end(), octets.begin(), octets.end());
        sequence_octets_ += payload.size() - octets.size();
        frames_.push_back(frame);
    }
    bool empty() const { return frames_.empty(); }

    /// `header`: octets of the message that are not values.
    Json json(std::size_t header) const {
        if (empty()) return nullptr;
        Json result{{"octets", message_.size()},
                    {"header_octets", header},
                    {"sequence_octets", sequence_octets_},
                    {"hex", peers::to_hex(message_)}};
        result["can"] = cost_of(frames_).json();
        return result;
    }

  private:
    std::vector<can::Frame> frames_;
    std::vector<std::uint8_t> message_;
    std::size_t sequence_octets_ = 0;
};

struct Operation {
    std::string name;
    std::function<void()> call;
    Values values;
};

/// Two nodes on one bus: node 1 calls node 2.
class World {
  public:
    World() {
        server_.root_poa().activate_object_with_id(1, servant_);
        own_ = client_.root_poa()
                   .activate_object_with_id(1, own_servant_)
                   .unchecked_narrow<::Bench::Device>();
        bus_.on_frame([this](const can::Frame& frame, TimePoint) {
            const bool is_request = frame.id == request_id_;
            (is_request ? request_ : reply_).add(frame);
        });
    }

    Json measure() {
        Json result;
        for (const Operation& operation : operations()) {
            request_ = {};
            reply_ = {};
            operation.call();
            simulation_.run_for(10ms);  // a oneway call is still on its way
            Json& row = result[operation.name];
            row["request"] = request_.json(request_header);
            row["reply"] = reply_.json(reply_header);
            row["canopen_sdo_calculated"] = with_canopen(operation.values);
            row["cyphal_calculated"] = with_cyphal(operation.values);
        }
        return result;
    }

  private:
    static constexpr std::size_t request_header = 8;
    static constexpr std::size_t reply_header = 6;

    template <typename Exception>
    std::function<void()> raising(void (::Bench::Device::*operation)() const) {
        return [this, operation] {
            try {
                (device_.*operation)();
            } catch (const Exception&) {
                return;
            }
            throw std::runtime_error{"no exception"};
        };
    }

    std::vector<Operation> operations() {
        const std::string text = "abcdefghabcdefghabcdefghabcdefghabcdefghabcdefghabcdefghabcdefgh";
        ::Bench::Block block;
        for (std::size_t i = 0; i < 256; ++i) block.push_back(static_cast<std::uint8_t>(i * 7));
        return {
            {"ping", [this] { device_.ping(); }, {}},
            {"set_attribute_ul",
             [this] { device_.SetAttributeValueUL("TemperatureSetPoint", 7, 1500); },
             {.request = 8, .strings = 19}},
            {"read", [this] { static_cast<void>(device_.read()); }, {.reply = 4}},
            {"push", [this] { device_.push(1025, 21.5F); }, {.request = 6, .answered = false}},
            {"get_level", [this] { static_cast<void>(device_.level()); }, {.reply = 4}},
            {"set_level", [this] { device_.level(0.75F); }, {.request = 4}},
            {"status", [this] { static_cast<void>(device_.status()); }, {.reply = 1}},
            {"rename_64", [this, text] { device_.rename(text); }, {.strings = 64}},
            {"load_256", [this, block] { device_.load(block); }, {.long_ones = 256}},
            {"limits",
             [this] {
                 float low = 0;
                 float high = 0;
                 device_.limits(low, high);
             },
             {.reply = 8}},
            {"user_exception",
             [this] {
                 try {
                     static_cast<void>(device_.convert(9));
                 } catch (const ::Bench::NoSuchChannel&) {
                     return;
                 }
                 throw std::runtime_error{"no exception"};
             },
             {.request = 2, .reply = 2, .raises = true}},
            {"system_exception",
             raising<NO_PERMISSION>(&::Bench::Device::forbidden),
             {.raises = true}},
            {"attach_nil", [this] { device_.attach(::Bench::Device{}); }, {.request = 4}},
            {"attach_reference", [this] { device_.attach(own_); }, {.request = 4}},
        };
    }

    const std::uint32_t request_id_ = caniop::Identifier::to_node(NodeId{2}, NodeId{1}).can_id();
    Simulation simulation_;
    SimulatedBus& bus_ = simulation_.add_bus({.bitrate = 1'000'000});
    DeviceImpl servant_;
    DeviceImpl own_servant_;
    Orb server_{bus_, {.node = 2}};
    Orb client_{bus_, {.node = 1}};
    ::Bench::Device device_ =
        client_.string_to_object("corbaloc:caniop:2/1").unchecked_narrow<::Bench::Device>();
    ::Bench::Device own_;
    SeenMessage request_;
    SeenMessage reply_;
};

/// Adds what the captured messages would cost on CAN.
Json over_can(const Json& peers) {
    Json result = peers;
    for (auto& protocol : result) {
        for (auto& operation : protocol) {
            for (auto& message : operation) {
                if (!message.is_object() || !message.contains("hex")) continue;
                const auto octets = from_hex(message["hex"]);
                message["can"] = cost_of(over_iso_tp(octets)).json();
                // Debian's Fast DDS puts a submessage of its own at the end.
                if (!message.contains("octets_without_statistics")) continue;
                const Bytes without =
                    Bytes{octets}.first(message["octets_without_statistics"].get<std::size_t>());
                message["can_without_statistics"] = cost_of(over_iso_tp(without)).json();
            }
        }
    }
    return result;
}

Json read_json(const std::string& path) {
    std::ifstream file{path};
    if (!file) throw std::runtime_error{"cannot read " + path};
    return Json::parse(file);
}

}  // namespace
}  // namespace canorb::bench

int main(int argc, char** argv) {
    using namespace canorb::bench;
    CLI::App app{"Octets, frames and bits of each operation; one JSON object"};
    std::string peers;
    app.add_option("--peers", peers, "Captured messages of others, as a JSON file");
    CLI11_PARSE(app, argc, argv);
    try {
        Json result{{"giop_can", World{}.measure()}};
        if (!peers.empty()) result["others_over_iso_tp"] = over_can(read_json(peers));
        std::cout << result.dump(2) << '\n';
    } catch (const std::exception& exception) {
        std::fprintf(stderr, "sizes: %s\n", exception.what());
        return 1;
    }
}
