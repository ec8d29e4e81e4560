#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "orb/base/result.hpp"
#include "orb/base/time.hpp"
#include "orb/can/frame_field.hpp"

namespace canorb::can::sim {

/// What goes wrong.
enum class FaultKind : std::uint8_t {
    flip,            ///< nodes sample the opposite level, or the wire has it
    dominant,        ///< nodes sample dominant, or the wire is dominant
    recessive,       ///< nodes sample recessive, or the wire is recessive
    stuck_dominant,  ///< the nodes' transmitters, or the wire, are dominant
    cut_off,    ///< what the nodes send does not reach the wire, and they sample only what they
                ///< send themselves
    reconnect,  ///< ends their cut_off
};

/// Where it goes wrong.
struct FaultTargets {
    enum class Scope : std::uint8_t { wire, each_node, named };
    Scope scope = Scope::wire;
    std::vector<std::string> names{};  ///< where `named`, in the order of the script
};

/// An amount of time as a script gives it.
struct FaultTime {
    std::uint64_t amount = 0;  ///< nanoseconds, or bit times
    bool in_bits = false;

    static constexpr std::uint64_t highest_nanoseconds = 1'000'000'000'000'000'000;
    static constexpr std::uint64_t highest_bits = 1'000'000'000'000;

    /// `bitrate` in bit/s, at least 1'000. Rounded down to nanoseconds.
    Duration at(std::uint32_t bitrate) const;
};

/// A bit of a frame, counted from 1 within its field as text books do.
struct FramePlace {
    enum class Field : std::uint8_t {
        start_of_frame,
        identifier,  ///< 1..11, and 12..29 for the lower part of an extended one
        substitute_remote_request,
        remote_request,
        identifier_extension,
        reserved_1,
        reserved_0,
        data_length_code,  ///< 1..4
        data,              ///< 1..64
        crc,               ///< 1..15
        crc_delimiter,
        ack_slot,
        ack_delimiter,
        end_of_frame,  ///< 1..7
        intermission,  ///< 1..3
        stuff_bit,     ///< 1..29: of the whole frame
        any_bit,       ///< 1..999: from SOF, stuff bits included, on through an error frame and an
                       ///< idle bus, until another frame begins
    };
    Field field = Field::start_of_frame;
    std::uint16_t number = 1;
};

/// As a script writes the place, "data.3" for example; in the same manner where a script has no
/// word for it, as in error frames. A stuff bit is named as the bit before it.
std::string place_name(FramePosition position);

/// At a moment since the start of the bus: in the bit in which it is.
struct AtTime {
    FaultTime first;
    std::optional<FaultTime> period{};  ///< and again after each; not 0
};

/// In each attempt to send a frame that has all of these, at a bit of it.
struct InFrame {
    std::optional<std::uint32_t> id{};  ///< any where there is none
    bool extended = false;              ///< kind of `id`
    std::optional<std::string> sender{};
    std::uint64_t first_attempt = 1;  ///< of those that match, counted from 1
    std::uint64_t last_attempt = UINT64_MAX;
    FramePlace place;
};

/// In bits drawn by lot, independently at each node where it is not the wire's fault.
struct AtRandom {
    std::uint64_t probability = 0;  ///< of each bit, times 2 to the 64; 1 is UINT64_MAX
};

/// One line of a script.
struct Fault {
    std::size_t line = 0;
    std::variant<AtTime, InFrame, AtRandom> trigger;
    FaultKind kind = FaultKind::flip;
    FaultTargets targets;
    /// From the start of the first bit it acts in; nothing: for good.
    std::optional<FaultTime> duration{};
};

/// What is to go wrong on a bus, and when: doc/fault-scripts.md.
struct FaultScript {
    std::uint64_t seed = 1;  ///< of all that is drawn by lot
    std::vector<Fault> faults;
};

struct FaultScriptError {
    std::size_t line = 0;    ///< from 1
    std::size_t column = 0;  ///< from 1, in octets
    std::string message;     ///< what to write
};

/// "3:14: message"
std::string format(const FaultScriptError& error);

/// At most this many errors are reported; where there are more, one after them says so.
inline constexpr std::size_t max_fault_script_errors = 20;

/// All lines of a script; or the first error of each line that has one. Line ends may be LF or
/// CR LF.
Result<FaultScript, std::vector<FaultScriptError>> parse_fault_script(std::string_view text);

}  // namespace canorb::can::sim
