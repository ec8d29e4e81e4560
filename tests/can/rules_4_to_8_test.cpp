// Rules 4 to 8 of fault confinement, as CAN 2.0, chapter 8, numbers them: what bits and
// frames count.

#include <gtest/gtest.h>

#include "tests/can/rule_fixture.hpp"

namespace canorb::can::sim::test {
namespace {

// ---- 4 and 5: a bit error in an active error flag or overload flag: TEC + 8 or REC + 8

class Rule4 : public Rule {};
class Rule5 : public Rule {};
class Rules4And5 : public Rule {};

TEST_F(Rule4, ABitErrorInATransmittersErrorFlagCountsEight) {
    for (int place = 0; place < 6; ++place) {
        node_ = new_processor();
        be_in_error_flag(true);
        see(std::string(static_cast<std::size_t>(place), '0'));
        EXPECT_EQ(tec(), 8);
        see("1");
        EXPECT_EQ(node_.status(), (ErrorStatus{ControllerState::error_active, 16, 0}));
        EXPECT_EQ(node_.error(),
                  (ErrorCapture{ErrorKind::bit, in(FrameField::active_error_flag, place), true}));
    }
}

TEST_F(Rule4, ABitErrorInATransmittersOverloadFlagCountsEight) {
    be_in_overload_flag(true);
    see("00");
    EXPECT_EQ(tec(), 0);
    see("1");
    EXPECT_EQ(node_.status(), (ErrorStatus{ControllerState::error_active, 8, 0}));
    EXPECT_EQ(node_.error(),
              (ErrorCapture{ErrorKind::bit, in(FrameField::overload_flag, 2), true}));
}

TEST_F(Rule5, ABitErrorInAReceiversErrorFlagCountsEight) {
    for (int place = 0; place < 6; ++place) {
        node_ = new_processor();
        be_in_error_flag(false);
        see(std::string(static_cast<std::size_t>(place), '0'));
        EXPECT_EQ(rec(), 1);
        see("1");
        EXPECT_EQ(node_.status(), (ErrorStatus{ControllerState::error_active, 0, 9}));
        EXPECT_EQ(node_.error(),
                  (ErrorCapture{ErrorKind::bit, in(FrameField::active_error_flag, place), false}));
    }
}

TEST_F(Rule5, ABitErrorInAReceiversOverloadFlagCountsEight) {
    be_in_overload_flag(false);
    see("00000");
    EXPECT_EQ(rec(), 0);
    see("1");
    EXPECT_EQ(node_.status(), (ErrorStatus{ControllerState::error_active, 0, 8}));
    EXPECT_EQ(node_.error(),
              (ErrorCapture{ErrorKind::bit, in(FrameField::overload_flag, 5), false}));
}

TEST_F(Rules4And5, AFlagWithABitErrorIsSentAnewAndCountsAgain) {
    for (const bool transmitting : {true, false}) {
        node_ = new_processor();
        be_in_error_flag(transmitting);
        const int before = tec() + rec();
        see("000 1 000 1");
        EXPECT_EQ(tec() + rec(), before + 16);
        for (int bit = 0; bit < 6; ++bit) {
            EXPECT_EQ(node_.driven(), 0);
            see("0");
        }
        EXPECT_EQ(node_.driven(), 1);
        see(delimiter_and_intermission);
        EXPECT_TRUE(node_.may_start());
    }
}

TEST_F(Rules4And5, AreForFlagsThatAreDominant) {
    make_passive(node_);
    begin_to_send();
    see("1");
    EXPECT_EQ(tec(), 136);
    see("10 1 0 11 0 000000");
    EXPECT_EQ(tec(), 136) << "a passive flag may be overwritten";
}

// ---- 6: eight dominant bits after a flag, and each eight more: TEC + 8 or REC + 8

class Rule6 : public Rule {};

constexpr std::string_view seven = "0000000";

TEST_F(Rule6, The14thDominantBitOfATransmittersErrorFlagCountsEightAndEachEightMore) {
    be_in_error_flag(true);
    see(flag);
    see(seven);
    EXPECT_EQ(tec(), 8);
    see("0");
    EXPECT_EQ(tec(), 16);
    see(seven);
    EXPECT_EQ(tec(), 16);
    see("0");
    EXPECT_EQ(tec(), 24);
    see(seven);
    EXPECT_EQ(tec(), 24);
    see("0");
    EXPECT_EQ(tec(), 32);
    see(delimiter_and_intermission);
    EXPECT_EQ(node_.status(), (ErrorStatus{ControllerState::error_active, 32, 0}));
}

TEST_F(Rule6, The14thDominantBitOfAReceiversErrorFlagCountsEightAndEachEightMore) {
    be_in_error_flag(false);
    see(flag);
    see(seven);
    EXPECT_EQ(rec(), 1 + 8) << "rule 2";
    see("0");
    EXPECT_EQ(rec(), 17);
    see(seven);
    EXPECT_EQ(rec(), 17);
    see("0");
    EXPECT_EQ(rec(), 25);
    see(delimiter_and_intermission);
    EXPECT_EQ(node_.status(), (ErrorStatus{ControllerState::error_active, 0, 25}));
}

TEST_F(Rule6, The14thDominantBitOfAnOverloadFlagCountsEightAndEachEightMore) {
    for (const bool transmitting : {true, false}) {
        node_ = new_processor();
        be_in_overload_flag(transmitting);
        see(flag);
        see(seven);
        EXPECT_EQ(node_.status(), ErrorStatus{});
        see("0");
        EXPECT_EQ(transmitting ? tec() : rec(), 8);
        see(seven);
        see("0");
        EXPECT_EQ(transmitting ? tec() : rec(), 16);
        EXPECT_EQ(transmitting ? rec() : tec(), 0);
    }
}

TEST_F(Rule6, TheEighthDominantBitAfterATransmittersPassiveFlagCountsEightAndEachEightMore) {
    // A flag that nobody overwrites, and one that others do.
    for (const auto* passive_flag : {"111111", "000000", "1 000000"}) {
        node_ = new_processor();
        make_passive(node_);
        begin_to_send();
        see("1");
        see(passive_flag);
        see(seven);
        EXPECT_EQ(tec(), 136);
        see("0");
        EXPECT_EQ(tec(), 144);
        see(seven);
        see("0");
        EXPECT_EQ(tec(), 152);
        see(delimiter_and_intermission);
        EXPECT_EQ(tec(), 152);
    }
}

TEST_F(Rule6, TheEighthDominantBitAfterAReceiversPassiveFlagCountsEightAndEachEightMore) {
    fail_as_receiver(node_, 128);
    see("000000");
    see("111111");
    see(seven);
    EXPECT_EQ(rec(), 129 + 8) << "rule 2";
    see("0");
    EXPECT_EQ(rec(), 145);
    see(seven);
    see("0");
    EXPECT_EQ(rec(), 153);
}

// ---- 7: a frame was sent: TEC - 1

class Rule7 : public Rule {};

TEST_F(Rule7, ASuccessfulTransmissionCountsTecDownByOne) {
    fail_as_transmitter(node_, 1);
    for (int left = 7; left >= 0; --left) {
        send_successfully();
        EXPECT_EQ(tec(), left);
    }
    send_successfully();
    EXPECT_EQ(tec(), 0);
}

TEST_F(Rule7, NeedsTheWholeEof) {
    fail_as_transmitter(node_, 1);
    begin_to_send();
    see(up_to_crc);
    see("1 0 1 111111");
    EXPECT_EQ(tec(), 8);
    see("1");
    EXPECT_EQ(tec(), 7);
}

TEST_F(Rule7, ChangesNoRec) {
    fail_as_receiver(node_, 5);
    send_successfully();
    EXPECT_EQ(node_.status(), (ErrorStatus{ControllerState::error_active, 0, 5}));
}

// ---- 8: a frame was received: REC - 1, or back to 119 to 127

class Rule8 : public Rule {};

TEST_F(Rule8, ASuccessfulReceptionCountsRecDownByOne) {
    fail_as_receiver(node_, 127);
    for (int left = 126; left >= 0; --left) {
        receive_successfully();
        ASSERT_EQ(rec(), left);
    }
    receive_successfully();
    EXPECT_EQ(rec(), 0);
}

TEST_F(Rule8, ASuccessfulReceptionSetsAHighRecTo119To127) {
    for (const int errors : {128, 129, 200, 300}) {
        node_ = new_processor();
        fail_as_receiver(node_, errors);
        EXPECT_GE(rec(), 128);
        receive_successfully();
        EXPECT_GE(rec(), 119);
        EXPECT_LE(rec(), 127);
    }
}

TEST_F(Rule8, CountsAtTheAckSlotWhateverFollows) {
    fail_as_receiver(node_, 5);
    see(up_to_crc);
    see("1");
    EXPECT_EQ(rec(), 5);
    see("0");
    EXPECT_EQ(rec(), 4);
    see("1 0");  // a form error in EOF
    EXPECT_EQ(rec(), 5);
}

TEST_F(Rule8, NeedsTheCrcAndTheAckOnTheBus) {
    fail_as_receiver(node_, 5);
    see("0 10101010101 000 00I00 110011101001101 1 0");
    EXPECT_EQ(rec(), 5);
    node_ = new_processor();
    fail_as_receiver(node_, 5);
    see(up_to_crc);
    see("1 1");
    EXPECT_EQ(rec(), 6);
}

TEST_F(Rule8, ChangesNoTec) {
    fail_as_transmitter(node_, 1);
    receive_successfully();
    EXPECT_EQ(node_.status(), (ErrorStatus{ControllerState::error_active, 8, 0}));
}

}  // namespace
}  // namespace canorb::can::sim::test
