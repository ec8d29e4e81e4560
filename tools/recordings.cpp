#include "tools/recordings.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>
#include <utility>

#include "orb/can/candump.hpp"

namespace canorb::tools {
namespace {

/// Where a file is or would be made: fopen() follows symbolic links to nothing, too.
std::filesystem::path target(const std::string& path) {
    constexpr int most_links = 40;
    std::filesystem::path at{path};
    std::error_code error;
    for (int links = 0; links < most_links; ++links) {
        const auto next = std::filesystem::read_symlink(at, error);
        if (error) break;
        at = at.parent_path() / next;
    }
    const auto canonical = std::filesystem::weakly_canonical(at, error);
    return error ? at : canonical;
}

bool are_same_file(const std::string& one, const std::string& other) {
    struct stat first{};
    struct stat second{};
    const bool first_exists = ::stat(one.c_str(), &first) == 0;
    const bool second_exists = ::stat(other.c_str(), &second) == 0;
    if (first_exists != second_exists) return false;
    if (!first_exists) return target(one) == target(other);
    // What goes to a device such as /dev/null harms nothing there.
    return first.st_dev == second.st_dev && first.st_ino == second.st_ino &&
           !S_ISCHR(first.st_mode);
}

}  // namespace

std::optional<std::string> RecordingFiles::conflict(const std::vector<std::string>& inputs) const {
    const std::array<const std::string*, 3> paths{&log, &vcd, &pcapng};
    for (std::size_t i = 0; i < paths.size(); ++i) {
        if (paths[i]->empty()) continue;
        for (const std::string& input : inputs) {
            if (input.empty() || !are_same_file(*paths[i], input)) continue;
            return "no recording can go to " + *paths[i] + ": " + input + " is read";
        }
        for (std::size_t j = i + 1; j < paths.size(); ++j) {
            if (paths[j]->empty() || !are_same_file(*paths[i], *paths[j])) continue;
            return "only one recording can go to " + *paths[i];
        }
    }
    return std::nullopt;
}

Result<std::unique_ptr<Recordings>, std::string> Recordings::start(can::sim::Bus& bus,
                                                                   const RecordingFiles& files,
                                                                   Duration unix_time_offset,
                                                                   Complain complain) {
    std::unique_ptr<Recordings> recordings{
        new Recordings{bus, files.log_interface, unix_time_offset, std::move(complain)}};
    if (!files.log.empty()) {
        auto log = can::RecordFile::create(files.log);
        if (!log) return Failure{log.error()};
        recordings->log_.emplace(std::move(*log));
    }
    if (!files.vcd.empty()) {
        can::VcdOptions options;
        options.start = bus.now();
        options.comment = std::to_string(bus.bitrate()) + " bit/s";
        auto vcd = can::VcdWriter::create(files.vcd, options);
        if (!vcd) return Failure{vcd.error()};
        recordings->vcd_ = std::move(*vcd);
        bus.set_bit_observer(recordings->vcd_.get());
    }
    if (!files.pcapng.empty()) {
        can::PcapngOptions options;
        options.interface = bus_interface;
        options.bitrate = bus.bitrate();
        options.unix_time_offset = unix_time_offset;
        auto pcapng = can::PcapngWriter::create(files.pcapng, options);
        if (!pcapng) return Failure{pcapng.error()};
        recordings->pcapng_ = std::move(*pcapng);
    }
    return recordings;
}

Recordings::~Recordings() {
    if (vcd_) bus_.set_bit_observer(nullptr);
}

std::string Recordings::log_interface(const can::sim::CompletedFrame& completed) const {
    if (!log_interface_.empty()) return log_interface_;
    std::string name{bus_.name(completed.sender)};
    std::replace(name.begin(), name.end(), ' ', '_');
    return name;
}

void Recordings::frame(const can::sim::CompletedFrame& completed) {
    if (log_) {
        log_->append(can::format_candump(completed.time + unix_time_offset_,
                                         log_interface(completed), completed.frame) +
                     '\n');
        log_->flush();
        check(log_->error(), log_failure_told_);
    }
    if (pcapng_) {
        pcapng_->frame(completed, bus_.name(completed.sender));
        check(pcapng_->error(), pcapng_failure_told_);
    }
    if (vcd_) check_vcd();
}

void Recordings::error(const can::sim::NodeError& error) {
    if (!pcapng_) return;
    pcapng_->error(error, bus_.name(error.node));
    check(pcapng_->error(), pcapng_failure_told_);
}

void Recordings::flush() {
    if (vcd_) {
        vcd_->flush();
        check_vcd();
    }
    if (pcapng_) {
        pcapng_->flush();
        check(pcapng_->error(), pcapng_failure_told_);
    }
}

void Recordings::check_vcd() {
    check(vcd_->error(), vcd_failure_told_);
    if (vcd_->nodes_without_lines() == 0 || lines_missing_told_) return;
    lines_missing_told_ = true;
    complain_("the VCD has lines for " + std::to_string(can::VcdOptions{}.room) +
              " different names of nodes: no others will be in it");
}

void Recordings::check(const std::string& error, bool& told) {
    if (error.empty() || told) return;
    told = true;
    failed_ = true;
    complain_(error);
}

}  // namespace canorb::tools
