#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "orb/base/bytes.hpp"
#include "orb/can/controller.hpp"

/// What a client and the bus daemon say to each other: doc/wire/sim-bus.md. One value is one
/// packet on the socket. The same functions serve both ends.
namespace canorb::can::sim {

/// Grows with every change that an older peer would misunderstand.
inline constexpr std::uint8_t protocol_version = 1;

/// Octets in the longest packet.
inline constexpr std::size_t max_packet_size = 512;
inline constexpr std::size_t max_client_name = 32;
inline constexpr std::size_t max_refusal_reason = 400;
inline constexpr std::size_t max_packet_filters = 56;

/// A client's first packet. Of another version than ours nothing but `version` is known.
struct Hello {
    std::uint8_t version = protocol_version;
    /// Only asks whether it would be welcome: no controller, the daemon closes after the answer.
    bool query = false;
    std::string client_name;  ///< printable ASCII, at most max_client_name
};

/// What a client asks for after its hello. `time` is when, on CLOCK_MONOTONIC: a bus that is paced
/// by that clock lets it happen then, in the order of all clients' times, however late the daemon
/// gets to it.
struct SendRequest {
    TimePoint time;
    TransmitHandle handle{};
    SendOptions options;
    Frame frame;
};

struct AbortRequest {
    TimePoint time;
    TransmitHandle handle{};
};

struct FilterRequest {
    TimePoint time;
    std::vector<Filter> filters;  ///< at most max_packet_filters
};

struct ListenOnlyRequest {
    TimePoint time;
    bool on = false;
};

struct RecoverRequest {
    TimePoint time;
};

using ClientPacket = std::variant<Hello, SendRequest, AbortRequest, FilterRequest,
                                  ListenOnlyRequest, RecoverRequest>;

/// The client has a controller now.
struct Welcome {
    bool paced = true;  ///< by the real clock; else bus time moves by frames only
    std::uint32_t bitrate = 0;
    std::uint16_t mailboxes = 0;
    std::uint16_t filter_list = 0;
};

/// The client has none; the daemon closes the connection.
struct Refusal {
    std::uint8_t version = protocol_version;  ///< the daemon's
    std::string reason;                       ///< a sentence, at most max_refusal_reason
};

using ServerPacket =
    std::variant<Welcome, Refusal, Received, TransmitResult, StateChanged, FramesLost>;

/// A packet's octets.
class Packet {
  public:
    Bytes bytes() const { return Bytes{octets_.data(), size_}; }

    void put8(std::uint8_t value);
    void put16(std::uint16_t value);
    void put32(std::uint32_t value);
    void put64(std::uint64_t value);
    void put_text(std::string_view text);

  private:
    std::array<std::uint8_t, max_packet_size> octets_;
    std::size_t size_ = 0;
};

/// Too long names and reasons are cut; more filters than fit are a programming error.
Packet encode(const ClientPacket& packet);
Packet encode(const ServerPacket& packet);

/// Nothing when the octets are no such packet, whole and with nothing behind it.
std::optional<ClientPacket> parse_client_packet(Bytes octets);
std::optional<ServerPacket> parse_server_packet(Bytes octets);

}  // namespace canorb::can::sim
