// Programs that know nothing of canorb read what it records: sigrok-cli, tshark and GTKWave's
// tools.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "orb/can/record/pcapng_writer.hpp"
#include "orb/can/record/vcd_writer.hpp"
#include "orb/can/sim/bus.hpp"
#include "orb/can/sim/controller.hpp"
#include "orb/can/sim/disturbance.hpp"
#include "tests/can/record/record_fixture.hpp"
#include "tests/support/octets.hpp"
#include "tests/support/shell.hpp"

namespace canorb::can {
namespace {

using canorb::test::has_program;
using canorb::test::octets;
using canorb::test::shell;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr int frames_sent = 1'000;

/// What is on the bus in a data frame, as a decoder tells it.
struct DecodedFrame {
    std::uint32_t id = 0;
    bool extended = false;
    std::vector<std::uint32_t> data;
    std::uint32_t crc = 0;
    friend bool operator==(const DecodedFrame&, const DecodedFrame&) = default;
};

void PrintTo(const DecodedFrame& frame, std::ostream* out) {
    *out << std::hex << (frame.extended ? "extended " : "standard ") << frame.id << " [ ";
    for (const std::uint32_t octet : frame.data) *out << octet << ' ';
    *out << "] CRC " << frame.crc;
}

void append_bits(std::string& bits, std::uint32_t value, int width) {
    for (int shift = width - 1; shift >= 0; --shift) bits += (value >> shift) % 2 == 0 ? '0' : '1';
}

/// By long division: the remainder of the bits, followed by 15 zeros, by the CRC's polynomial.
std::uint32_t crc_of(const Frame& frame) {
    std::string bits = "0";
    if (frame.extended) {
        append_bits(bits, frame.id >> 18, 11);
        bits += "11";
        append_bits(bits, frame.id, 18);
        bits += "000";
    } else {
        append_bits(bits, frame.id, 11);
        bits += "000";
    }
    append_bits(bits, frame.length, 4);
    for (const std::uint8_t octet : frame.payload()) append_bits(bits, octet, 8);
    bits.append(15, '0');
    constexpr std::string_view polynomial = "1100010110011001";
    for (std::size_t i = 0; i + 15 < bits.size(); ++i) {
        if (bits[i] == '0') continue;
        for (std::size_t k = 0; k < polynomial.size(); ++k) {
            bits[i + k] = bits[i + k] == polynomial[k] ? '0' : '1';
        }
    }
    return static_cast<std::uint32_t>(std::stoul(bits.substr(bits.size() - 15), nullptr, 2));
}

DecodedFrame as_decoded(const Frame& frame) {
    return {
        frame.id, frame.extended, {frame.payload().begin(), frame.payload().end()}, crc_of(frame)};
}

/// Three nodes on a bus of 500 kbit/s.
class DecoderTest : public RecordTest {
  protected:
    DecoderTest() {
        bus_.set_trace([this](const sim::CompletedFrame& completed) {
            sent_.push_back(completed);
            if (pcapng_) pcapng_->frame(completed, bus_.name(completed.sender));
        });
        bus_.set_error_trace([this](const sim::NodeError& error) {
            if (pcapng_) pcapng_->error(error, bus_.name(error.node));
        });
        for (const char* const name : {"pump-3", "valve", "gauge"}) {
            sim::NodeOptions options;
            options.name = name;
            nodes_.push_back(std::make_unique<sim::Controller>(bus_, options));
            EXPECT_TRUE(nodes_.back()->set_filters(std::array{Filter{}}));
        }
    }

    void record_vcd() {
        auto vcd = VcdWriter::create(path());
        ASSERT_TRUE(vcd) << vcd.error();
        vcd_ = std::move(*vcd);
        bus_.set_bit_observer(vcd_.get());
    }

    void record_pcapng() {
        auto pcapng = PcapngWriter::create(path(), {.bitrate = bus_.bitrate()});
        ASSERT_TRUE(pcapng) << pcapng.error();
        pcapng_ = std::move(*pcapng);
    }

    void send(std::size_t node, const Frame& frame) {
        ASSERT_TRUE(std::holds_alternative<TransmitHandle>(nodes_[node]->send(frame)));
    }

    void run_until_quiet() {
        while (bus_.advance_one()) {
            for (const auto& node : nodes_) {
                while (node->poll()) {
                }
            }
        }
    }

    /// Data frames of both formats from all nodes: bursts in which they compete, with idle time
    /// between them.
    void send_random_frames() {
        std::mt19937 random{1986};
        int waiting = 0;
        for (int i = 0; i < frames_sent; ++i) {
            const auto node = static_cast<std::uint32_t>(random() % nodes_.size());
            Frame frame;
            frame.extended = random() % 2 == 0;
            // Each identifier has one sender: two could not arbitrate.
            frame.id = static_cast<std::uint32_t>(random()) % (frame.extended ? 0x1FFFFFFD : 0x7FD);
            frame.id += node - frame.id % 3 + (frame.id % 3 > node ? 3 : 0);
            frame.length = static_cast<std::uint8_t>(random() % 9);
            const bool is_extreme = random() % 4 == 0;  // many stuff bits
            for (auto& octet : frame.data) {
                octet = static_cast<std::uint8_t>(is_extreme ? (random() % 2) * 255 : random());
            }
            send(node, frame);
            if (++waiting < 8 && random() % 8 != 0) continue;
            waiting = 0;
            run_until_quiet();
            bus_.advance(bus_.now() + Duration{random() % 1'000'000});
        }
        run_until_quiet();
        ASSERT_EQ(sent_.size(), std::size_t{frames_sent});
    }

    /// What sigrok's decoder for CAN makes of a wire of the file.
    std::vector<DecodedFrame> decode(const std::string& file, const std::string& wire) {
        const auto result = shell(
            "sigrok-cli -I vcd:downsample=200 -i " + file + " -P can:can_rx=" + wire +
            ":nominal_bitrate=500000 -A can=id:full-id:ide:data:crc-sequence:warnings 2>/dev/null");
        EXPECT_EQ(result.exit_code, 0);
        std::vector<DecodedFrame> frames;
        DecodedFrame frame;
        std::istringstream lines{result.output};
        for (std::string line; std::getline(lines, line);) {
            const std::size_t at = line.rfind("0x");
            const auto value =
                at == std::string::npos
                    ? 0U
                    : static_cast<std::uint32_t>(std::stoul(line.substr(at), nullptr, 16));
            const auto begins = [&line](std::string_view text) {
                return line.starts_with("can-1: " + std::string{text});
            };
            if (begins("Identifier:")) {
                frame.id = value;
            } else if (begins("Full Identifier:")) {
                frame.id = value;
            } else if (begins("Identifier extension bit: ")) {
                frame.extended = line.find("extended frame") != std::string::npos;
            } else if (begins("Data byte ")) {
                frame.data.push_back(value);
            } else if (begins("CRC-15 sequence:")) {
                frame.crc = value;
                frames.push_back(frame);
                frame = {};
            } else if (!begins("Identifier bits 10..4 must not be all recessive")) {
                // That was a rule before ISO 11898-1. There is nothing else to complain of.
                ADD_FAILURE() << line;
            }
        }
        return frames;
    }

    std::vector<DecodedFrame> sent() const {
        std::vector<DecodedFrame> frames;
        for (const auto& completed : sent_) frames.push_back(as_decoded(completed.frame));
        return frames;
    }

    std::unique_ptr<VcdWriter> vcd_;  // outlives the bus, as an observer must
    std::unique_ptr<PcapngWriter> pcapng_;
    sim::Bus bus_{500'000};
    std::vector<std::unique_ptr<sim::Controller>> nodes_;
    std::vector<sim::CompletedFrame> sent_;
};

bool has_sigrok() {
    static const bool found = shell("sigrok-cli --show -P can 2>&1").exit_code == 0;
    return found;
}

TEST_F(DecoderTest, SigrokReadsTheFramesOfAVcd) {
    if (!has_sigrok()) GTEST_SKIP() << "sigrok-cli with its decoder for CAN is not installed";
    record_vcd();
    send_random_frames();
    vcd_->flush();
    EXPECT_EQ(decode(path(), "bus"), sent());
    EXPECT_EQ(decode(path(), "valve_rx"), sent());
}

TEST_F(DecoderTest, SigrokReadsAVcdWhoseWriterWasKilled) {
    if (!has_sigrok()) GTEST_SKIP() << "sigrok-cli with its decoder for CAN is not installed";
    record_vcd();
    send_random_frames();
    const std::string file = path() + ".vcd";
    std::filesystem::copy_file(path(), file);  // without what was not written yet
    std::vector<DecodedFrame> frames = decode(file, "bus");
    EXPECT_GT(frames.size(), 100U);
    EXPECT_LT(frames.size(), std::size_t{frames_sent});
    auto first_ones = sent();
    first_ones.resize(frames.size());
    EXPECT_EQ(frames, first_ones);
}

TEST_F(DecoderTest, GtkwaveReadsAVcd) {
    if (!has_program("vcd2fst") || !has_program("fst2vcd")) {
        GTEST_SKIP() << "gtkwave with vcd2fst and fst2vcd is not installed";
    }
    record_vcd();
    send_random_frames();
    vcd_->flush();
    const std::string fst = path() + ".fst";
    const auto converted = shell("vcd2fst " + path() + ' ' + fst + " 2>&1");
    EXPECT_EQ(converted.exit_code, 0) << converted.output;
    const std::string back = shell("fst2vcd -f " + fst + " 2>&1").output;
    for (const char* const wire :
         {" bus ", " pump_3_tx ", " pump_3_rx ", " valve_tx ", " valve_rx ", " gauge_rx "}) {
        EXPECT_THAT(back, HasSubstr(wire));
    }
    // It tells every change at the same time.
    const auto times_of = [](const std::string& vcd) {
        std::vector<std::string> times;
        std::istringstream lines{vcd};
        for (std::string line; std::getline(lines, line);) {
            if (line.starts_with('#')) times.push_back(line);
        }
        return times;
    };
    EXPECT_EQ(times_of(back), times_of(content()));
}

/// What tshark tells of each packet: time, identifier, extended, remote, error, length, data and
/// comment.
std::vector<std::string> packets(const std::string& file) {
    const auto result = shell("tshark -r " + file +
                              " -T fields -E separator=' ' -e frame.time_epoch -e can.id"
                              " -e can.flags.xtd -e can.flags.rtr -e can.flags.err -e can.len"
                              " -e data.data -e frame.comment 2>/dev/null");
    EXPECT_EQ(result.exit_code, 0);
    std::vector<std::string> packets;
    std::istringstream lines{result.output};
    for (std::string line; std::getline(lines, line);) packets.push_back(line);
    return packets;
}

/// Once, the second node takes this bit of a frame for dominant.
class DominantBit final : public sim::Disturbance {
  public:
    explicit DominantBit(FramePosition position) : position_(position) {}
    void node_attached(sim::NodeIndex, std::string_view) override {}
    void node_detached(sim::NodeIndex) override {}
    bool begin_frame(const sim::PlannedFrame&) override { return !is_done_; }
    TimePoint next(TimePoint) const override { return never; }
    void disturb_driven(const sim::BitMoment&, std::span<std::uint8_t>) override {}
    void disturb_seen(const sim::BitMoment& moment, std::span<const std::uint8_t>,
                      std::span<std::uint8_t> seen) override {
        if (is_done_ || moment.position != position_) return;
        seen[1] = 0;
        is_done_ = true;
    }

  private:
    FramePosition position_;
    bool is_done_ = false;
};

TEST_F(DecoderTest, TsharkReadsFramesErrorsAndComments) {
    if (!has_program("tshark")) GTEST_SKIP() << "tshark is not installed";
    record_pcapng();
    send(0, Frame::standard(0x123, octets("DEADBEEF00000000")));
    send(1, Frame::standard(0x7FF, octets("")));
    send(2, Frame::standard(0x124, octets("01")));
    run_until_quiet();

    Frame extended = Frame::standard(0x00800000, octets("63616E322E304232"));
    extended.extended = true;
    bus_.advance(TimePoint{Duration{1'000'000}});
    send(2, extended);
    run_until_quiet();

    Frame remote = Frame::standard(0x123, {});
    remote.remote = true;
    remote.length = 4;
    bus_.advance(TimePoint{Duration{2'000'000}});
    send(1, remote);
    run_until_quiet();

    DominantBit fault{{FrameField::crc_delimiter, 0, false}};
    bus_.set_disturbance(&fault);
    bus_.advance(TimePoint{Duration{3'000'000}});
    send(0, remote);
    run_until_quiet();
    bus_.set_disturbance(nullptr);
    pcapng_->flush();

    // A bit takes 2 us. The lengths are from hand-written bits, see frame_bits_test.cpp.
    EXPECT_THAT(
        packets(path()),
        ElementsAre(
            "0.000230000 291 0 0 0 8 deadbeef00000000 "
            "pump-3, 115 bits on the wire, 7 stuff bits, 2 nodes lost the arbitration",
            "0.000344000 292 0 0 0 1 01 "
            "gauge, 54 bits on the wire, 2 stuff bits, 1 node lost the arbitration",
            "0.000444000 2047 0 0 0 0  valve, 47 bits on the wire, 3 stuff bits",
            "0.001272000 8388608 1 0 0 8 63616e322e304232 "
            "gauge, 136 bits on the wire, 8 stuff bits",
            "0.002088000 291 0 1 0 4  valve, 44 bits on the wire, 0 stuff bits",
            // The CRC delimiter is bit 35. The valve's flag begins after it, and makes the ACK
            // delimiter, bit 37, a form error for the others, whose flags end with bit 43. 11 bits
            // later the frame begins again.
            "0.003070000    1 8  valve, receiving: form error at CRC delimiter; active error "
            "flag; then error active, TEC 0, REC 1",
            "0.003196000 291 0 1 0 4  pump-3, 44 bits on the wire, 0 stuff bits"));
}

TEST_F(DecoderTest, TsharkReadsAThousandFrames) {
    if (!has_program("tshark")) GTEST_SKIP() << "tshark is not installed";
    record_pcapng();
    send_random_frames();
    pcapng_->flush();
    std::vector<std::string> expected;
    for (const sim::CompletedFrame& completed : sent_) {
        const Frame& frame = completed.frame;
        const auto time = completed.time.time_since_epoch().count();
        std::array<char, 200> line{};
        std::string data;
        for (const char c : canorb::test::hex(frame.payload())) {
            data += static_cast<char>(std::tolower(c));
        }
        std::snprintf(line.data(), line.size(), "%d.%09d %u %d 0 0 %d %s %s, %u bits on the wire",
                      static_cast<int>(time / 1'000'000'000),
                      static_cast<int>(time % 1'000'000'000), frame.id, frame.extended ? 1 : 0,
                      frame.length, data.c_str(), bus_.name(completed.sender).c_str(),
                      completed.bits);
        expected.emplace_back(line.data());
    }
    std::vector<std::string> read = packets(path());
    ASSERT_EQ(read.size(), expected.size());
    for (std::size_t i = 0; i < read.size(); ++i) {
        EXPECT_EQ(read[i].substr(0, expected[i].size()), expected[i]);
    }
}

}  // namespace
}  // namespace canorb::can
