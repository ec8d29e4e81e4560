#include "rtps_datagram.hpp"

#include <algorithm>
#include <span>
#include <string>
#include <string_view>

namespace peers {

namespace {

constexpr std::size_t header_size = 20;  // of the datagram
constexpr std::size_t submessage_header_size = 4;
constexpr std::size_t guid_prefix_begin = 8;
constexpr std::size_t guid_prefix_size = 12;
// From the begin of a submessage.
constexpr std::size_t data_writer_id_begin = 12;
constexpr std::size_t acknack_writer_id_begin = 8;
constexpr std::size_t destination_prefix_begin = 4;

enum Kind : std::uint8_t {
    acknack = 0x06,
    heartbeat = 0x07,
    gap = 0x08,
    info_timestamp = 0x09,
    info_destination = 0x0E,
    data = 0x15,
    statistics = 0x80,  // from here on, vendors' own
};

std::string name(std::uint8_t kind) {
    switch (kind) {
        case acknack:
            return "ACKNACK";
        case heartbeat:
            return "HEARTBEAT";
        case gap:
            return "GAP";
        case info_timestamp:
            return "INFO_TS";
        case info_destination:
            return "INFO_DST";
        case data:
            return "DATA";
        case statistics:
            return "STATISTICS";
        default:
            return "0x" + to_hex(std::array{kind});
    }
}

Guid make_guid(std::span<const std::uint8_t> prefix, std::span<const std::uint8_t> entity) {
    Guid guid{};
    std::copy(entity.begin(), entity.end(), std::copy(prefix.begin(), prefix.end(), guid.begin()));
    return guid;
}

}  // namespace

std::optional<RtpsDatagram> parse_rtps(const Octets& datagram) {
    if (datagram.size() < header_size) return std::nullopt;
    if (std::string_view{reinterpret_cast<const char*>(datagram.data()), 4} != "RTPS") {
        return std::nullopt;
    }
    const std::span all{datagram};
    const auto source = all.subspan(guid_prefix_begin, guid_prefix_size);
    std::span<const std::uint8_t> destination;
    RtpsDatagram result;
    std::size_t begin = header_size;
    while (begin + submessage_header_size <= datagram.size()) {
        const std::uint8_t kind = datagram[begin];
        const bool little_endian = (datagram[begin + 1] & 1) != 0;
        std::size_t size = read_unsigned(datagram, begin + 2, 2, little_endian);
        // The last one may leave out its size.
        size = size == 0 && kind != info_timestamp ? datagram.size() - begin
                                                   : size + submessage_header_size;
        if (begin + size > datagram.size()) return std::nullopt;
        const std::span submessage{datagram.data() + begin, size};
        if (kind == info_destination && size >= destination_prefix_begin + guid_prefix_size) {
            destination = submessage.subspan(destination_prefix_begin, guid_prefix_size);
        } else if (kind == data && !result.writer && size >= data_writer_id_begin + 4) {
            result.writer = make_guid(source, submessage.subspan(data_writer_id_begin, 4));
        } else if (kind == acknack && !result.acknowledged && !destination.empty() &&
                   size >= acknack_writer_id_begin + 4) {
            result.acknowledged =
                make_guid(destination, submessage.subspan(acknack_writer_id_begin, 4));
        }
        result.submessages.push_back({kind, size});
        begin += size;
    }
    if (begin != datagram.size()) return std::nullopt;
    return result;
}

std::size_t statistics_octets(const RtpsDatagram& datagram) {
    std::size_t sum = 0;
    for (const auto& submessage : datagram.submessages) {
        if (submessage.kind == statistics) sum += submessage.octets;
    }
    return sum;
}

nlohmann::ordered_json to_json(const std::vector<Submessage>& submessages) {
    nlohmann::ordered_json list = {{{"kind", "header"}, {"octets", header_size}}};
    for (const auto& submessage : submessages) {
        list.push_back({{"kind", name(submessage.kind)}, {"octets", submessage.octets}});
    }
    return list;
}

}  // namespace peers
