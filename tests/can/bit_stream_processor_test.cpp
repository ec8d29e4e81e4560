// Frames bit by bit: what sender and receivers drive, who wins an arbitration, what a receiver
// takes. The bits are written by hand from CAN 2.0 B, chapter 3; a CRC is the remainder of a
// division by x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1.

#include "orb/can/sim/bit_stream_processor.hpp"

#include <gtest/gtest.h>

#include <optional>

#include "tests/can/wire.hpp"

namespace canorb::can::sim::test {
namespace {

using Bits = std::vector<int>;

// ---- frames

TEST(Frames, AStandardDataFrame) {
    Wire wire{"ABC"};
    wire.send('A', standard(0x123, "DEADBEEF"));
    wire.draw({
        //       SOF identifier  RTR IDE r0 DLC  data
        {"A", "  0   00100100011 0   0   0  0100 11011110 10101101 1011111O0 11101111"},
        {"B", "  -   ----------- -   -   -  ---- -------- -------- --------- --------"},
        {"C", "  -   ----------- -   -   -  ---- -------- -------- --------- --------"},
        {"bus", "0   00100100011 0   0   0  0100 11011110 10101101 1011111O0 11101111"},
    });
    wire.draw({
        //       CRC, its delimiter, ACK    EOF     intermission, idle
        {"A", "  1O00111001101011 1  1 1    1111111 111          1111"},
        {"B", "  ---------------- -  0 -    ------- ---          ----"},
        {"C", "  ---------------- -  0 -    ------- ---          ----"},
        {"bus", "1O00111001101011 1  0 1    1111111 111          1111"},
    });
    // 32 + 3 * 14 + 4: 78 bits, the last of which is number 77.
    EXPECT_EQ(wire['A'].sent, Bits{77});
    EXPECT_EQ(wire['A'].received_at, Bits{});
    for (const char receiver : {'B', 'C'}) {
        EXPECT_EQ(wire[receiver].received_at, Bits{77});
        EXPECT_EQ(wire[receiver].received, std::vector{standard(0x123, "DEADBEEF")});
    }
}

TEST(Frames, AnExtendedDataFrame) {
    Wire wire{"AB"};
    wire.send('A', extended(0x0C3D5A7F, "11FF"));
    // 0x0C3D5A7F is 01100001111 010101101001111111. SRR is the fifth recessive bit.
    wire.draw({
        //       SOF ID28 to 18  SRR IDE ID17 to 0            RTR r1 r0 DLC   data
        {"A", "  0   01100001111 1O  1   0101011010011111O11  0   0  0  00I10 00010001 1111O1111"},
        {"B", "  -   ----------- --  -   -------------------  -   -  -  ----- -------- ---------"},
        {"bus", "0   01100001111 1O  1   0101011010011111O11  0   0  0  00I10 00010001 1111O1111"},
    });
    wire.draw({
        {"A", "  010100011000100 1 1 1 1111111 111"},
        {"B", "  --------------- - 0 - ------- ---"},
        {"bus", "010100011000100 1 0 1 1111111 111"},
    });
    EXPECT_EQ(wire['A'].sent, Bits{83});
    EXPECT_EQ(wire['B'].received, std::vector{extended(0x0C3D5A7F, "11FF")});
}

TEST(Frames, AStandardRemoteFrameHasADlcAndNoData) {
    Wire wire{"AB"};
    wire.send('A', remote(standard(0x7C1), 5));
    wire.draw({
        //       SOF identifier    RTR IDE r0 DLC  CRC
        {"A", "  0   11111O0000I01 1   0   0  0101 101000111100100 1 1 1 1111111 111"},
        {"B", "  -   ------------- -   -   -  ---- --------------- - 0 - ------- ---"},
        {"bus", "0   11111O0000I01 1   0   0  0101 101000111100100 1 0 1 1111111 111"},
    });
    EXPECT_EQ(wire['A'].sent, Bits{45});
    ASSERT_EQ(wire['B'].received, std::vector{remote(standard(0x7C1), 5)});
}

TEST(Frames, AnExtendedRemoteFrameHasADlcAndNoData) {
    Wire wire{"AB"};
    wire.send('A', remote(extended(0x00800000), 8));
    wire.draw({
        //       SOF ID28 to 18    SRR IDE ID17 to 0             RTR r1 r0 DLC
        {"A", "  0   0000I0100000I 1   1   00000I00000I00000I000 1   0  0  1000"},
        {"B", "  -   ------------- -   -   --------------------- -   -  -  ----"},
        {"bus", "0   0000I0100000I 1   1   00000I00000I00000I000 1   0  0  1000"},
    });
    wire.draw({
        {"A", "  010011000111010 1 1 1 1111111 111"},
        {"B", "  --------------- - 0 - ------- ---"},
        {"bus", "010011000111010 1 0 1 1111111 111"},
    });
    EXPECT_EQ(wire['A'].sent, Bits{68});
    EXPECT_EQ(wire['B'].received, std::vector{remote(extended(0x00800000), 8)});
}

TEST(Frames, ACrcThatEndsWithFiveEqualBitsHasAStuffBitAfterIt) {
    Wire wire{"AB"};
    wire.send('A', standard(0x017));
    wire.draw({
        {"A", "  0 0000I0010111 0 0 0 00I00 101001000011111O 1 1 1 1111111 111"},
        {"B", "  - ------------ - - - ----- ---------------- - 0 - ------- ---"},
        {"bus", "0 0000I0010111 0 0 0 00I00 101001000011111O 1 0 1 1111111 111"},
    });
    EXPECT_EQ(wire['B'].received, std::vector{standard(0x017)});
}

TEST(Frames, TheNextOneBeginsAfterThreeBits) {
    Wire wire{"AB"};
    wire.send('A', standard(0x555));
    wire.draw({
        {"A", "  0 10101010101 000 00I00 110011101001100 1 1 1 1111111"},
        {"B", "  - ----------- --- ----- --------------- - 0 - -------"},
        {"bus", "0 10101010101 000 00I00 110011101001100 1 0 1 1111111"},
    });
    wire.send('B', standard(0x017));
    wire.draw({
        //       intermission
        {"A", "  111          - ------------ --- ----- ---------------- - 0 - -------"},
        {"B", "  111          0 0000I0010111 000 00I00 101001000011111O 1 1 1 1111111"},
        {"bus", "111          0 0000I0010111 000 00I00 101001000011111O 1 0 1 1111111"},
    });
}

// ---- arbitration

TEST(Arbitration, TheLoserOfAnIdentifierBitReceivesAndAcknowledges) {
    Wire wire{"AB"};
    wire.send('A', standard(0x556));
    wire.send('B', standard(0x555));
    wire.draw({
        //                  here
        {"A", "  0 101010101 1 - --- ----- --------------- - 0 - ------- ---"},
        {"B", "  0 101010101 0 1 000 00I00 110011101001100 1 1 1 1111111 111"},
        {"bus", "0 101010101 0 1 000 00I00 110011101001100 1 0 1 1111111 111"},
    });
    EXPECT_EQ(wire['A'].received, std::vector{standard(0x555)});
    EXPECT_EQ(wire['A'].lost_at, Bits{9});
    wire.draw({
        {"A", "  0 10101010110 000 0I000 00I0000101111001 1 1 1 1111111 111"},
        {"B", "  - ----------- --- ----- ---------------- - 0 - ------- ---"},
        {"bus", "0 10101010110 000 0I000 00I0000101111001 1 0 1 1111111 111"},
    });
    EXPECT_EQ(wire['A'].sent.size(), 1U);
    EXPECT_EQ(wire.status('A'), ErrorStatus{});
    EXPECT_EQ(wire.status('B'), ErrorStatus{});
}

TEST(Arbitration, AStandardDataFrameBeatsAnExtendedOneOfTheSameBaseAtSrr) {
    Wire wire{"AB"};
    wire.send('A', extended(0x555 << 18));
    wire.send('B', standard(0x555));
    wire.draw({
        //                   SRR/RTR IDE
        {"A", "  0 10101010101 1       -   - ----- --------------- - 0 - ------- ---"},
        {"B", "  0 10101010101 0       0   0 00I00 110011101001100 1 1 1 1111111 111"},
        {"bus", "0 10101010101 0       0   0 00I00 110011101001100 1 0 1 1111111 111"},
    });
    EXPECT_EQ(wire['A'].lost_at, Bits{11});
    EXPECT_EQ(wire['A'].received, std::vector{standard(0x555)});
    wire.draw({
        {"A",
         "  0 10101010101 1 1 00000I00000I00000I000 0 0I 0 0000I 000100100100100 1 1 1 1111111"},
        {"B",
         "  - ----------- - - --------------------- - -- - ----- --------------- - 0 - -------"},
    });
    EXPECT_EQ(wire['B'].received, std::vector{extended(0x555 << 18)});
}

TEST(Arbitration, AStandardRemoteFrameBeatsAnExtendedOneOfTheSameBaseAtIde) {
    Wire wire{"AB"};
    wire.send('A', extended(0x555 << 18));
    wire.send('B', remote(standard(0x555)));
    wire.draw({
        //                   SRR/RTR IDE
        {"A", "  0 10101010101 1       1   - ----- --------------- - 0 - ------- ---"},
        {"B", "  0 10101010101 1       0   0 000I0 001010010001001 1 1 1 1111111 111"},
        {"bus", "0 10101010101 1       0   0 000I0 001010010001001 1 0 1 1111111 111"},
    });
    EXPECT_EQ(wire['A'].lost_at, Bits{12});
    EXPECT_EQ(wire['A'].received, std::vector{remote(standard(0x555))});
}

TEST(Arbitration, AStandardDataFrameBeatsARemoteOneAtRtr) {
    Wire wire{"AB"};
    wire.send('A', remote(standard(0x555)));
    wire.send('B', standard(0x555));
    wire.draw({
        //                   RTR
        {"A", "  0 10101010101 1   -- ----- --------------- - 0 - ------- ---"},
        {"B", "  0 10101010101 0   00 00I00 110011101001100 1 1 1 1111111 111"},
    });
    EXPECT_EQ(wire['A'].lost_at, Bits{11});
    EXPECT_EQ(wire['A'].received, std::vector{standard(0x555)});
}

TEST(Arbitration, AnExtendedDataFrameBeatsARemoteOneAtRtr) {
    Wire wire{"AB"};
    wire.send('A', remote(extended(0x15555555)));
    wire.send('B', extended(0x15555555));
    wire.draw({
        //                   SRR IDE                    RTR
        {"A", "  0 10101010101 1   1   010101010101010101 1   -- ----- --------------- - 0 -"},
        {"B", "  0 10101010101 1   1   010101010101010101 0   00 00I00 011000110010110 1 1 1"},
    });
    EXPECT_EQ(wire['A'].lost_at, Bits{31});
    wire.pass(7);
    EXPECT_EQ(wire['A'].received, std::vector{extended(0x15555555)});
}

TEST(Arbitration, ADominantBitThatIsRecessiveOnTheBusIsABitError) {
    Wire wire{"AB"};
    wire.send('A', standard(0x555));
    // A's flag, with the identifier bit before it, is six dominant bits for B after five of its
    // own: B's flag overlaps the last one.
    wire.draw({
        //            flag of A ... and of B
        {"A", "  0 10 00000 0        11111 11111111 111 0"},
        {"B", "  - -- ----- 0        00000 11111111 111 -"},
        {"bus", "0 10 00000 0        00000 11111111 111 0"},
        {"A sees", ". .1 ..... .   ..... ........ ... ."},
    });
    EXPECT_EQ(
        wire['A'].errors,
        (std::vector<Wire::Error>{{2, {ErrorKind::bit, in(FrameField::identifier, 1), true}}}));
    EXPECT_EQ(wire['B'].errors,
              (std::vector<Wire::Error>{
                  {7, {ErrorKind::stuff, stuff_after(FrameField::identifier, 5), false}}}));
    EXPECT_EQ(wire['A'].lost_at, Bits{});
    EXPECT_EQ(wire.status('A').tec, 8);
    EXPECT_EQ(wire.status('B').rec, 1);
}

// ---- what a receiver takes

/// The frame that a lone receiver makes of these levels, of which the ACK slot is its own. They end
/// with EOF.
std::optional<Frame> received(std::string_view levels) {
    BitStreamProcessor processor = new_processor();
    std::optional<Frame> frame;
    for (const char c : levels) {
        if (c == ' ') continue;
        EXPECT_EQ(int{processor.driven()}, c == 'A' ? 0 : 1);
        const auto events = processor.step(c == '1' || c == 'I' ? 1 : 0);
        EXPECT_EQ(events & ~BitStreamProcessor::received, 0);
        if (events != 0) frame = processor.frame();
    }
    return frame;
}

TEST(Reception, AStandardFrame) {
    EXPECT_EQ(received("0 10101010101 000 00I00 110011101001100 1 A 1 1111111"), standard(0x555));
}

TEST(Reception, ADlcAboveEightIsEightOctets) {
    struct Case {
        std::string_view dlc;
        std::string_view crc;
    };
    for (const Case& each : {Case{"1000", "001101100000I100"}, Case{"1001", "01100000I1011010"},
                             Case{"1010", "100110110111000"}, Case{"1011", "110011011100110"},
                             Case{"1100", "1110011111O00101"}, Case{"1101", "101100010111011"},
                             Case{"1110", "010010101011001"}, Case{"1111", "00011100000I0111"}}) {
        std::string levels{"0 10101010101 000 "};
        levels += each.dlc;
        for (int octet = 0; octet < 8; ++octet) levels += " 01010101";
        levels += " ";
        levels += each.crc;
        levels += " 1 A 1 1111111";
        EXPECT_EQ(received(levels), standard(0x555, "5555555555555555")) << each.dlc;
    }
}

TEST(Reception, ADlcAboveEightOfARemoteFrameIsEightToo) {
    EXPECT_EQ(received("0 10101010101 100 1111 011001101110011 1 A 1 1111111"),
              remote(standard(0x555), 8));
}

TEST(Reception, ARecessiveReservedBitOfAStandardFrame) {
    EXPECT_EQ(received("0 10101010101 0 0 1 0000 100101011011011 1 A 1 1111111"), standard(0x555));
}

TEST(Reception, RecessiveReservedBitsOfAnExtendedFrame) {
    // RTR, r1, r0, DLC
    for (const auto* rest : {"0 0 0 00I00 011000110010110", "0 1 0 0000I 110101010111000",
                             "0 0 1 0000 0I011100000I00001", "0 1 1 0000 100011100101111"}) {
        std::string levels{"0 10101010101 1 1 010101010101010101 "};
        levels += rest;
        levels += " 1 A 1 1111111";
        EXPECT_EQ(received(levels), extended(0x15555555)) << rest;
    }
}

TEST(Reception, ADominantSrr) {
    EXPECT_EQ(received("0 10101010101 0 1 010101010101010101 000 00I00 100101001110110 "
                       "1 A 1 1111111"),
              extended(0x15555555));
}

// ---- who takes part

TEST(Integration, TakesElevenRecessiveBits) {
    Wire wire{"ABC"};
    wire.send('A', standard(0x555));
    wire.pass(25);
    wire['B'].processor = BitStreamProcessor{false, 0};
    wire.send('B', standard(0x156));
    // It is no receiver of this frame; ACK delimiter, EOF and intermission are the 11 bits.
    wire.draw({
        {"A", "  1101001100 1 1 1 1111111 111"},
        {"B", "  ---------- - 1 - ------- ---"},
        {"C", "  ---------- - 0 - ------- ---"},
    });
    EXPECT_EQ(wire['B'].received_at, Bits{});
    wire.draw({
        {"A", "  - ----------- --- ----- --------------- - 0 - -------"},
        {"B", "  0 00101010110 000 0I000 010010011001000 1 1 1 1111111"},
        {"C", "  - ----------- --- ----- --------------- - 0 - -------"},
    });
}

TEST(Integration, ADominantBitBeginsItAnew) {
    BitStreamProcessor processor{false, 0};
    feed(processor, "1111111111 0 1111111111");
    EXPECT_FALSE(processor.may_start());
    EXPECT_FALSE(processor.takes_part());
    feed(processor, "1");
    EXPECT_TRUE(processor.may_start());
}

TEST(Integration, CountsWhatWasBefore) {
    EXPECT_TRUE((BitStreamProcessor{false, 11}.may_start()));
    BitStreamProcessor processor{false, 10};
    EXPECT_FALSE(processor.may_start());
    feed(processor, "1");
    EXPECT_TRUE(processor.may_start());
}

TEST(ListenOnly, ReceivesWithoutAcknowledging) {
    Wire wire{"ABC"};
    wire['B'].processor.set_listen_only(true, false);
    wire.send('A', standard(0x555));
    wire.draw({
        {"A", "  0 10101010101 000 00I00 110011101001100 1 1 1 1111111 111"},
        {"B", "  - ----------- --- ----- --------------- - 1 - ------- ---"},
        {"C", "  - ----------- --- ----- --------------- - 0 - ------- ---"},
    });
    EXPECT_EQ(wire['B'].received, std::vector{standard(0x555)});
}

TEST(ListenOnly, IsNobodyForASender) {
    Wire wire{"AB"};
    wire['B'].processor.set_listen_only(true, false);
    wire.send('A', standard(0x555));
    wire.draw({
        {"A", "  0 10101010101 000 00I00 110011101001100 1 1 000000 11111111 111 0"},
        {"B", "  - ----------- --- ----- --------------- - - ------ -------- --- -"},
    });
    EXPECT_EQ(wire['A'].errors,
              (std::vector<Wire::Error>{
                  {36, {ErrorKind::acknowledgment, in(FrameField::ack_slot), true}}}));
    EXPECT_EQ(wire['B'].received, std::vector<Frame>{});
    EXPECT_EQ(wire.status('B'), ErrorStatus{});
}

TEST(ListenOnly, SeesErrorsWithoutAFlagOrACount) {
    Wire wire{"ABC"};
    fail_as_receiver(wire['B'].processor, 3);
    wire['B'].processor.set_listen_only(true, false);
    wire.send('A', standard(0x555));
    wire.draw({
        {"A", "  0 10101010101 000 00I 00 110011101001100 1 1 1 1111111 111"},
        {"B", "  - ----------- --- --- -- --------------- - - - ------- ---"},
        {"C", "  - ----------- --- --- -- --------------- - 0 - ------- ---"},
        {"B sees", ". ........... ... ..0 .. ............... . . . ....... ..."},
    });
    // Its flags, 18 to 23 and 28 to 33, are seen by itself only, so the frame goes on in their
    // delimiters: bit 27 is a dominant bit of the CRC, bit 36 the ACK slot.
    EXPECT_EQ(wire['B'].errors,
              (std::vector<Wire::Error>{
                  {17, {ErrorKind::stuff, stuff_after(FrameField::data_length_code, 1), false}},
                  {27, {ErrorKind::form, {FrameField::error_delimiter, 3, false}, false}},
                  {36, {ErrorKind::form, {FrameField::error_delimiter, 1, false}, false}}}));
    EXPECT_EQ(wire.status('B').rec, 3);
    EXPECT_EQ(wire['A'].sent, Bits{44});
}

TEST(ListenOnly, CountsNoSuccessEither) {
    Wire wire{"ABC"};
    fail_as_receiver(wire['B'].processor, 3);
    wire['B'].processor.set_listen_only(true, false);
    wire.send('A', standard(0x555));
    wire.pass_until_idle();
    EXPECT_EQ(wire['B'].received.size(), 1U);
    EXPECT_EQ(wire.status('B').rec, 3);
}

TEST(ListenOnly, CountsNoDominantBitsAfterAFlag) {
    BitStreamProcessor processor = new_processor();
    processor.set_listen_only(true, false);
    feed(processor, "000000");
    for (int bit = 0; bit < 100; ++bit) {
        EXPECT_EQ(processor.driven(), 1);
        feed(processor, "0");
    }
    EXPECT_EQ(processor.status(), ErrorStatus{});
}

TEST(ListenOnly, SendsNoOverloadFlag) {
    BitStreamProcessor processor = new_processor();
    processor.set_listen_only(true, false);
    feed(processor, "0 10101010101 000 00100 110011101001100 1 0 1 1111111 1 0");
    EXPECT_EQ(processor.driven(), 1);
    // The others' flag, their delimiter and their intermission.
    feed(processor, "000000 11111111 11");
    EXPECT_FALSE(processor.may_start());
    feed(processor, "1");
    EXPECT_TRUE(processor.may_start());
    EXPECT_EQ(processor.status(), ErrorStatus{});
}

}  // namespace
}  // namespace canorb::can::sim::test
