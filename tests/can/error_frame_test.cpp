// Error frames, overload frames and what is between frames, bit by bit, as CAN 2.0 B, chapters 3.2
// and 6, has them. The frame is mostly 0x555 without data:
//
//     0 10101010101 000 00I00 110011101001100 1 0 1 1111111
//
// SOF is bit 0, the stuff bit I 17, the CRC begins at 20, its delimiter is 35, the ACK slot 36, the
// ACK delimiter 37, EOF 38 to 44.

#include <gtest/gtest.h>

#include "tests/can/wire.hpp"

namespace canorb::can::sim::test {
namespace {

using Bits = std::vector<int>;
using Errors = std::vector<Wire::Error>;

constexpr ErrorStatus untouched{};

/// An error passive node.
ErrorStatus passive(std::uint16_t tec, std::uint16_t rec = 0) {
    return {ControllerState::error_passive, tec, rec};
}

ErrorStatus active(std::uint16_t tec, std::uint16_t rec = 0) {
    return {ControllerState::error_active, tec, rec};
}

void draw_up_to_crc(Wire& wire) {
    wire.draw({
        {"A", "  0 10101010101 000 00I00 110011101001100"},
        {"bus", "0 10101010101 000 00I00 110011101001100"},
    });
}

void draw_up_to_ack_slot(Wire& wire) {
    draw_up_to_crc(wire);
    wire.draw({{"A", "1 1"}, {"bus", "1 0"}});
}

/// The whole frame, up to its EOF.
void draw_frame(Wire& wire) {
    draw_up_to_ack_slot(wire);
    wire.draw({{"A", "1 1111111"}, {"bus", "1 1111111"}});
}

// ---- flags

TEST(ActiveErrorFlag, FollowsABitErrorAndMakesOthersSendTheirs) {
    Wire wire{"AB"};
    wire.send('A', standard(0x555, "55"));
    // The second bit of data. A's flag is a stuff error for B, whose flag follows it.
    wire.draw({
        //                          data       flags         delimiter intermission
        {"A", "  0 10101010101 000 00I01 01 000000 111111 11111111 111 0"},
        {"B", "  - ----------- --- ----- -- ------ 000000 11111111 111 -"},
        {"bus", "0 10101010101 000 00I01 01 000000 000000 11111111 111 0"},
        {"A sees", ". ........... ... ..... .0 ...... ...... ........ ... ."},
    });
    EXPECT_EQ(wire['A'].errors, (Errors{{21, {ErrorKind::bit, in(FrameField::data, 1), true}}}));
    EXPECT_EQ(wire['B'].errors,
              (Errors{{27, {ErrorKind::stuff, stuff_after(FrameField::data, 6), false}}}));
    EXPECT_EQ(wire.status('A'), active(8));
    EXPECT_EQ(wire.status('B'), active(0, 1));
    wire.pass_until_idle();
    EXPECT_EQ(wire['B'].received, std::vector{standard(0x555, "55")});
    EXPECT_EQ(wire.status('A'), active(7));
    EXPECT_EQ(wire.status('B'), active(0, 0));
}

TEST(ActiveErrorFlag, FollowsADominantBitThatIsRecessive) {
    Wire wire{"AB"};
    wire.send('A', standard(0x555, "55"));
    // The first bit of data. B sees it as A sent it, with five bits of the flag six dominant ones.
    wire.draw({
        {"A", "  0 10101010101 000 00I01 0 00000 0 11111 11111111 111 0"},
        {"B", "  - ----------- --- ----- - ----- 0 00000 11111111 111 -"},
        {"bus", "0 10101010101 000 00I01 0 00000 0 00000 11111111 111 0"},
        {"A sees", ". ........... ... ..... 1 ..... . ..... ........ ... ."},
    });
    EXPECT_EQ(wire['A'].errors, (Errors{{20, {ErrorKind::bit, in(FrameField::data), true}}}));
    EXPECT_EQ(wire.status('A'), active(8));
    EXPECT_EQ(wire.status('B'), active(0, 1));
}

TEST(ActiveErrorFlag, OfAReceiverIsABitErrorOfTheSender) {
    Wire wire{"ABC"};
    wire.send('A', standard(0x555));
    // B alone takes the stuff bit for the sixth dominant one. A's next recessive bit is the first
    // of the CRC. C sees a stuff error when B's flag is over. So B, whose flag was first, counts 8.
    wire.draw({
        //                                     flag of B, of A, of C
        {"A", "  0 10101010101 000 00I 00 1 000 000 111 11111111 111 0"},
        {"B", "  - ----------- --- --- 00 0 000 111 111 11111111 111 -"},
        {"C", "  - ----------- --- --- -- - --- 000 000 11111111 111 -"},
        {"bus", "0 10101010101 000 00I 00 0 000 000 000 11111111 111 0"},
        {"B sees", ". ........... ... ..0 .. . ... ... ... ........ ... ."},
    });
    EXPECT_EQ(
        wire['B'].errors,
        (Errors{{17, {ErrorKind::stuff, stuff_after(FrameField::data_length_code, 1), false}}}));
    EXPECT_EQ(wire['A'].errors, (Errors{{20, {ErrorKind::bit, in(FrameField::crc), true}}}));
    EXPECT_EQ(wire['C'].errors,
              (Errors{{23, {ErrorKind::stuff, stuff_after(FrameField::crc, 2), false}}}));
    EXPECT_EQ(wire.status('A'), active(8));
    EXPECT_EQ(wire.status('B'), active(0, 9));
    EXPECT_EQ(wire.status('C'), active(0, 1));
}

TEST(PassiveErrorFlag, OfASenderIsRecessiveAndWaitsForSixEqualBits) {
    Wire wire{"AB"};
    make_passive(wire['A'].processor);
    wire.send('A', standard(0x555, "55"));
    // The second bit of data and four of the flag are five recessive bits for B, the sixth is its
    // stuff error. B's flag is the six equal bits for which A waits.
    wire.draw({
        {"A", "  0 10101010101 000 00I01 01 11111 111111 11111111 111 11111111 0"},
        {"B", "  - ----------- --- ----- -- ----- 000000 11111111 111 -------- -"},
        {"bus", "0 10101010101 000 00I01 01 11111 000000 11111111 111 11111111 0"},
        {"A sees", ". ........... ... ..... .0 ..... ...... ........ ... ........ ."},
    });
    EXPECT_EQ(wire.status('A'), passive(136));
    EXPECT_EQ(wire.status('B'), active(0, 1));
}

TEST(PassiveErrorFlag, OfAReceiverDestroysNothing) {
    Wire wire{"ABC"};
    make_passive(wire['B'].processor);
    wire.send('A', standard(0x555));
    // B acknowledges nothing and has its six equal bits in the ACK delimiter and EOF. Its error
    // delimiter is the other two of EOF, the intermission and three bits more.
    wire.draw({
        {"A", "  0 10101010101 000 00I 00 110011101001100 1 1 1 11111 11 111 111 111"},
        {"B", "  - ----------- --- --- 11 111111111111111 1 1 1 11111 11 111 111 111"},
        {"C", "  - ----------- --- --- -- --------------- - 0 - ----- -- --- --- ---"},
        {"B sees", ". ........... ... ..0 .. ............... . . . ..... .. ... ... ..."},
    });
    EXPECT_EQ(wire['B'].errors.size(), 1U);
    EXPECT_EQ(wire['A'].sent, Bits{44});
    EXPECT_EQ(wire['C'].received_at, Bits{44});
    EXPECT_EQ(wire['B'].received_at, Bits{});
    EXPECT_EQ(wire.status('A'), untouched);
    EXPECT_EQ(wire.status('B'), passive(128, 1));
    EXPECT_TRUE(wire['B'].processor.may_start()) << "its error frame and intermission are over";
}

TEST(PassiveErrorFlag, IsFollowedByAFormErrorWhereTheNextFrameComesAtOnce) {
    Wire wire{"ABC"};
    make_passive(wire['B'].processor);
    wire.send('A', standard(0x555));
    wire.draw({
        {"A", "  0 10101010101 000 00I 00 110011101001100 1 1 1 11111 11"},
        {"B sees", ". ........... ... ..0 .. ............... . . . ..... .."},
    });
    wire.send('A', standard(0x555));
    // The sixth bit of B's error delimiter is a SOF.
    wire.draw({
        {"A", "  111 0 10101010101 000 00I00 110011101001100 1 1 1 11111 11 111 111 111"},
        {"B", "  111 1 11111111111 111 11111 111111111111111 1 1 1 11111 11 111 111 111"},
    });
    ASSERT_EQ(wire['B'].errors.size(), 2U);
    EXPECT_EQ(wire['B'].errors[1],
              (Wire::Error{48, {ErrorKind::form, in(FrameField::error_delimiter, 5), false}}));
    EXPECT_EQ(wire.status('B'), passive(128, 2));
    EXPECT_EQ(wire['C'].received.size(), 2U);
}

// ---- the end of a frame

TEST(CrcError, OfAReceiverHasItsFlagAfterTheAckDelimiter) {
    Wire wire{"ABC"};
    wire.send('A', standard(0x555));
    // The sixth bit of the identifier, without a stuff error.
    wire.draw({
        {"A", "  0 10101010101 000 00I00 110011101001100"},
        {"B sees", ". ....0...... ... ..... ..............."},
    });
    wire.draw({
        //       ACK    flag of B, of A and C
        {"A", "  1 1 1  1 00000 0 11111111 111 0"},
        {"B", "  - - -  0 00000 1 11111111 111 -"},
        {"C", "  - 0 -  - 00000 0 11111111 111 -"},
        {"bus", "1 0 1  0 00000 0 11111111 111 0"},
    });
    EXPECT_EQ(wire['B'].errors,
              (Errors{{37, {ErrorKind::crc, in(FrameField::ack_delimiter), false}}}));
    EXPECT_EQ(wire['A'].errors,
              (Errors{{38, {ErrorKind::form, in(FrameField::end_of_frame), true}}}));
    EXPECT_EQ(wire['C'].errors,
              (Errors{{38, {ErrorKind::form, in(FrameField::end_of_frame), false}}}));
    EXPECT_EQ(wire.status('A'), active(8));
    EXPECT_EQ(wire.status('B'), active(0, 1 + 8));
    EXPECT_EQ(wire.status('C'), active(0, 1));
}

TEST(CrcError, OfTheOnlyReceiverMakesTheSendersAckErrorFirst) {
    Wire wire{"AB"};
    wire.send('A', standard(0x555));
    wire.draw({
        {"A", "  0 10101010101 000 00I00 110011101001100"},
        {"B sees", ". ....0...... ... ..... ..............."},
    });
    // A's flag begins in the ACK delimiter: for B a form error, "unless an error flag for another
    // condition has already been started".
    wire.draw({
        {"A", "  1 1 0 00000 1 11111111 111 0"},
        {"B", "  - - - 00000 0 11111111 111 -"},
        {"bus", "1 1 0 00000 0 11111111 111 0"},
    });
    EXPECT_EQ(wire['A'].errors,
              (Errors{{36, {ErrorKind::acknowledgment, in(FrameField::ack_slot), true}}}));
    EXPECT_EQ(wire['B'].errors,
              (Errors{{37, {ErrorKind::form, in(FrameField::ack_delimiter), false}}}));
    EXPECT_EQ(wire.status('B'), active(0, 1));
}

TEST(FormError, OfADominantCrcDelimiter) {
    Wire wire{"AB"};
    wire.send('A', standard(0x555));
    draw_up_to_crc(wire);
    wire.draw({
        {"A", "      1 000000 11111111 111 0"},
        {"B", "      - 000000 11111111 111 -"},
        {"all see", "0 ...... ........ ... ."},
    });
    EXPECT_EQ(wire['A'].errors,
              (Errors{{35, {ErrorKind::form, in(FrameField::crc_delimiter), true}}}));
    EXPECT_EQ(wire['B'].errors,
              (Errors{{35, {ErrorKind::form, in(FrameField::crc_delimiter), false}}}));
    EXPECT_EQ(wire.status('A'), active(8));
    EXPECT_EQ(wire.status('B'), active(0, 1));
}

TEST(FormError, OfADominantAckDelimiter) {
    Wire wire{"AB"};
    wire.send('A', standard(0x555));
    draw_up_to_ack_slot(wire);
    wire.draw({
        {"A", "      1 000000 11111111 111 0"},
        {"B", "      - 000000 11111111 111 -"},
        {"all see", "0 ...... ........ ... ."},
    });
    EXPECT_EQ(wire['A'].errors,
              (Errors{{37, {ErrorKind::form, in(FrameField::ack_delimiter), true}}}));
    EXPECT_EQ(wire['B'].errors,
              (Errors{{37, {ErrorKind::form, in(FrameField::ack_delimiter), false}}}));
}

TEST(FormError, OfADominantBitInEof) {
    for (int bit = 0; bit < 6; ++bit) {
        Wire wire{"AB"};
        wire.send('A', standard(0x555));
        draw_up_to_ack_slot(wire);
        wire.pass(1 + bit);
        wire.draw({
            {"A", "      1 000000 11111111 111 0"},
            {"B", "      - 000000 11111111 111 -"},
            {"all see", "0 ...... ........ ... ."},
        });
        EXPECT_EQ(wire['A'].errors,
                  (Errors{{38 + bit, {ErrorKind::form, in(FrameField::end_of_frame, bit), true}}}));
        EXPECT_EQ(
            wire['B'].errors,
            (Errors{{38 + bit, {ErrorKind::form, in(FrameField::end_of_frame, bit), false}}}));
    }
}

TEST(BitError, OfAReceiverWhoseAckIsRecessive) {
    Wire wire{"ABC"};
    wire.send('A', standard(0x555));
    draw_up_to_crc(wire);
    // B sees its own ACK as recessive; A and C know it.
    wire.draw({
        {"A", "     1 1 1 0 00000 11111111 111 0"},
        {"B", "     - 0 0 0 00001 11111111 111 -"},
        {"C", "     - 0 - 0 00000 11111111 111 -"},
        {"bus", "   1 0 0 0 00000 11111111 111 0"},
        {"B sees", ". 1 . . ..... ........ ... ."},
    });
    EXPECT_EQ(wire['B'].errors, (Errors{{36, {ErrorKind::bit, in(FrameField::ack_slot), false}}}));
    EXPECT_EQ(wire['A'].errors,
              (Errors{{37, {ErrorKind::form, in(FrameField::ack_delimiter), true}}}));
    EXPECT_EQ(wire.status('B'), active(0, 9));
}

// ---- the two traps

TEST(LastButOneBitOfEof, DominantForAReceiverMakesOthersGetTheFrameTwice) {
    Wire wire{"ABC"};
    wire.send('A', standard(0x555));
    draw_up_to_ack_slot(wire);
    wire.draw({
        //                EOF     flags (C: overload)
        {"A", "     1 11111 1 1 00000 0 11111111 111 0"},
        {"B", "     - ----- - 0 00000 1 11111111 111 -"},
        {"C", "     - ----- - - 00000 0 11111111 111 -"},
        {"bus", "   1 11111 1 0 00000 0 11111111 111 0"},
        {"B sees", ". ..... 0 . ..... . ........ ... ."},
    });
    EXPECT_EQ(wire['A'].errors,
              (Errors{{44, {ErrorKind::form, in(FrameField::end_of_frame, 6), true}}}));
    EXPECT_EQ(wire['B'].errors,
              (Errors{{43, {ErrorKind::form, in(FrameField::end_of_frame, 5), false}}}));
    EXPECT_EQ(wire['C'].errors, Errors{});
    EXPECT_EQ(wire['C'].received_at, Bits{44});
    EXPECT_EQ(wire.status('A'), active(8));
    EXPECT_EQ(wire.status('B'), active(0, 9)) << "its flag was first";
    EXPECT_EQ(wire.status('C'), untouched);
    wire.pass_until_idle();
    EXPECT_EQ(wire['A'].sent.size(), 1U);
    EXPECT_EQ(wire['B'].received.size(), 1U);
    EXPECT_EQ(wire['C'].received.size(), 2U);
}

TEST(LastBitOfEof, DominantForAReceiverIsAnOverloadAndTheFrameIsAccepted) {
    Wire wire{"ABC"};
    wire.send('A', standard(0x555));
    draw_up_to_ack_slot(wire);
    wire.draw({
        //       EOF           overload flags
        {"A", "     1 111111 1 1 00000 0 11111111 111 1"},
        {"B", "     - ------ - 0 00000 1 11111111 111 1"},
        {"C", "     - ------ - - 00000 0 11111111 111 1"},
        {"bus", "   1 111111 1 0 00000 0 11111111 111 1"},
        {"B sees", ". ...... 0 . ..... . ........ ... ."},
    });
    EXPECT_EQ(wire['A'].sent, Bits{44});
    EXPECT_EQ(wire['B'].received_at, Bits{44});
    EXPECT_EQ(wire['C'].received_at, Bits{44});
    for (const char node : {'A', 'B', 'C'}) {
        EXPECT_EQ(wire[node].errors, Errors{});
        EXPECT_EQ(wire.status(node), untouched);
    }
}

TEST(LastBitOfEof, DominantForTheSenderIsAnErrorAndTheFrameIsRepeated) {
    Wire wire{"AB"};
    wire.send('A', standard(0x555));
    draw_up_to_ack_slot(wire);
    wire.draw({
        //                       A's flag, B's overload flag
        {"A", "     1 111111 1 0 00000 1 11111111 111 0"},
        {"B", "     - ------ - - 00000 0 11111111 111 -"},
        {"bus", "   1 111111 1 0 00000 0 11111111 111 0"},
        {"A sees", ". ...... 0 . ..... . ........ ... ."},
    });
    EXPECT_EQ(wire['A'].errors,
              (Errors{{44, {ErrorKind::form, in(FrameField::end_of_frame, 6), true}}}));
    EXPECT_EQ(wire['A'].sent, Bits{});
    EXPECT_EQ(wire['B'].received_at, Bits{44});
    wire.pass_until_idle();
    EXPECT_EQ(wire['A'].sent.size(), 1U);
    EXPECT_EQ(wire['B'].received.size(), 2U);
    EXPECT_EQ(wire.status('A'), active(7));
    EXPECT_EQ(wire.status('B'), untouched);
}

// ---- error delimiter

/// A frame whose CRC delimiter is dominant, up to the end of both flags.
void draw_up_to_error_delimiter(Wire& wire) {
    draw_up_to_crc(wire);
    wire.draw({{"A", "1 000000"}, {"B", "- 000000"}, {"all see", "0 ......"}});
}

TEST(ErrorDelimiter, ADominantBitInItIsAFormError) {
    for (int bit = 1; bit < 7; ++bit) {
        Wire wire{"AB"};
        wire.send('A', standard(0x555));
        draw_up_to_error_delimiter(wire);
        wire.pass(bit);
        wire.draw({
            {"A", "      1 000000 11111111 111 0"},
            {"B", "      - 000000 11111111 111 -"},
            {"all see", "0 ...... ........ ... ."},
        });
        EXPECT_EQ(
            wire['A'].errors.back(),
            (Wire::Error{42 + bit, {ErrorKind::form, in(FrameField::error_delimiter, bit), true}}));
        EXPECT_EQ(wire.status('A'), active(16));
        EXPECT_EQ(wire.status('B'), active(0, 2));
    }
}

TEST(ErrorDelimiter, ItsLastBitDominantIsAnOverload) {
    Wire wire{"AB"};
    wire.send('A', standard(0x555));
    draw_up_to_error_delimiter(wire);
    wire.draw({
        {"A", "      1111111 1 000000 11111111 111 0"},
        {"B", "      1111111 1 000000 11111111 111 -"},
        {"all see", "....... 0 ...... ........ ... ."},
    });
    EXPECT_EQ(wire['A'].errors.size(), 1U);
    EXPECT_EQ(wire.status('A'), active(8));
    EXPECT_EQ(wire.status('B'), active(0, 1));
}

TEST(OverloadDelimiter, ItsLastBitDominantIsAnotherOverload) {
    Wire wire{"AB"};
    wire.send('A', standard(0x555));
    draw_frame(wire);
    wire.draw({
        {"A", "      1 000000 1111111 1 000000 11111111 111 1"},
        {"B", "      1 000000 1111111 1 000000 11111111 111 1"},
        {"all see", "0 ...... ....... 0 ...... ........ ... ."},
    });
    EXPECT_EQ(wire.status('A'), untouched);
    EXPECT_EQ(wire.status('B'), untouched);
}

TEST(OverloadDelimiter, ADominantBitInItIsAFormError) {
    Wire wire{"AB"};
    wire.send('A', standard(0x555));
    draw_frame(wire);
    wire.draw({
        {"A", "      1 000000 111 1 000000 11111111 111 1"},
        {"B", "      1 000000 111 1 000000 11111111 111 1"},
        {"all see", "0 ...... ... 0 ...... ........ ... ."},
    });
    EXPECT_EQ(wire['A'].errors,
              (Errors{{55, {ErrorKind::form, in(FrameField::overload_delimiter, 3), true}}}));
    EXPECT_EQ(wire['A'].sent, Bits{44}) << "not repeated";
    EXPECT_EQ(wire.status('A'), active(8));
    EXPECT_EQ(wire.status('B'), active(0, 1));
}

}  // namespace
}  // namespace canorb::can::sim::test
