#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "orb/base/result.hpp"
#include "orb/can/record/pcapng_writer.hpp"
#include "orb/can/record/record_file.hpp"
#include "orb/can/record/vcd_writer.hpp"
#include "orb/can/sim/bus.hpp"

namespace canorb::tools {

/// What the bus of a daemon is called in recordings.
inline constexpr const char* bus_interface = "can0";

/// Paths; an empty one is not recorded to.
struct RecordingFiles {
    std::string log;  ///< frames as `candump -l` writes them
    /// What the log has for interface; empty: the name of the sender, with _ for each space.
    std::string log_interface;
    std::string vcd;
    std::string pcapng;

    bool any() const { return !log.empty() || !vcd.empty() || !pcapng.empty(); }

    /// Why this cannot be: two recordings, or one and a file of `inputs` (empty paths are none),
    /// are the same file, under whatever names. A sentence for people.
    std::optional<std::string> conflict(const std::vector<std::string>& inputs) const;
};

/// The files that a simulated bus is recorded to. When one cannot be written any further, that is
/// told at once, and the others go on.
class Recordings {
  public:
    /// Is given a sentence for people.
    using Complain = std::function<void(const std::string&)>;

    /// Makes the files, or empties them. `unix_time_offset` is from the bus's clock to Unix time.
    /// The bus outlives this object. The error is a sentence for people.
    static Result<std::unique_ptr<Recordings>, std::string> start(can::sim::Bus& bus,
                                                                  const RecordingFiles& files,
                                                                  Duration unix_time_offset,
                                                                  Complain complain);
    ~Recordings();
    Recordings(const Recordings&) = delete;
    Recordings& operator=(const Recordings&) = delete;

    // From the bus's traces. The bits it takes itself.
    void frame(const can::sim::CompletedFrame& completed);
    void error(const can::sim::NodeError& error);

    /// Writes what there is so far. A frame is in the log at once.
    void flush();

    /// Whether something could not be written.
    bool failed() const { return failed_; }

  private:
    Recordings(can::sim::Bus& bus, std::string log_interface, Duration unix_time_offset,
               Complain complain)
        : bus_(bus),
          log_interface_(std::move(log_interface)),
          unix_time_offset_(unix_time_offset),
          complain_(std::move(complain)) {}
    std::string log_interface(const can::sim::CompletedFrame& completed) const;
    void check(const std::string& error, bool& told);
    void check_vcd();

    can::sim::Bus& bus_;
    std::string log_interface_;
    Duration unix_time_offset_;
    Complain complain_;
    std::optional<can::RecordFile> log_;
    std::unique_ptr<can::VcdWriter> vcd_;
    std::unique_ptr<can::PcapngWriter> pcapng_;
    bool log_failure_told_ = false;
    bool vcd_failure_told_ = false;
    bool pcapng_failure_told_ = false;
    bool lines_missing_told_ = false;
    bool failed_ = false;
};

}  // namespace canorb::tools
