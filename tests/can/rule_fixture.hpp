#pragma once

#include <gtest/gtest.h>

#include <string_view>

#include "tests/can/wire.hpp"

namespace canorb::can::sim::test {

/// 0x555 without data, up to its CRC.
inline constexpr std::string_view up_to_crc = "0 10101010101 000 00I00 110011101001100";
inline constexpr std::string_view tail = "1 0 1 1111111";
inline constexpr std::string_view flag = "000000";
inline constexpr std::string_view delimiter_and_intermission = "11111111 111";

/// A processor in what its functions say, beginning with idle.
class Rule : public testing::Test {
  protected:
    int tec() const { return node_.status().tec; }
    int rec() const { return node_.status().rec; }

    void see(std::string_view levels) { feed(node_, levels); }
    void begin_to_send(const Frame& frame = standard(0x555)) { begin(node_, frame); }
    void send_successfully() {
        begin_to_send();
        see(up_to_crc);
        see(tail);
        see("111");
        settle(node_);
    }
    void receive_successfully() {
        see(up_to_crc);
        see(tail);
        see("111");
        settle(node_);
    }
    /// An active error flag, from its start.
    void be_in_error_flag(bool transmitting) {
        if (transmitting) {
            begin_to_send();
            see("1");
        } else {
            see("000000");
        }
    }
    /// An overload flag, from its start.
    void be_in_overload_flag(bool transmitting) {
        if (transmitting) begin_to_send();
        see(up_to_crc);
        see(tail);
        see("0");
    }

    BitStreamProcessor node_ = new_processor();
};

}  // namespace canorb::can::sim::test
