// Rules 9 to 12 of fault confinement, as CAN 2.0, chapter 8, numbers them: error active, error
// passive and bus-off.

#include <gtest/gtest.h>

#include "tests/can/rule_fixture.hpp"

namespace canorb::can::sim::test {
namespace {

using State = ControllerState;

/// Takes steps with recessive bits until something has changed; how many.
int bits_to_change(BitStreamProcessor& processor, int limit) {
    for (int bit = 1; bit <= limit; ++bit) {
        if ((processor.step(1) & BitStreamProcessor::status_changed) != 0) return bit;
    }
    return 0;
}

// ---- 9: TEC or REC of 128 or more: error passive, and the error that did it has an active flag

class Rule9 : public Rule {
  protected:
    void expect_active_flag() {
        for (int bit = 0; bit < 6; ++bit) {
            EXPECT_EQ(node_.driven(), 0) << "bit " << bit << " of the flag";
            see("0");
        }
        EXPECT_EQ(node_.driven(), 1);
    }
};

TEST_F(Rule9, ATecOf128IsErrorPassive) {
    fail_as_transmitter(node_, 15);
    EXPECT_EQ(node_.status(), (ErrorStatus{State::error_active, 120, 0}));
    fail_as_transmitter(node_, 1);
    EXPECT_EQ(node_.status(), (ErrorStatus{State::error_passive, 128, 0}));
}

TEST_F(Rule9, ARecOf128IsErrorPassive) {
    fail_as_receiver(node_, 127);
    EXPECT_EQ(node_.status(), (ErrorStatus{State::error_active, 0, 127}));
    fail_as_receiver(node_, 1);
    EXPECT_EQ(node_.status(), (ErrorStatus{State::error_passive, 0, 128}));
}

TEST_F(Rule9, TheErrorThatMakesATransmitterPassiveStillHasAnActiveFlag) {
    fail_as_transmitter(node_, 15);
    begin_to_send();
    EXPECT_EQ(node_.step(1),
              BitStreamProcessor::detected_error | BitStreamProcessor::status_changed);
    EXPECT_EQ(node_.status().state, State::error_passive);
    expect_active_flag();
    settle(node_);
    begin_to_send();
    see("1");
    EXPECT_EQ(node_.driven(), 1) << "the next one has a passive flag";
}

TEST_F(Rule9, TheErrorThatMakesAReceiverPassiveStillHasAnActiveFlag) {
    fail_as_receiver(node_, 127);
    see("000000");
    EXPECT_EQ(node_.status().state, State::error_passive);
    expect_active_flag();
    settle(node_);
    see("000000");
    EXPECT_EQ(node_.driven(), 1) << "the next one has a passive flag";
}

TEST_F(Rule9, ABitErrorInAnErrorFlagThatMakesATransmitterPassiveIsFollowedByAnActiveFlag) {
    fail_as_transmitter(node_, 14);
    begin_to_send();
    see("1 00");
    EXPECT_EQ(node_.status(), (ErrorStatus{State::error_active, 120, 0}));
    see("1");
    EXPECT_EQ(node_.status(), (ErrorStatus{State::error_passive, 128, 0}));
    expect_active_flag();
}

TEST_F(Rule9, ABitErrorInAnErrorFlagThatMakesAReceiverPassiveIsFollowedByAnActiveFlag) {
    fail_as_receiver(node_, 120);
    see("000000");
    EXPECT_EQ(rec(), 121);
    see("1");
    EXPECT_EQ(node_.status(), (ErrorStatus{State::error_passive, 0, 129}));
    expect_active_flag();
}

TEST_F(Rule9, ABitErrorInAnOverloadFlagThatMakesItPassiveIsFollowedByAnActiveFlag) {
    for (const bool transmitting : {true, false}) {
        node_ = new_processor();
        if (transmitting) {
            fail_as_transmitter(node_, 16);
        } else {
            fail_as_receiver(node_, 127);
        }
        be_in_overload_flag(transmitting);
        EXPECT_EQ(node_.status().state, State::error_active) << "by rules 7, 8 and 11";
        see("000 1");
        EXPECT_EQ(node_.status().state, State::error_passive);
        expect_active_flag();
    }
}

TEST_F(Rule9, ABitErrorInAnActiveFlagOfANodeThatIsPassiveAlreadyIsFollowedByAPassiveOne) {
    fail_as_transmitter(node_, 15);
    begin_to_send();
    see("1 00 1");
    EXPECT_EQ(tec(), 136);
    EXPECT_EQ(node_.driven(), 1);
}

TEST_F(Rule9, AnErrorPassiveReceiverSendsAPassiveFlagAsTransmitterToo) {
    fail_as_receiver(node_, 128);
    begin_to_send();
    see("1");
    EXPECT_EQ(node_.driven(), 1);
    EXPECT_EQ(node_.status(), (ErrorStatus{State::error_passive, 8, 128}));
}

TEST_F(Rule9, AnOverloadFlagIsDominantWhateverTheState) {
    fail_as_receiver(node_, 200);
    fail_as_transmitter(node_, 2);
    be_in_overload_flag(true);
    expect_active_flag();
}

TEST_F(Rule9, AnErrorPassiveReceiverAcknowledges) {
    make_passive(node_);
    see(up_to_crc);
    see("1");
    EXPECT_EQ(node_.driven(), 0);
}

// ---- 10: TEC of 256 or more: bus-off

class Rule10 : public Rule {
  protected:
    void fail_until_bus_off() {
        make_passive(node_);
        fail_as_transmitter(node_, 15);
        begin_to_send();
        see("1");
        ASSERT_EQ(node_.status(), (ErrorStatus{State::bus_off, 256, 0}));
    }
};

TEST_F(Rule10, ATecOf256IsBusOff) {
    make_passive(node_);
    fail_as_transmitter(node_, 15);
    EXPECT_EQ(node_.status(), (ErrorStatus{State::error_passive, 248, 0}));
    begin_to_send();
    EXPECT_EQ(node_.step(1),
              BitStreamProcessor::detected_error | BitStreamProcessor::status_changed);
    EXPECT_EQ(node_.status(), (ErrorStatus{State::bus_off, 256, 0}));
}

TEST_F(Rule10, ATecOf255IsNotBusOff) {
    fail_as_transmitter(node_, 17);
    send_successfully();
    fail_as_transmitter(node_, 15);
    EXPECT_EQ(node_.status(), (ErrorStatus{State::error_passive, 255, 0}));
    begin_to_send();
    see("1");
    EXPECT_EQ(node_.status().state, State::bus_off);
}

TEST_F(Rule10, NoRecIsBusOff) {
    fail_as_receiver(node_, 1000);
    EXPECT_EQ(node_.status().state, State::error_passive);
    EXPECT_GE(rec(), 128);
}

TEST_F(Rule10, DominantBitsAfterAFlagLeadToItAsWell) {
    make_passive(node_);
    fail_as_transmitter(node_, 14);
    begin_to_send();
    see("1 111111 0000000");
    EXPECT_EQ(node_.status(), (ErrorStatus{State::error_passive, 248, 0}));
    see("0");
    EXPECT_EQ(node_.status(), (ErrorStatus{State::bus_off, 256, 0}));
}

TEST_F(Rule10, ABusOffNodeIsSilent) {
    fail_until_bus_off();
    // The flag of others, a frame for which an ACK is missing, a stuff error, an overload.
    for (const auto* levels :
         {"000000 11111111 111", "0 10101010101 000 00I00 110011101001100 1 1 1 1111111 111",
          "000000000000", "1111111 0"}) {
        for (const char c : std::string_view{levels}) {
            EXPECT_EQ(node_.driven(), 1);
            EXPECT_FALSE(node_.may_start());
            see(std::string_view{&c, 1});
        }
    }
    EXPECT_EQ(node_.status(), (ErrorStatus{State::bus_off, 256, 0}));
}

TEST(Rule10OnAWire, ABusOffNodeDoesNotAcknowledge) {
    Wire wire{"AB"};
    fail_as_transmitter(wire['B'].processor, 31);
    begin(wire['B'].processor, standard(0x555));
    feed(wire['B'].processor, "1");
    wire.send('A', standard(0x555));
    wire.draw({
        {"A", "  0 10101010101 000 00I00 110011101001100 1 1 000000 11111111 111 0"},
        {"B", "  1 11111111111 111 11111 111111111111111 1 1 111111 11111111 111 1"},
        {"bus", "0 10101010101 000 00I00 110011101001100 1 1 000000 11111111 111 0"},
    });
    EXPECT_EQ(wire['B'].received, std::vector<Frame>{});
}

// ---- 11: TEC and REC of 127 or less: error active again

class Rule11 : public Rule {};

TEST_F(Rule11, ATecBackAt127IsErrorActive) {
    make_passive(node_);
    begin_to_send();
    see(up_to_crc);
    see("1 0 1 111111");
    EXPECT_EQ(node_.status(), (ErrorStatus{State::error_passive, 128, 0}));
    EXPECT_EQ(node_.step(1), BitStreamProcessor::sent | BitStreamProcessor::status_changed);
    EXPECT_EQ(node_.status(), (ErrorStatus{State::error_active, 127, 0}));
    see("111");
    EXPECT_TRUE(node_.may_start()) << "no suspend transmission any more";
    see("000000");
    EXPECT_EQ(node_.driven(), 0) << "an active flag";
}

TEST_F(Rule11, ARecBackAt127IsErrorActiveFromTheAckSlotOn) {
    fail_as_receiver(node_, 128);
    see(up_to_crc);
    see("1");
    EXPECT_EQ(node_.status().state, State::error_passive);
    EXPECT_EQ(node_.step(0), BitStreamProcessor::status_changed);
    EXPECT_EQ(node_.status().state, State::error_active);
    EXPECT_LE(rec(), 127);
}

TEST_F(Rule11, NeedsBothCounts) {
    make_passive(node_);
    fail_as_receiver(node_, 128);
    EXPECT_EQ(node_.status(), (ErrorStatus{State::error_passive, 128, 128}));
    receive_successfully();
    EXPECT_EQ(node_.status().state, State::error_passive);
    EXPECT_LE(rec(), 127);
    send_successfully();
    EXPECT_EQ(node_.status().state, State::error_active);
    EXPECT_EQ(tec(), 127);
}

// ---- 12: bus-off ends after 128 times 11 recessive bits, with TEC and REC 0

class Rule12 : public Rule10 {
  protected:
    Rule12() { fail_until_bus_off(); }

    void expect_error_active() {
        EXPECT_EQ(node_.status(), ErrorStatus{});
        EXPECT_TRUE(node_.may_start());
    }
};

TEST_F(Rule12, BusOffEndsAfter128Times11RecessiveBits) {
    node_.recover(false);
    EXPECT_EQ(bits_to_change(node_, 2000), 128 * 11);
    expect_error_active();
}

TEST_F(Rule12, BitsThatWereBeforeTheRequestDoNotCount) {
    EXPECT_EQ(bits_to_change(node_, 10'000), 0);
    node_.recover(false);
    EXPECT_EQ(bits_to_change(node_, 2000), 128 * 11);
}

TEST_F(Rule12, TheBitOfTheRequestDoesNotCount) {
    node_.recover(true);
    EXPECT_EQ(bits_to_change(node_, 2000), 1 + 128 * 11);
}

TEST_F(Rule12, ASecondRequestChangesNothing) {
    node_.recover(false);
    for (int bit = 0; bit < 500; ++bit) node_.step(1);
    node_.recover(false);
    EXPECT_EQ(bits_to_change(node_, 2000), 128 * 11 - 500);
}

TEST_F(Rule12, ADominantBitRestartsARunOf11) {
    node_.recover(false);
    for (int run = 0; run < 1000; ++run) see("1111111111 0");
    EXPECT_EQ(node_.status().state, State::bus_off);
    EXPECT_EQ(bits_to_change(node_, 2000), 128 * 11);
}

TEST_F(Rule12, ADominantBitDoesNotRestartTheCountOfRuns) {
    node_.recover(false);
    for (int run = 0; run < 127; ++run) see("11111111111 0 1111111111 0");
    EXPECT_EQ(node_.status().state, State::bus_off);
    EXPECT_EQ(bits_to_change(node_, 100), 11);
    expect_error_active();
}

TEST_F(Rule12, ARunOf22IsTwo) {
    node_.recover(false);
    for (int run = 0; run < 63; ++run) see("1111111111111111111111 0 111 0");
    EXPECT_EQ(bits_to_change(node_, 100), 22);
}

TEST_F(Rule12, AFrameOfOthersHasOneRun) {
    // ACK delimiter, EOF and intermission, between frames that follow each other closely.
    node_.recover(false);
    for (int frame = 0; frame < 127; ++frame) {
        see(up_to_crc);
        see("1 0 1 1111111 111");
    }
    EXPECT_EQ(node_.status().state, State::bus_off);
    see(up_to_crc);
    see("1 0 1 1111111 11");
    EXPECT_EQ(node_.status().state, State::bus_off);
    see("1");
    expect_error_active();
}

TEST_F(Rule12, TheNodeStartsAfresh) {
    node_.recover(false);
    bits_to_change(node_, 2000);
    begin_to_send();
    see("1");
    EXPECT_EQ(node_.status(), (ErrorStatus{State::error_active, 8, 0}));
    EXPECT_EQ(node_.driven(), 0);
}

TEST_F(Rule12, BothCountsAre0Afterwards) {
    node_ = new_processor();
    fail_as_receiver(node_, 200);
    fail_as_transmitter(node_, 31);
    begin_to_send();
    see("1");
    EXPECT_EQ(node_.status(), (ErrorStatus{State::bus_off, 256, 200}));
    node_.recover(false);
    bits_to_change(node_, 2000);
    expect_error_active();
}

TEST_F(Rule12, ARequestElsewhereIsIgnored) {
    node_ = new_processor();
    make_passive(node_);
    node_.recover(false);
    EXPECT_EQ(bits_to_change(node_, 2000), 0);
    EXPECT_EQ(node_.status(), (ErrorStatus{State::error_passive, 128, 0}));
}

TEST(Rule12Automatically, BusOffEndsWithoutARequest) {
    BitStreamProcessor node{true, BitStreamProcessor::integration_bits};
    fail_as_transmitter(node, 31);
    for (int time = 0; time < 2; ++time) {
        begin(node, standard(0x555));
        feed(node, "1");
        ASSERT_EQ(node.status().state, State::bus_off);
        feed(node, "0");
        EXPECT_EQ(bits_to_change(node, 2000), 128 * 11);
        EXPECT_EQ(node.status(), ErrorStatus{});
        fail_as_transmitter(node, 31);
    }
}

}  // namespace
}  // namespace canorb::can::sim::test
