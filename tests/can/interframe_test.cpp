// Overload frames, intermission and suspend transmission, bit by bit (CAN 2.0 B, 3.2.4 and 3.2.5).
// The frame is mostly 0x555 without data, 45 bits from SOF to the end of EOF:
//
//     0 10101010101 000 00I00 110011101001100 1 0 1 1111111

#include <gtest/gtest.h>

#include "tests/can/wire.hpp"

namespace canorb::can::sim::test {
namespace {

using Bits = std::vector<int>;
using Errors = std::vector<Wire::Error>;

constexpr ErrorStatus untouched{};

void draw_frame(Wire& wire) {
    wire.draw({
        {"A", "  0 10101010101 000 00I00 110011101001100 1 1 1 1111111"},
        {"bus", "0 10101010101 000 00I00 110011101001100 1 0 1 1111111"},
    });
}

class Overload : public testing::Test {
  protected:
    Overload() {
        wire_.send('A', standard(0x555));
        draw_frame(wire_);
        // It must wait for the overload frame.
        wire_.send('A', standard(0x555));
    }

    Wire wire_{"ABC"};
};

TEST_F(Overload, FollowsADominantFirstBitOfTheIntermission) {
    wire_.draw({
        //          flag   delimiter intermission
        {"A", "      1 000000 11111111 111 0"},
        {"B", "      1 000000 11111111 111 -"},
        {"C", "      1 000000 11111111 111 -"},
        {"bus", "    1 000000 11111111 111 0"},
        {"all see", "0 ...... ........ ... ."},
    });
    for (const char node : {'A', 'B', 'C'}) {
        EXPECT_EQ(wire_[node].errors, Errors{});
        EXPECT_EQ(wire_.status(node), untouched);
    }
}

TEST_F(Overload, FollowsADominantSecondBitOfTheIntermission) {
    wire_.draw({
        {"A", "      11 000000 11111111 111 0"},
        {"B", "      11 000000 11111111 111 -"},
        {"C", "      11 000000 11111111 111 -"},
        {"bus", "    11 000000 11111111 111 0"},
        {"all see", ".0 ...... ........ ... ."},
    });
    for (const char node : {'A', 'B', 'C'}) EXPECT_EQ(wire_.status(node), untouched);
}

TEST_F(Overload, OfOneNodeIsAnsweredByTheOthers) {
    // B's flag is in the second bit of the intermission.
    wire_.draw({
        {"A", "     1 1 00000 0 11111111 111 0"},
        {"B", "     1 0 00000 1 11111111 111 -"},
        {"C", "     1 1 00000 0 11111111 111 -"},
        {"bus", "   1 0 00000 0 11111111 111 0"},
        {"B sees", "0 . ..... . ........ ... ."},
    });
    for (const char node : {'A', 'B', 'C'}) EXPECT_EQ(wire_.status(node), untouched);
}

TEST(OverloadOfOneNode, InTheThirdBitOfTheIntermissionIsASofForTheOthers) {
    Wire wire{"AB"};
    wire.send('A', standard(0x555));
    draw_frame(wire);
    // A takes B's overload flag for SOF and four bits, and a stuff error. It is a receiver.
    wire.draw({
        {"A", "     11 ------ 000000 11111111 111 1"},
        {"B", "     11 000000 111111 11111111 111 1"},
        {"B sees", ".0 ...... ...... ........ ... ."},
    });
    EXPECT_EQ(wire['A'].errors,
              (Errors{{52, {ErrorKind::stuff, stuff_after(FrameField::identifier, 3), false}}}));
    EXPECT_EQ(wire.status('A'), (ErrorStatus{ControllerState::error_active, 0, 1}));
    EXPECT_EQ(wire.status('B'), untouched);
}

// ---- a SOF in the last bit of the intermission

TEST(ThirdBitOfIntermission, DominantIsASofAndWhoHasAFrameGoesOnWithItsIdentifier) {
    Wire wire{"ABC"};
    wire.send('A', standard(0x555));
    draw_frame(wire);
    wire.send('A', standard(0x555));
    wire.send('C', standard(0x556));
    wire.draw({
        {"A", "      11 1 10101010101 000 00I00 110011101001100 1 1 1 1111111 111"},
        {"B", "      11 1 ----------- --- ----- --------------- - 0 - ------- ---"},
        {"C", "      11 1 1010101011- --- ----- --------------- - 0 - ------- ---"},
        {"bus", "    11 1 10101010101 000 00I00 110011101001100 1 0 1 1111111 111"},
        {"all see", ".. 0 ........... ... ..... ............... . . . ....... ..."},
    });
    EXPECT_EQ(wire['B'].received.size(), 2U);
    EXPECT_EQ(wire['C'].lost_at, Bits{9});
    for (const char node : {'A', 'B', 'C'}) EXPECT_EQ(wire[node].errors, Errors{});
    wire.pass_until_idle();
    EXPECT_EQ(wire['C'].sent.size(), 1U);
}

TEST(ThirdBitOfIntermission, MakesAReceiverOfAnErrorPassiveFormerSender) {
    Wire wire{"ABC"};
    fail_as_transmitter(wire['A'].processor, 20);
    wire.send('A', standard(0x555));
    draw_frame(wire);
    EXPECT_EQ(wire.status('A'), (ErrorStatus{ControllerState::error_passive, 159, 0}));
    wire.send('A', standard(0x001));
    wire.send('C', standard(0x555));
    wire.draw({
        {"A", "      11 1 ----------- --- ----- --------------- - 0 - ------- ---"},
        {"C", "      11 1 10101010101 000 00I00 110011101001100 1 1 1 1111111 111"},
        {"all see", ".. 0 ........... ... ..... ............... . . . ....... ..."},
    });
    EXPECT_EQ(wire['A'].received, std::vector{standard(0x555)});
}

TEST(ThirdBitOfIntermission, MakesAReceiverOfWhoHasNoFrame) {
    Wire wire{"AB"};
    wire.send('A', standard(0x555));
    draw_frame(wire);
    // SOF, and five recessive bits and one more.
    wire.draw({
        {"A", "      11 1 ------ 000000 11111111 111 1"},
        {"B", "      11 1 ------ 000000 11111111 111 1"},
        {"all see", ".. 0 ...... ...... ........ ... ."},
    });
    for (const char node : {'A', 'B'}) {
        EXPECT_EQ(
            wire[node].errors,
            (Errors{{53, {ErrorKind::stuff, stuff_after(FrameField::identifier, 4), false}}}));
        EXPECT_EQ(wire.status(node), (ErrorStatus{ControllerState::error_active, 0, 1}));
    }
}

// ---- suspend transmission

class SuspendTransmission : public testing::Test {
  protected:
    /// A, error passive, has just sent a frame.
    SuspendTransmission() {
        fail_as_transmitter(wire_['A'].processor, 20);
        wire_.send('A', standard(0x555));
        draw_frame(wire_);
        EXPECT_EQ(wire_.status('A'), (ErrorStatus{ControllerState::error_passive, 159, 0}));
    }

    Wire wire_{"AB"};
};

TEST_F(SuspendTransmission, IsEightBitsAfterTheIntermission) {
    wire_.send('A', standard(0x555));
    wire_.draw({
        {"A", "  111 11111111 0 10101010101 000 00I00"},
        {"bus", "111 11111111 0 10101010101 000 00I00"},
    });
}

TEST_F(SuspendTransmission, LetsOthersBeginWhateverTheirIdentifier) {
    wire_.send('A', standard(0x001));
    wire_.send('B', standard(0x555));
    // A receives. Its own frame waits for the intermission only, as it did not send the last one.
    wire_.draw({
        {"A", "  111 - ----------- --- ----- --------------- - 0 - ------- --- 0 0000I"},
        {"B", "  111 0 10101010101 000 00I00 110011101001100 1 1 1 1111111 111 - -----"},
        {"bus", "111 0 10101010101 000 00I00 110011101001100 1 0 1 1111111 111 0 00001"},
    });
}

TEST_F(SuspendTransmission, EndsWithTheSofOfAnother) {
    for (const int bit : {1, 4, 7}) {
        Wire wire{"AB"};
        wire['A'].processor = wire_['A'].processor;
        wire['B'].processor = wire_['B'].processor;
        wire.send('A', standard(0x001));
        wire.pass(3 + bit);
        wire.send('B', standard(0x555));
        wire.draw({
            {"A", "  - ----------- --- ----- --------------- - 0 - ------- --- 0 0000I"},
            {"B", "  0 10101010101 000 00I00 110011101001100 1 1 1 1111111 111 - -----"},
            {"bus", "0 10101010101 000 00I00 110011101001100 1 0 1 1111111 111 0 00001"},
        });
    }
}

TEST_F(SuspendTransmission, IsOverForAnArbitrationAfterEightBits) {
    wire_.send('A', standard(0x001));
    wire_.pass(3 + 8);
    wire_.send('B', standard(0x555));
    wire_.draw({
        {"A", "  0 0000I00000I01"},
        {"B", "  0 1------------"},
        {"bus", "0 0000I00000I01"},
    });
    EXPECT_EQ(wire_['B'].lost_at, Bits{0});
}

TEST_F(SuspendTransmission, FollowsAnOverloadFrame) {
    wire_.send('A', standard(0x555));
    wire_.draw({
        {"A", "      1 000000 11111111 111 11111111 0"},
        {"B", "      1 000000 11111111 111 -------- -"},
        {"all see", "0 ...... ........ ... ........ ."},
    });
}

TEST_F(SuspendTransmission, IsNotForTheLoserOfAnArbitration) {
    wire_.pass(3 + 8);
    wire_.send('A', standard(0x556));
    wire_.send('B', standard(0x555));
    wire_.draw({
        {"A", "  0 101010101 1 - --- ----- --------------- - 0 - ------- --- 0 10101010110"},
        {"B", "  0 101010101 0 1 000 00I00 110011101001100 1 1 1 1111111 111 - -----------"},
    });
}

}  // namespace
}  // namespace canorb::can::sim::test
