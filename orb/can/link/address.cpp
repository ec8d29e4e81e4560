#include "orb/can/link/address.hpp"

#include <sys/un.h>

#include <algorithm>
#include <cctype>
#include <charconv>

#include "orb/can/link/link.hpp"
#include "orb/can/link/serial_port.hpp"
#include "orb/can/link/slcan_protocol.hpp"
#include "orb/can/sim/bus.hpp"

namespace canorb::can {
namespace {

constexpr std::string_view local_scheme = "local:";
constexpr std::string_view sim_scheme = "sim:";
constexpr std::string_view socketcan_scheme = "socketcan:";
constexpr std::string_view slcan_scheme = "slcan:";
constexpr std::string_view bitrate_option = "bitrate=";
constexpr std::string_view baud_option = "baud=";
constexpr std::size_t longest_interface_name = 15;  // IFNAMSIZ - 1
constexpr std::size_t longest_socket_path = sizeof(sockaddr_un{}.sun_path) - 1;

std::string quoted(std::string_view text) {
    return "\"" + std::string{text} + "\"";
}

/// The error is a sentence for people.
std::optional<std::string> set_local_option(LocalAddress& address, std::string_view option) {
    if (option.starts_with(bitrate_option)) {
        const auto bitrate = parse_bitrate(option.substr(bitrate_option.size()));
        if (!bitrate) return bitrate.error();
        address.bitrate = *bitrate;
    } else if (option == "paced=yes" || option == "paced=no") {
        address.paced = option == "paced=yes";
    } else {
        return "local: has no option " + quoted(option) +
               "; it knows bitrate=BITS_PER_SECOND and paced=no";
    }
    return std::nullopt;
}

Result<BusAddress, std::string> parse_local(std::string_view rest) {
    LocalAddress address;
    const std::size_t mark = rest.find('?');
    address.name = std::string{rest.substr(0, mark)};
    if (address.name.empty()) {
        return Failure{std::string{"local: needs a name for the bus, for example local:test"}};
    }
    std::string_view options =
        mark == std::string_view::npos ? std::string_view{} : rest.substr(mark + 1);
    while (mark != std::string_view::npos) {
        const std::size_t end = options.find('&');
        if (auto problem = set_local_option(address, options.substr(0, end))) {
            return Failure{std::move(*problem)};
        }
        if (end == std::string_view::npos) break;
        options.remove_prefix(end + 1);
    }
    return BusAddress{address};
}

Result<BusAddress, std::string> parse_sim(std::string_view path) {
    if (path.empty()) {
        return Failure{"sim: needs the path of the bus's socket, for example " +
                       std::string{default_bus_address()}};
    }
    if (path.size() > longest_socket_path) {
        return Failure{
            "the path in sim:" + std::string{path} + " has " + std::to_string(path.size()) +
            " characters; a Unix socket's path has at most " + std::to_string(longest_socket_path)};
    }
    if (path.find('\0') != std::string_view::npos) {
        return Failure{std::string{"the path after sim: contains a NUL character"}};
    }
    return BusAddress{SimAddress{std::string{path}}};
}

Result<BusAddress, std::string> parse_socketcan(std::string_view interface) {
    bool valid = !interface.empty() && interface.size() <= longest_interface_name &&
                 interface != "." && interface != "..";
    for (const char c : interface) {
        const auto octet = static_cast<unsigned char>(c);
        if (c == '/' || c == ':' || std::isgraph(octet) == 0) valid = false;
    }
    if (!valid) {
        return Failure{quoted(interface) + " is not the name of a network interface: socketcan: " +
                       "takes 1 to " + std::to_string(longest_interface_name) +
                       " characters without blanks, '/' and ':', for example socketcan:can0"};
    }
    return BusAddress{SocketCanAddress{std::string{interface}}};
}

/// 0 when it is no number.
std::uint32_t number(std::string_view text) {
    std::uint32_t value = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    return error == std::errc{} && stop == end ? value : 0;
}

/// The error is a sentence for people.
std::optional<std::string> set_slcan_option(SlcanAddress& address, std::string_view option) {
    if (option.starts_with(bitrate_option)) {
        option.remove_prefix(bitrate_option.size());
        address.bitrate = number(option);
        if (!slcan::bitrate_digit(address.bitrate)) {
            std::string problem = quoted(option) + " is not a bit rate of slcan:; it has";
            for (const std::uint32_t bitrate : slcan::bitrates) {
                problem += ' ' + std::to_string(bitrate);
            }
            return problem;
        }
    } else if (option.starts_with(baud_option)) {
        option.remove_prefix(baud_option.size());
        address.baud = number(option);
        if (!is_baud(address.baud)) {
            return quoted(option) + " is not a speed of serial lines, such as 115200";
        }
    } else if (option == "answers=yes" || option == "answers=no") {
        address.answers = option == "answers=yes";
    } else {
        return "slcan: has no option " + quoted(option) +
               "; it knows bitrate=BITS_PER_SECOND, baud=BITS_PER_SECOND and answers=no";
    }
    return std::nullopt;
}

Result<BusAddress, std::string> parse_slcan(std::string_view rest) {
    SlcanAddress address;
    const std::size_t mark = rest.find('?');
    address.device = std::string{rest.substr(0, mark)};
    if (address.device.empty() || address.device.find('\0') != std::string::npos) {
        return Failure{std::string{"slcan: needs a serial port, for example slcan:/dev/ttyACM0"}};
    }
    if (mark == std::string_view::npos) return BusAddress{address};
    std::size_t begin = mark + 1;
    while (true) {
        const std::size_t end = std::min(rest.find('&', begin), rest.size());
        if (auto problem = set_slcan_option(address, rest.substr(begin, end - begin))) {
            return Failure{*problem};
        }
        if (end == rest.size()) return BusAddress{address};
        begin = end + 1;
    }
}

}  // namespace

Result<std::uint32_t, std::string> parse_bitrate(std::string_view text) {
    const std::uint32_t value = number(text);
    if (value < sim::Bus::lowest_bitrate || value > sim::Bus::highest_bitrate) {
        return Failure{quoted(text) + " is not a bit rate: a number from " +
                       std::to_string(sim::Bus::lowest_bitrate) + " to " +
                       std::to_string(sim::Bus::highest_bitrate) + " (bit/s)"};
    }
    return value;
}

Result<BusAddress, std::string> parse_bus_address(std::string_view address) {
    if (address.starts_with(local_scheme)) return parse_local(address.substr(local_scheme.size()));
    if (address.starts_with(sim_scheme)) return parse_sim(address.substr(sim_scheme.size()));
    if (address.starts_with(socketcan_scheme)) {
        return parse_socketcan(address.substr(socketcan_scheme.size()));
    }
    if (address.starts_with(slcan_scheme)) return parse_slcan(address.substr(slcan_scheme.size()));
    return Failure{quoted(address) +
                   " is not a bus address: it begins with none of local:NAME, sim:PATH, "
                   "socketcan:IFNAME, slcan:DEVICE"};
}

}  // namespace canorb::can
