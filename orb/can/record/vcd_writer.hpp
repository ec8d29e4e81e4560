#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "orb/base/result.hpp"
#include "orb/base/time.hpp"
#include "orb/can/record/record_file.hpp"
#include "orb/can/sim/bit_observer.hpp"

namespace canorb::can {

struct VcdOptions {
    TimePoint start{};       ///< the file's time 0
    std::string comment{};   ///< for $comment, for example the bit rate
    std::size_t room = 128;  ///< names of nodes that can have lines, 150 octets of the file each
};

/// Writes what a simulated bus and its nodes do as a Value Change Dump (IEEE 1364-2005, clause 18)
/// for PulseView, GTKWave and sigrok-cli: a wire "bus", and for each node NAME_tx, what it sends,
/// and NAME_rx, what it samples. 0 is dominant; time is in nanoseconds.
///
/// The format declares wires in its header only, but nodes come while the file is written: the
/// header has room for them, and is written over. So the file is whole whenever the program is
/// killed, but for the changes since the last flush().
///
/// NAME is the node's name with every character that is neither letter nor digit as '_', and a
/// number at its end where two nodes have the same one. A node that comes back under the name of
/// one that has gone has its wires again; those of another name it cannot have, for what is in the
/// file would be its own then. So there is room for a number of different names.
///
///     auto vcd = VcdWriter::create("bus.vcd");
///     bus.set_bit_observer(vcd->get());
///
/// sigrok-cli and PulseView take a sample each nanosecond unless told otherwise. Ten in each bit
/// are enough, here at 500 kbit/s:
///
///     sigrok-cli -I vcd:downsample=200 -i bus.vcd -P can:can_rx=bus:nominal_bitrate=500000 -A can
///
/// Not safe for use by two threads at once.
class VcdWriter final : public sim::BitObserver {
  public:
    /// Makes the file, or empties it. The error is a sentence for people; among others the file
    /// must be seekable, not a pipe.
    static Result<std::unique_ptr<VcdWriter>, std::string> create(const std::string& path,
                                                                  const VcdOptions& options = {});

    /// Writes the rest.
    ~VcdWriter() override;

    void node_attached(sim::NodeIndex node, std::string_view name) override;
    void node_detached(sim::NodeIndex node) override;
    void bit(const sim::BusBit& bit) override;

    /// Writes all changes so far, up to the end of the last bit. It does so itself every 64 KiB.
    void flush();

    /// Nodes for which there was no room: they have no lines.
    std::size_t nodes_without_lines() const { return nodes_without_lines_; }

    /// What went wrong first when writing, a sentence for people; empty when nothing did. From then
    /// on everything is lost.
    const std::string& error() const { return file_.error(); }

  private:
    struct Wire {
        explicit Wire(std::size_t number);
        std::string code;
        std::array<std::string, 2> changes;  ///< the lines for a change to 0 and to 1
        std::uint8_t level = 1;
    };
    struct Lines {
        std::string name;
        Wire tx;
        Wire rx;
        bool attached = true;
    };
    using LinesIndex = std::size_t;

    VcdWriter(RecordFile file, const VcdOptions& options);
    void write_header(const VcdOptions& options);
    std::optional<LinesIndex> lines_for(std::string_view name);
    void declare(LinesIndex index);
    void set(Wire& wire, std::uint8_t level, TimePoint time);
    void set_all_recessive(TimePoint time);
    void write_time(TimePoint time);

    RecordFile file_;
    TimePoint start_;
    std::size_t room_;
    std::uint64_t declarations_at_ = 0;
    std::uint64_t initial_values_at_ = 0;
    Wire bus_;
    std::vector<Lines> lines_;                         ///< in the order of the header
    std::vector<std::optional<LinesIndex>> lines_of_;  ///< by NodeIndex
    TimePoint end_;                                    ///< of the last bit
    TimePoint written_;                                ///< the last time stamp in the file
    std::size_t nodes_without_lines_ = 0;
};

}  // namespace canorb::can
