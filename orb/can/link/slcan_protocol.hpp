#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>

#include "orb/can/controller.hpp"
#include "orb/can/frame.hpp"

/// The LAWICEL serial protocol, as far as the slcan: link uses it: doc/wire/slcan.md. Text <->
/// values, without input or output.
namespace canorb::can::slcan {

/// Of the command S0 to S8, in bit/s.
inline constexpr std::array<std::uint32_t, 9> bitrates{10'000,  20'000,  50'000,  100'000,  125'000,
                                                       250'000, 500'000, 800'000, 1'000'000};

/// 'n' of the command "Sn"; nothing for a bit rate that it does not have.
std::optional<char> bitrate_digit(std::uint32_t bitrate);

/// Ends what the host or an earlier one began, and closes the channel. Each part may be answered
/// with CR, BEL or nothing.
inline constexpr std::string_view flush_command = "\r\r\rC\r";
inline constexpr std::string_view close_command = "C\r";
inline constexpr std::string_view open_command = "O\r";
inline constexpr std::string_view listen_command = "L\r";
inline constexpr std::string_view version_command = "V\r";
inline constexpr std::string_view flags_command = "F\r";
inline constexpr std::string_view auto_poll_command = "X1\r";

/// "T1FFFFFFF81122334455667788" and a CR.
inline constexpr std::size_t longest_command = 27;

/// One command, with its CR.
class Command {
  public:
    Command() = default;
    void append(char character) { text_[size_++] = character; }
    /// The lowest 4 * `digits` bits of `value`, highest digit first.
    void append_hex(std::uint32_t value, unsigned digits);
    std::string_view text() const { return {text_.data(), size_}; }

  private:
    std::array<char, longest_command> text_{};
    std::size_t size_ = 0;
};

/// "Sn". `bitrate` is one of `bitrates`.
Command bitrate_command(std::uint32_t bitrate);

/// "t", "T", "r" or "R". A classic data or remote frame.
Command transmit_command(const Frame& frame);

/// CR, "z" or "Z": done as the command said.
struct Done {};
/// BEL: not done. `cut_line`: it came in the middle of a line.
struct Refused {
    bool cut_line = false;
};
/// "Vhhss", the answer to "V".
struct Version {};
/// "Fxx", the answer to "F".
struct Flags {
    static constexpr std::uint8_t receive_fifo_full = 0x01;
    static constexpr std::uint8_t data_overrun = 0x08;
    static constexpr std::uint8_t error_passive = 0x20;

    std::uint8_t bits = 0;
};
/// A line that is known and says nothing here: a command of another host, error details.
struct Ignored {};
/// No line of the protocol, or one that is too long: a frame may have been in it.
struct Malformed {};

/// What a peer says: a frame, an answer, or ("saRRRTTT" and so on) its state.
using Message = std::variant<Frame, Done, Refused, Version, Flags, ErrorStatus, Ignored, Malformed>;

/// A line without its CR.
Message parse_line(std::string_view line);

/// Makes messages of octets, however they are cut. Anything may come.
class Receiver {
  public:
    /// The message that ends with this octet.
    std::optional<Message> add(char octet);
    void reset() { size_ = 0; }

  private:
    /// Longer than any line that matters; the text of a version may be longer than its 4 digits.
    static constexpr std::size_t longest_line = 64;

    std::array<char, longest_line> line_{};
    std::size_t size_ = 0;  ///< longest_line + 1: too long
};

}  // namespace canorb::can::slcan
