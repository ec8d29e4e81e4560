#include "orb/can/record/pcapng_writer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <string_view>

#include "tests/can/record/record_fixture.hpp"
#include "tests/support/octets.hpp"

namespace canorb::can {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

std::string octets(std::string_view hex) {
    const auto values = canorb::test::octets(hex);
    return {values.begin(), values.end()};
}

std::string hex(std::string_view text) {
    std::vector<std::uint8_t> values;
    for (const char c : text) values.push_back(static_cast<std::uint8_t>(c));
    return canorb::test::hex(values);
}

// draft-ietf-opsawg-pcapng, little endian.
constexpr std::string_view section_header =
    "0A0D0D0A 2C000000"       // block type, length
    "4D3C2B1A 0100 0000"      // byte-order magic, version 1.0
    "FFFFFFFFFFFFFFFF"        // length of the section: unknown
    "0400 0600 63616E6F7262"  // shb_userappl, "canorb"
    "0000"                    // padding
    "0000 0000"               // opt_endofopt
    "2C000000";               // length

class PcapngWriterTest : public RecordTest {
  protected:
    void open(const PcapngOptions& options = {}) {
        auto writer = PcapngWriter::create(path(), options);
        ASSERT_TRUE(writer) << writer.error();
        writer_ = std::move(*writer);
    }

    /// What was written since the last call, or since open() without the headers.
    std::string written() {
        writer_->flush();
        const std::string all = content();
        const std::string result = all.substr(size_before_);
        size_before_ = all.size();
        return result;
    }

    std::unique_ptr<PcapngWriter> writer_;
    std::size_t size_before_ = 0;
};

TEST_F(PcapngWriterTest, BeginsWithASectionAndAnInterface) {
    open({.interface = "can0", .bitrate = 500'000});
    EXPECT_EQ(hex(content()), hex(octets(section_header) +             //
                                  octets("01000000 34000000"           // block type, length
                                         "E300 0000 00000000"          // LINKTYPE_CAN_SOCKETCAN
                                         "0200 0400 63616E30"          // if_name "can0"
                                         "0800 0800 20A1070000000000"  // if_speed
                                         "0900 0100 09 000000"         // if_tsresol: nanoseconds
                                         "0000 0000"                   // opt_endofopt
                                         "34000000")));
}

TEST_F(PcapngWriterTest, TheBitRateMayBeUnknown) {
    open({.interface = "vcan12"});
    EXPECT_EQ(hex(content()),
              hex(octets(section_header) + octets("01000000 2C000000"
                                                  "E300 0000 00000000"
                                                  "0200 0600 7663616E3132 0000"  // "vcan12"
                                                  "0900 0100 09 000000"
                                                  "0000 0000"
                                                  "2C000000")));
}

TEST_F(PcapngWriterTest, WritesAFrameWithItsComment) {
    open({.unix_time_offset = 1'700'000'000s});
    static_cast<void>(written());
    sim::CompletedFrame completed;
    completed.frame = Frame::standard(0x123, canorb::test::octets("DEADBEEF00000000"));
    completed.time = TimePoint{230us};
    completed.bits = 115;
    completed.stuff_bits = 7;
    completed.lost_arbitrations = 2;
    writer_->frame(completed, "pump-3");
    // 1 700 000 000.000 230 000 s are 17979CFE 362D8270 ns; the comment has 72 octets.
    EXPECT_EQ(hex(written()),
              hex(octets("06000000 80000000"           // Enhanced Packet Block
                         "00000000 FE9C9717 70822D36"  // interface, time: high, low
                         "10000000 10000000"           // captured and original length
                         "00000123 08 00 00 00"        // identifier in network order, length
                         "DEADBEEF 00000000"
                         "0100 4800") +  // opt_comment
                  "pump-3, 115 bits on the wire, 7 stuff bits, 2 nodes lost the arbitration" +
                  octets("0000 0000"
                         "80000000")));
}

TEST_F(PcapngWriterTest, WritesExtendedAndRemoteFrames) {
    open();
    static_cast<void>(written());
    sim::CompletedFrame completed;
    completed.frame = Frame::standard(0x12345678, canorb::test::octets("A1B2C3"));
    completed.frame.extended = true;
    completed.sender = sim::NodeIndex{7};
    completed.bits = 91;
    completed.stuff_bits = 1;
    completed.lost_arbitrations = 1;
    writer_->frame(completed, "");
    EXPECT_EQ(hex(written()), hex(octets("06000000 7C000000"
                                         "00000000 00000000 00000000"
                                         "0B000000 0B000000"
                                         "92345678 03 00 00 00"  // with CAN_EFF_FLAG
                                         "A1B2C3 00"
                                         "0100 4500") +
                                  "node 7, 91 bits on the wire, 1 stuff bit, 1 node lost the "
                                  "arbitration" +
                                  octets("00 00 00"
                                         "0000 0000"
                                         "7C000000")));

    completed.frame = Frame::standard(0x7FF, {});
    completed.frame.remote = true;
    completed.frame.length = 4;
    completed.bits = 44;
    completed.stuff_bits = 0;
    completed.lost_arbitrations = 0;
    writer_->frame(completed, "n");
    EXPECT_EQ(hex(written()), hex(octets("06000000 54000000"
                                         "00000000 00000000 00000000"
                                         "08000000 08000000"
                                         "400007FF 04 00 00 00"  // with CAN_RTR_FLAG
                                         "0100 2400") +
                                  "n, 44 bits on the wire, 0 stuff bits" +
                                  octets("0000 0000"
                                         "54000000")));
}

TEST_F(PcapngWriterTest, TimesBeforeTheUnixEpochAreZero) {
    open({.unix_time_offset = -1s});
    static_cast<void>(written());
    writer_->frame({}, "n");
    EXPECT_THAT(hex(written()).substr(24), StartsWith("0000000000000000"));
}

TEST_F(PcapngWriterTest, SaysWhyItCannotWrite) {
    const auto missing = PcapngWriter::create(path() + "/missing/bus.pcapng");
    ASSERT_FALSE(missing);
    EXPECT_THAT(missing.error(), StartsWith("cannot write "));
    const auto full = PcapngWriter::create("/dev/full");
    ASSERT_FALSE(full);
    EXPECT_THAT(full.error(), HasSubstr("No space left on device"));
}

// Errors as SocketCAN reports them: identifier CAN_ERR_FLAG and classes, data[1] state, [2] kind,
// [3] place, [6] TEC, [7] REC (linux/can/error.h).

sim::NodeError stuff_error() {
    sim::NodeError error;
    error.time = TimePoint{50us};
    error.node = sim::NodeIndex{2};
    error.capture.kind = sim::ErrorKind::stuff;
    error.capture.position = {FrameField::data, 12, true};
    error.status = {ControllerState::error_active, 0, 9};
    error.active_flag = true;
    error.primary = true;
    return error;
}

TEST_F(PcapngWriterTest, WritesAnErrorAsAnErrorFrame) {
    open();
    static_cast<void>(written());
    writer_->error(stuff_error(), "valve");
    // 50 000 ns are C350. CAN_ERR_PROT 8, CAN_ERR_BUSERROR 80h, CAN_ERR_CNT 200h.
    EXPECT_EQ(hex(written()),
              hex(octets("06000000 B0000000"
                         "00000000 00000000 50C30000"
                         "10000000 10000000"
                         "20000288 08 00 00 00"
                         "00 00 04 0A 00 00 00 09"  // CAN_ERR_PROT_STUFF, CAN_ERR_PROT_LOC_DATA
                         "0100 7800") +
                  "valve, receiving: stuff error at data bit 13, the stuff bit after it; active "
                  "error flag; then error active, TEC 0, REC 9" +
                  octets("0000 0000"
                         "B0000000")));
}

TEST_F(PcapngWriterTest, LeavesOutErrorsThatFollowFromAnother) {
    open();
    static_cast<void>(written());
    sim::NodeError error = stuff_error();
    error.primary = false;
    writer_->error(error, "valve");
    EXPECT_EQ(written(), "");
}

struct ErrorSample {
    const char* name;
    sim::ErrorCapture capture;
    ErrorStatus status;
    const char* packet;
    const char* comment;
};

std::string name_of(const testing::TestParamInfo<ErrorSample>& info) {
    return info.param.name;
}
void PrintTo(const ErrorSample& sample, std::ostream* out) {
    *out << sample.name;
}

class PcapngErrorTest : public PcapngWriterTest, public testing::WithParamInterface<ErrorSample> {};

TEST_P(PcapngErrorTest, HasItsFlagsAndOctets) {
    open();
    static_cast<void>(written());
    sim::NodeError error;
    error.capture = GetParam().capture;
    error.status = GetParam().status;
    error.primary = true;
    writer_->error(error, "n");
    const std::string block = written();
    EXPECT_EQ(hex(block.substr(28, 16)), hex(octets(GetParam().packet)));
    EXPECT_THAT(block, HasSubstr(GetParam().comment));
}

using Kind = sim::ErrorKind;
using State = ControllerState;

INSTANTIATE_TEST_SUITE_P(
    Samples, PcapngErrorTest,
    testing::Values(
        // CAN_ERR_PROT_BIT and _TX; the place is SJA1000's ID.28 to ID.21.
        ErrorSample{"bit",
                    {Kind::bit, {FrameField::identifier, 3, false}, true},
                    {State::error_active, 8, 0},
                    "20000288 08000000 00 00 81 02 00 00 08 00",
                    "n, sending: bit error at identifier bit 4; passive error flag; then error "
                    "active, TEC 8, REC 0"},
        // CAN_ERR_ACK as well; CAN_ERR_PROT_LOC_ACK.
        ErrorSample{"acknowledgment",
                    {Kind::acknowledgment, {FrameField::ack_slot, 0, false}, true},
                    {State::error_active, 88, 0},
                    "200002A8 08000000 00 00 80 19 00 00 58 00",
                    "n, sending: ACK error at ACK slot; passive error flag;"},
        // Form; CAN_ERR_PROT_LOC_EOF; CAN_ERR_CRTL with CAN_ERR_CRTL_RX_WARNING.
        ErrorSample{"form",
                    {Kind::form, {FrameField::end_of_frame, 2, false}, false},
                    {State::error_active, 95, 96},
                    "2000028C 08000000 00 04 02 1A 00 00 5F 60",
                    "n, receiving: form error at end of frame bit 3;"},
        // CRC has no flag, CAN_ERR_PROT_LOC_ACK_DEL is where it is told; both sides passive.
        ErrorSample{"crc",
                    {Kind::crc, {FrameField::ack_delimiter, 0, false}, false},
                    {State::error_passive, 128, 129},
                    "2000028C 08000000 00 30 00 1B 00 00 80 81",
                    "then error passive, TEC 128, REC 129"},
        // CAN_ERR_BUSOFF; a counter of 256 does not fit.
        ErrorSample{"bus_off",
                    {Kind::bit, {FrameField::start_of_frame, 0, false}, true},
                    {State::bus_off, 256, 0},
                    "200002C8 08000000 00 00 81 03 00 00 FF 00",
                    "; no error flag; then bus off, TEC 256"}),
    name_of);

}  // namespace
}  // namespace canorb::can
