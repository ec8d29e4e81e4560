#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "orb/base/result.hpp"
#include "orb/base/time.hpp"
#include "orb/can/record/record_file.hpp"
#include "orb/can/sim/bus.hpp"

namespace canorb::can {

struct PcapngOptions {
    std::string interface = "can0";  ///< the interface's name
    std::uint32_t bitrate = 0;       ///< of the interface, bit/s; 0: not told
    Duration unix_time_offset{0};    ///< from the bus's clock to Unix time
};

/// Writes the frames and errors of a simulated bus as pcapng (draft-ietf-opsawg-pcapng) for
/// Wireshark and tshark: link type LINKTYPE_CAN_SOCKETCAN, times in nanoseconds. Each packet has a
/// comment, such as "pump-3, 115 bits on the wire, 7 stuff bits, 2 nodes lost the arbitration".
///
///     auto pcapng = PcapngWriter::create("bus.pcapng");
///     bus.set_trace([&](const auto& completed) {
///         (*pcapng)->frame(completed, bus.name(completed.sender));
///     });
///
/// Not safe for use by two threads at once.
class PcapngWriter {
  public:
    /// Makes the file, or empties it. The error is a sentence for people.
    static Result<std::unique_ptr<PcapngWriter>, std::string> create(
        const std::string& path, const PcapngOptions& options = {});

    /// A frame, at the end of its EOF. `sender` is its name; empty: its number is written.
    void frame(const sim::CompletedFrame& completed, std::string_view sender);

    /// An error as SocketCAN reports it, an error frame whose flags and octets are those of
    /// linux/can/error.h. Errors that are not `primary` are left out. `node` is its name as above.
    void error(const sim::NodeError& error, std::string_view node);

    /// Writes everything so far. It does so itself every 64 KiB and at its end.
    void flush() { file_.flush(); }

    /// What went wrong first when writing, a sentence for people; empty when nothing did. From then
    /// on everything is lost.
    const std::string& error() const { return file_.error(); }

  private:
    PcapngWriter(RecordFile file, const PcapngOptions& options);

    RecordFile file_;
    Duration unix_time_offset_;
};

}  // namespace canorb::can
