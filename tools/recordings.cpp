#include "tools/recordings.hpp"

#include <array>
#include <filesystem>
#include <system_error>
#include <utility>

#include "orb/can/candump.hpp"

namespace canorb::tools {
namespace {

constexpr const char* interface = "can0";

}  // namespace

std::optional<std::string> RecordingFiles::shared() const {
    const std::array<const std::string*, 3> paths{&log, &vcd, &pcapng};
    for (std::size_t i = 0; i < paths.size(); ++i) {
        if (paths[i]->empty()) continue;
        for (std::size_t j = i + 1; j < paths.size(); ++j) {
            std::error_code error;
            const auto one = std::filesystem::weakly_canonical(*paths[i], error);
            const auto other = std::filesystem::weakly_canonical(*paths[j], error);
            if (*paths[i] == *paths[j] || (!error && one == other)) return *paths[i];
        }
    }
    return std::nullopt;
}

Result<std::unique_ptr<Recordings>, std::string> Recordings::start(can::sim::Bus& bus,
                                                                   const RecordingFiles& files,
                                                                   Duration unix_time_offset,
                                                                   Complain complain) {
    std::unique_ptr<Recordings> recordings{
        new Recordings{bus, unix_time_offset, std::move(complain)}};
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
        options.interface = interface;
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

void Recordings::frame(const can::sim::CompletedFrame& completed) {
    if (log_) {
        log_->append(
            can::format_candump(completed.time + unix_time_offset_, interface, completed.frame) +
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
