#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "orb/base/result.hpp"

namespace canorb::can {

/// `local:NAME[?bitrate=N][&paced=no]`
struct LocalAddress {
    std::string name;
    std::optional<std::uint32_t> bitrate;
    std::optional<bool> paced;  ///< no: as fast as the machine
};

/// `sim:PATH`
struct SimAddress {
    std::string path;
};

/// `socketcan:IFNAME`
struct SocketCanAddress {
    std::string interface;
};

/// `slcan:DEVICE[?bitrate=N][&baud=N][&answers=no]`
struct SlcanAddress {
    std::string device;               ///< a serial port
    std::uint32_t bitrate = 500'000;  ///< of the CAN bus; one of slcan::bitrates
    std::uint32_t baud = 115'200;     ///< of the serial line
    bool answers = true;              ///< no: the peer answers no command
};

using BusAddress = std::variant<LocalAddress, SimAddress, SocketCanAddress, SlcanAddress>;

/// The error is a sentence for people.
Result<BusAddress, std::string> parse_bus_address(std::string_view address);

/// A bit rate that the simulated bus has, in decimal; the error is a sentence for people.
Result<std::uint32_t, std::string> parse_bitrate(std::string_view text);

}  // namespace canorb::can
