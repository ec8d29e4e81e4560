// canorb-bits as people run it: a process of its own.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/support/shell.hpp"

namespace canorb {
namespace {

using test::shell;
using test::ShellResult;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

ShellResult run(const std::string& arguments) {
    return shell(std::string{"'"} + CANORB_BITS + "' " + arguments + " 2>&1");
}

// The bits and CRCs of these frames were worked out by hand, see frame_bits_test.cpp.

TEST(CanorbBits, ShowsAStandardDataFrame) {
    const ShellResult result = run("123#DEADBEEF00000000");
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_EQ(result.output,
              R"(123#DEADBEEF00000000: standard data frame, identifier 0x123, 8 octets

  field                value    bits
  start of frame                0
  identifier           0x123    00100100011
  RTR                           0
  IDE                           0
  r0                            0
  DLC                  8        1000
  data 0               0xDE     11011110
  data 1               0xAD     10101101
  data 2               0xBE     1011111(0)0
  data 3               0xEF     11101111
  data 4               0x00     00000(1)000
  data 5               0x00     00(1)00000(1)0
  data 6               0x00     0000(1)0000
  data 7               0x00     0(1)00000(1)00
  CRC                  0x6777   110011101110111
  CRC delimiter                 1
  ACK slot                      0
  ACK delimiter                 1
  end of frame                  1111111

0 is dominant, 1 recessive; (0) and (1) are stuff bits; the ACK slot is the receivers'.
CRC 0x6777, 7 stuff bits, 115 bits from SOF to the end of EOF, 118 with the intermission.

  bit rate              SOF to EOF  with intermission
     125000 bit/s       920.000 us         944.000 us
     250000 bit/s       460.000 us         472.000 us
     500000 bit/s       230.000 us         236.000 us
    1000000 bit/s       115.000 us         118.000 us
)");
}

TEST(CanorbBits, ShowsSeveralFramesAtABitRate) {
    const ShellResult result = run("--bitrate 30000 00800000#63.61.6E.32.2E.30.42.32 123#r");
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_EQ(
        result.output,
        R"(00800000#63.61.6E.32.2E.30.42.32: extended data frame, identifier 0x00800000, 8 octets

  field                value    bits
  start of frame                0
  identifier           0x020    0000(1)0100000(1)
  SRR                           1
  IDE                           1
  extended identifier  0x00000  00000(1)00000(1)00000(1)000
  RTR                           0
  r1                            0(1)
  r0                            0
  DLC                  8        1000
  data 0               0x63     01100011
  data 1               0x61     01100001
  data 2               0x6E     01101110
  data 3               0x32     00110010
  data 4               0x2E     00101110
  data 5               0x30     00110000
  data 6               0x42     0(1)1000010
  data 7               0x32     00110010
  CRC                  0x1814   001100000(1)010100
  CRC delimiter                 1
  ACK slot                      0
  ACK delimiter                 1
  end of frame                  1111111

0 is dominant, 1 recessive; (0) and (1) are stuff bits; the ACK slot is the receivers'.
CRC 0x1814, 8 stuff bits, 136 bits from SOF to the end of EOF, 139 with the intermission.

  bit rate              SOF to EOF  with intermission
      30000 bit/s      4533.333 us        4633.333 us

123#r: standard remote frame, identifier 0x123, DLC 0

  field                value    bits
  start of frame                0
  identifier           0x123    00100100011
  RTR                           1
  IDE                           0
  r0                            0
  DLC                  0        000(1)0
  CRC                  0x1B9D   001101110011101
  CRC delimiter                 1
  ACK slot                      0
  ACK delimiter                 1
  end of frame                  1111111

0 is dominant, 1 recessive; (0) and (1) are stuff bits; the ACK slot is the receivers'.
CRC 0x1B9D, 1 stuff bit, 45 bits from SOF to the end of EOF, 48 with the intermission.

  bit rate              SOF to EOF  with intermission
      30000 bit/s      1500.000 us        1600.000 us
)");
}

TEST(CanorbBits, HasHelpAndVersion) {
    const ShellResult help = run("--help");
    EXPECT_EQ(help.exit_code, 0);
    EXPECT_THAT(help.output, AllOf(HasSubstr("ID#DATA"), HasSubstr("--bitrate")));
    const ShellResult version = run("--version");
    EXPECT_EQ(version.exit_code, 0);
    EXPECT_THAT(version.output, StartsWith("canorb-bits "));
}

struct BadInput {
    const char* arguments;
    const char* says;
};

TEST(CanorbBits, SaysWhatIsWrongInOneLine) {
    for (const BadInput& bad : {
             BadInput{"123", "\"123\" is no frame: ID#DATA is expected"},
             BadInput{"''", "\"\" is no frame: ID#DATA is expected"},
             BadInput{"12#00", "bad identifier"},
             BadInput{"800#00", "bad identifier"},
             BadInput{"1234567#00", "bad identifier"},
             BadInput{"40000000#00", "bad identifier"},
             BadInput{"12G#00", "bad identifier"},
             BadInput{"123#0", "bad data"},
             BadInput{"123#0G", "bad data"},
             BadInput{"123#112233445566778899", "bad data"},
             BadInput{"123#R9", "bad data"},
             BadInput{"123#R44", "bad data"},
             BadInput{"'123#00 T'", "there is a blank in it"},
             BadInput{"123#1122334455667788_9", "a DLC above 8 is not supported"},
             BadInput{"123##000", "CAN FD is not supported"},
             BadInput{"20000004#0000000000000000", "error frames of SocketCAN"},
             BadInput{"123#00 124", "\"124\" is no frame"},
             BadInput{"123#00 --bitrate 0", "--bitrate: \"0\" is not a bit rate"},
             BadInput{"123#00 --bitrate fast", "--bitrate: \"fast\" is not a bit rate"},
         }) {
        const ShellResult result = run(bad.arguments);
        EXPECT_EQ(result.exit_code, 2) << bad.arguments;
        EXPECT_THAT(result.output, AllOf(StartsWith("canorb-bits: "), HasSubstr(bad.says)));
        EXPECT_EQ(std::count(result.output.begin(), result.output.end(), '\n'), 1);
    }
    EXPECT_EQ(run("").exit_code, 2);
    EXPECT_EQ(run("--bitrat 5 123#00").exit_code, 2);
}

TEST(CanorbBits, SaysThatItCannotWrite) {
    const ShellResult result = shell(std::string{"'"} + CANORB_BITS + "' 123#00 2>&1 >/dev/full");
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_EQ(result.output, "canorb-bits: cannot write: No space left on device\n");
}

}  // namespace
}  // namespace canorb
