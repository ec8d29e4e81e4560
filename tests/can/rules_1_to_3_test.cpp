// Rules 1 to 3 of fault confinement, as CAN 2.0, chapter 8, numbers them: what a detected error
// counts.

#include <gtest/gtest.h>

#include "tests/can/rule_fixture.hpp"

namespace canorb::can::sim::test {
namespace {

// ---- 1: a receiver detects an error: REC + 1

class Rule1 : public Rule {};

TEST_F(Rule1, AReceiversStuffErrorCountsOne) {
    see("000000");
    EXPECT_EQ(rec(), 1);
    see(flag);
    see(delimiter_and_intermission);
    EXPECT_EQ(node_.status(), (ErrorStatus{ControllerState::error_active, 0, 1}));
}

TEST_F(Rule1, AReceiversCrcErrorCountsOne) {
    see("0 10101010101 000 00I00 110011101001101 1 0");  // the last bit of the CRC is wrong
    EXPECT_EQ(rec(), 0) << "not before the end of the ACK delimiter";
    see("1");
    EXPECT_EQ(rec(), 1);
}

TEST_F(Rule1, AReceiversFormErrorCountsOne) {
    for (const auto* rest : {"0", "1 0 0", "1 0 1 0", "1 0 1 1111 0"}) {
        node_ = new_processor();
        see(up_to_crc);
        see(rest);
        EXPECT_EQ(rec(), 1) << rest;
        EXPECT_EQ(node_.error().kind, ErrorKind::form);
    }
}

TEST_F(Rule1, AReceiversBitErrorInItsAckCountsOne) {
    see(up_to_crc);
    see("1 1");
    EXPECT_EQ(rec(), 1);
    EXPECT_EQ(node_.error().kind, ErrorKind::bit);
}

TEST_F(Rule1, ExceptForBitErrorsInItsOwnFlags) {
    be_in_error_flag(false);
    see("1");
    EXPECT_EQ(rec(), 1 + 8) << "by rule 5 alone";
    node_ = new_processor();
    be_in_overload_flag(false);
    see("1");
    EXPECT_EQ(rec(), 8);
}

// ---- 2: a receiver sees a dominant bit right after its error flag: REC + 8

class Rule2 : public Rule {};

TEST_F(Rule2, ADominantBitRightAfterAReceiversFlagCountsEight) {
    be_in_error_flag(false);
    see(flag);
    EXPECT_EQ(rec(), 1);
    see("0");
    EXPECT_EQ(rec(), 1 + 8);
    see("000000");  // seven in all: rule 6 is not reached
    see(delimiter_and_intermission);
    EXPECT_EQ(rec(), 1 + 8);
}

TEST_F(Rule2, ARecessiveBitAfterItCountsNothing) {
    be_in_error_flag(false);
    see(flag);
    see("1");
    EXPECT_EQ(rec(), 1);
}

TEST_F(Rule2, HoldsForPassiveErrorFlags) {
    fail_as_receiver(node_, 128);
    see("000000 111111");
    EXPECT_EQ(rec(), 129);
    see("0");
    EXPECT_EQ(rec(), 129 + 8);
}

TEST_F(Rule2, IsNotForOverloadFlags) {
    be_in_overload_flag(false);
    see(flag);
    see("0");
    EXPECT_EQ(rec(), 0);
}

TEST_F(Rule2, IsNotForTransmitters) {
    be_in_error_flag(true);
    see(flag);
    see("0");
    EXPECT_EQ(node_.status(), (ErrorStatus{ControllerState::error_active, 8, 0}));
}

TEST(Rule2OnAWire, TheReceiverThatDestroysAFrameCountsNineAndTheOthersOne) {
    Wire wire{"ABCD"};
    wire.send('A', standard(0x555));
    wire.draw({
        {"A", "  0 10101010101 000 00I 00 1 000 000 111 11111111 111 0"},
        {"B", "  - ----------- --- --- 00 0 000 111 111 11111111 111 -"},
        {"C", "  - ----------- --- --- -- - --- 000 000 11111111 111 -"},
        {"D", "  - ----------- --- --- -- - --- 000 000 11111111 111 -"},
        {"B sees", ". ........... ... ..0 .. . ... ... ... ........ ... ."},
    });
    EXPECT_EQ(wire.status('B').rec, 9);
    EXPECT_EQ(wire.status('C').rec, 1);
    EXPECT_EQ(wire.status('D').rec, 1);
    EXPECT_EQ(wire.status('A').rec, 0);
}

// ---- 3: a transmitter sends an error flag: TEC + 8

class Rule3 : public Rule {};

TEST_F(Rule3, EachKindOfErrorOfATransmitterCountsEight) {
    struct Case {
        std::string_view levels;
        ErrorKind kind;
    };
    for (const Case& each : {
             Case{"1", ErrorKind::bit},                          // SOF
             Case{"0 11", ErrorKind::bit},                       // identifier
             Case{"0 10101010101 1", ErrorKind::bit},            // RTR
             Case{"0 10101010101 000 000", ErrorKind::bit},      // a stuff bit
             Case{"0 10101010101 000 00I00 0", ErrorKind::bit},  // CRC
             Case{"0 10101010101 000 00I00 110011101001100 0", ErrorKind::form},
             Case{"0 10101010101 000 00I00 110011101001100 1 1", ErrorKind::acknowledgment},
             Case{"0 10101010101 000 00I00 110011101001100 1 0 0", ErrorKind::form},
             Case{"0 10101010101 000 00I00 110011101001100 1 0 1 1111110", ErrorKind::form},
         }) {
        node_ = new_processor();
        begin_to_send();
        see(each.levels);
        EXPECT_EQ(node_.status(), (ErrorStatus{ControllerState::error_active, 8, 0}))
            << each.levels;
        EXPECT_EQ(node_.error().kind, each.kind) << each.levels;
        EXPECT_TRUE(node_.error().transmitting);
        EXPECT_EQ(node_.driven(), 0);
    }
}

TEST_F(Rule3, AFormErrorInItsErrorDelimiterCountsEightMore) {
    be_in_error_flag(true);
    see(flag);
    see("111 0");
    EXPECT_EQ(tec(), 16);
}

class Rule3Exception1 : public Rule {
  protected:
    void send_without_ack() {
        begin_to_send();
        see(up_to_crc);
        see("1 1");
    }
};

TEST_F(Rule3Exception1, ALoneErrorPassiveTransmitterCountsNoAckErrors) {
    for (int attempt = 1; attempt <= 1000; ++attempt) {
        send_without_ack();
        settle(node_);
        ASSERT_EQ(tec(), std::min(8 * attempt, 128));
    }
    EXPECT_EQ(node_.status().state, ControllerState::error_passive);
}

TEST_F(Rule3Exception1, ADominantBitInItsPassiveFlagCountsAfterAll) {
    for (int place = 0; place < 6; ++place) {
        node_ = new_processor();
        make_passive(node_);
        send_without_ack();
        std::string levels = "111111";
        levels[static_cast<std::size_t>(place)] = '0';
        see(levels);
        EXPECT_EQ(tec(), 136) << place;
    }
}

TEST_F(Rule3Exception1, SeveralDominantBitsInItsPassiveFlagCountOnce) {
    make_passive(node_);
    send_without_ack();
    see("1 0 1 00 1 000000");
    EXPECT_EQ(tec(), 136);
}

TEST_F(Rule3Exception1, ADominantBitAfterTheFlagDoesNot) {
    make_passive(node_);
    send_without_ack();
    see("111111 0000000");
    EXPECT_EQ(tec(), 128);
}

TEST_F(Rule3Exception1, OtherErrorsOfAnErrorPassiveTransmitterCount) {
    make_passive(node_);
    begin_to_send();
    see(up_to_crc);
    see("1 0 0");
    EXPECT_EQ(tec(), 136);
}

TEST_F(Rule3Exception1, HoldsWhateverMadeItErrorPassive) {
    fail_as_receiver(node_, 128);
    send_without_ack();
    see("111111");
    EXPECT_EQ(node_.status(), (ErrorStatus{ControllerState::error_passive, 0, 128}));
}

class Rule3Exception2 : public Rule {};

TEST_F(Rule3Exception2, ARecessiveStuffBitInTheArbitrationThatIsOverwrittenCountsNothing) {
    begin_to_send(standard(0x00F));  // 0 0000I0001111
    see("0 0000 0");
    EXPECT_EQ(node_.error(),
              (ErrorCapture{ErrorKind::stuff, stuff_after(FrameField::identifier, 3), true}));
    EXPECT_EQ(tec(), 0);
    EXPECT_EQ(node_.driven(), 0) << "it sends a flag";
    see(flag);
    see(delimiter_and_intermission);
    EXPECT_EQ(node_.status(), ErrorStatus{});
    EXPECT_TRUE(node_.may_start());
}

TEST_F(Rule3Exception2, HoldsForTheStuffBitBetweenIdentifierAndRtr) {
    begin_to_send(standard(0x7E0));  // 0 11111O100000I 0
    see("0 11111O100000 0");
    EXPECT_EQ(tec(), 0);
    EXPECT_EQ(node_.error().position, stuff_after(FrameField::identifier, 10));
}

TEST_F(Rule3Exception2, DoesNotHoldForTheStuffBitAfterRtr) {
    begin_to_send(standard(0x7F0));  // 0 11111O110000 0I
    see("0 11111O110000 0 0");
    EXPECT_EQ(tec(), 8);
    EXPECT_EQ(node_.error(),
              (ErrorCapture{ErrorKind::bit, stuff_after(FrameField::remote_request), true}));
}

TEST_F(Rule3Exception2, HoldsInTheExtendedIdentifier) {
    begin_to_send(extended(0x555 << 18));  // 0 10101010101 11 00000I
    see("0 10101010101 11 00000 0");
    EXPECT_EQ(tec(), 0);
    EXPECT_EQ(node_.error().position, stuff_after(FrameField::extended_identifier, 4));
    EXPECT_EQ(node_.error().kind, ErrorKind::stuff);
}

TEST_F(Rule3Exception2, HoldsForTheStuffBitBetweenExtendedIdentifierAndRtr) {
    begin_to_send(extended((0x555 << 18) | 0b010101010101100000));
    see("0 10101010101 11 010101010101100000 0");
    EXPECT_EQ(tec(), 0);
    EXPECT_EQ(node_.error().position, stuff_after(FrameField::extended_identifier, 17));
}

TEST_F(Rule3Exception2, DoesNotHoldForTheStuffBitAfterAnExtendedRtr) {
    begin_to_send(extended((0x555 << 18) | 0b010101010101010000));
    see("0 10101010101 11 010101010101010000 0 0");
    EXPECT_EQ(tec(), 8);
    EXPECT_EQ(node_.error().position, stuff_after(FrameField::extended_remote_request));
}

TEST_F(Rule3Exception2, ADominantStuffBitThatIsRecessiveCounts) {
    begin_to_send(standard(0x7C1));  // 0 11111O0000I01
    see("0 11111 1");
    EXPECT_EQ(tec(), 8);
    EXPECT_EQ(node_.error(),
              (ErrorCapture{ErrorKind::bit, stuff_after(FrameField::identifier, 4), true}));
}

TEST_F(Rule3Exception2, AnOverwrittenStuffBitAfterTheArbitrationCounts) {
    begin_to_send();  // in the DLC
    see("0 10101010101 000 00 0");
    EXPECT_EQ(tec(), 8);
}

}  // namespace
}  // namespace canorb::can::sim::test
