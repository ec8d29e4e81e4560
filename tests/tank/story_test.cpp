// The whole tank on a virtual clock. The expected numbers are worked out by hand from the round,
// the control law and the plant's 5 ms steps.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "orb/can/frame_length.hpp"
#include "tests/tank/recording.hpp"

namespace tank {
namespace {

using namespace std::chrono_literals;
using canorb::Duration;
using test::Recording;
using testing::HasSubstr;

TEST(TankStory, the_first_rounds_are_as_worked_out_by_hand) {
    Recording recording;
    VirtualTank tank{{}, recording.outputs()};
    tank.run_until(9s);

    // VS opens at the begin of node B's slot 6, at 300.23 ms; slot 6 has ten steps of 1 mm, a
    // round has 120.
    ASSERT_GE(recording.csv.size(), 15U);
    EXPECT_EQ(recording.csv[0], "0.350,1,50,N,50,20,1990,0,1");
    EXPECT_EQ(recording.csv[1], "0.950,2,50,N,50,20,1870,0,1");
    EXPECT_EQ(recording.csv[2], "1.550,3,50,N,50,20,1750,0,1");
    // Slot 1 of round 14 is 50 ms after 7.8 s, 1500 steps after VS opened at 0.3 s, and 50 ms
    // more: 2000 - 1500 - 10 = 490. A round later it is 370, below 400: VE opens in slot 6, after
    // 50 steps more, at 320. The slot itself has ten steps of +1.
    EXPECT_EQ(recording.csv[13], "8.150,14,50,N,50,20,430,0,1");
    EXPECT_EQ(recording.csv[14], "8.750,15,50,N,50,20,330,1,1");
}

TEST(TankStory, a_change_of_slots_takes_effect_with_the_next_round_on_both_sides) {
    Recording recording;
    VirtualTank tank{{.orders = {{700ms, 'h'}}}, recording.outputs()};
    tank.run_until(1400ms);
    // Round 2 began at 0.6 s with slots of 50 ms; round 3 begins at 1.2 s with 5 ms.
    ASSERT_GE(recording.csv.size(), 4U);
    EXPECT_EQ(recording.csv[1], "0.950,2,50,N,50,20,1870,0,1");
    // 1200 + 7 * 5 ms: 57 steps after the line before.
    EXPECT_EQ(recording.csv[2], "1.235,3,5,N,50,20,1813,0,1");
    EXPECT_EQ(recording.csv[3], "1.295,4,5,N,50,20,1801,0,1");
}

TEST(TankStory, an_alarm_closes_everything_until_the_temperature_is_safe_again) {
    Recording recording;
    VirtualTank tank{{.temperatures = {{1200ms, 260}, {2400ms, 250}}}, recording.outputs()};
    tank.run_until(3s);
    ASSERT_GE(recording.csv.size(), 5U);
    EXPECT_EQ(recording.csv[1], "0.950,2,50,N,50,20,1870,0,1");
    // Decided in slot 4, at 1.4 s; VS closes at 1.5 s, 110 steps after the line before.
    EXPECT_EQ(recording.csv[2], "1.550,3,50,A,50,260,1760,0,0");
    EXPECT_EQ(recording.csv[3], "2.150,4,50,A,50,260,1760,0,0");
    EXPECT_EQ(recording.csv[4], "2.750,5,50,N,50,250,1750,0,1");
    EXPECT_EQ(tank.plant().temperature_c, 250);
    ASSERT_NE(recording.find_line("A", "260 C: alarm mode"), nullptr);
    EXPECT_EQ(recording.find_line("A", "260 C: alarm mode")->time, 1400ms);
    ASSERT_NE(recording.find_line("A", "250 C: normal mode"), nullptr);
}

TEST(TankStory, orders_are_taken_one_a_round_the_oldest_first) {
    Recording recording;
    VirtualTank tank{{.orders = {{1s, 'x'}, {1s, '\r'}, {1s, '\n'}, {1s, 'c'}, {1s, 'd'}}},
                     recording.outputs()};
    tank.run_until(3s);
    // Slot 10 is 500 ms into the round. What is no order uses up its turn; ends of line do not.
    const Recording::Line* const unknown = recording.find_line("A", "'x' is no order");
    ASSERT_NE(unknown, nullptr);
    EXPECT_EQ(unknown->time, 1100ms);
    ASSERT_NE(recording.find_line("A", "setpoint 100 cm"), nullptr);
    EXPECT_EQ(recording.find_line("A", "setpoint 100 cm")->time, 1700ms);
    ASSERT_NE(recording.find_line("A", "setpoint 125 cm"), nullptr);
    EXPECT_EQ(recording.find_line("A", "setpoint 125 cm")->time, 2300ms);
    EXPECT_THAT(recording.terminal, HasSubstr("'x' is no order\r\n"));
}

TEST(TankStory, an_order_that_comes_at_the_begin_of_slot_10_is_in_time) {
    Recording recording;
    VirtualTank tank{{.orders = {{500ms, 'b'}}}, recording.outputs()};
    tank.run_until(1s);
    ASSERT_NE(recording.find_line("A", "setpoint 75 cm"), nullptr);
    EXPECT_EQ(recording.find_line("A", "setpoint 75 cm")->time, 500ms);
}

TEST(TankStory, slots_too_short_for_the_bus_are_refused) {
    Recording recording;
    VirtualTank tank{{.bitrate = 125'000, .orders = {{0s, 'h'}, {1s, 'j'}}}, recording.outputs()};
    tank.run_until(3s);
    EXPECT_THAT(recording.terminal,
                HasSubstr("slots of 5 ms refused: at 125000 bit/s they are too short\r\n"));
    EXPECT_EQ(tank.plant().slot_length, 10ms);
    VirtualTank fast{{.bitrate = 250'000, .orders = {{0s, 'h'}}}, {}};
    fast.run_until(3s);
    EXPECT_EQ(fast.plant().slot_length, 5ms);
    EXPECT_FALSE(fast.plant().controller_silent);
}

TEST(TankStory, the_operator_sees_the_status_in_every_round) {
    Recording recording;
    VirtualTank tank{{}, recording.outputs()};
    tank.run_until(600ms);
    EXPECT_EQ(
        recording.terminal,
        "mode normal, slot 50 ms, setpoint 50 cm, temperature 20 C, level 200.0 cm, VE closed, "
        "VS closed\r\n");
}

TEST(TankStory, the_level_is_regulated_around_every_setpoint) {
    const std::map<char, int> setpoints{{'a', 500}, {'b', 750}, {'c', 1000}, {'d', 1250}};
    for (const auto& [order, level_mm] : setpoints) {
        for (const char slots : {'h', 'j', 'k', 'l'}) {
            VirtualTank tank{{.orders = {{0s, order}, {0s, slots}}}, {}};
            tank.run_until(20s);
            // The band is 100 mm to either side; one round and a half passes from a level to what
            // is done about it, in which it moves by 0.2 mm in a ms.
            const auto round_ms = tank.plant().slot_length.count() * 12;
            const int margin = 100 + static_cast<int>(round_ms * 3 / 2 / 5) + 5;
            int lowest = 2000;
            int highest = 0;
            for (Duration time = 20s; time < 30s; time += 5ms) {
                tank.run_until(time);
                lowest = std::min<int>(lowest, tank.plant().level_mm);
                highest = std::max<int>(highest, tank.plant().level_mm);
            }
            EXPECT_GE(lowest, level_mm - margin) << order << slots;
            EXPECT_LE(highest, level_mm + margin) << order << slots;
            EXPECT_LT(lowest, level_mm - 100) << order << slots;
            EXPECT_GT(highest, level_mm + 100) << order << slots;
        }
    }
}

// Node A's grid, as the messages of the log themselves define it.
class Grid {
  public:
    void pass(Duration until) {
        while (until >= start_ + 12 * length_) {
            start_ += 12 * length_;
            length_ = next_length_;
        }
    }
    int slot(Duration time) const { return static_cast<int>((time - start_) / length_); }
    void set_next_length(Duration length) { next_length_ = length; }

  private:
    Duration start_{0};
    Duration length_ = 50ms;
    Duration next_length_ = 50ms;
};

class SlotOwners : public testing::TestWithParam<std::uint32_t> {};

TEST_P(SlotOwners, send_every_frame_within_a_slot_of_their_own) {
    const std::uint32_t bitrate = GetParam();
    Recording recording;
    VirtualTank tank{{.bitrate = bitrate,
                      .orders = {{1s, 'h'},
                                 {4s, 'j'},
                                 {7s, 'k'},
                                 {10s, 'l'},
                                 {14s, 'h'},
                                 {17s, 'l'},
                                 {20s, 'd'},
                                 {20s, 'j'}},
                      .temperatures = {{5s, -300}, {6s, 0}}},
                     recording.outputs()};
    tank.run_until(25s);
    ASSERT_GT(recording.frames.size(), 2000U);

    // Identifier and operation of the messages of each slot.
    using Message = std::pair<std::uint32_t, int>;
    const std::map<int, std::vector<Message>> messages{{0, {{0x021, 0}}},
                                                       {1, {{0x062, 0}}},
                                                       {2, {{0x062, 1}}},
                                                       {3, {{0x062, 2}}},
                                                       {5, {{0x041, 0}, {0x041, 1}, {0x041, 2}}},
                                                       {10, {{0x021, 1}}}};
    std::map<int, int> seen;
    Grid grid;
    Message message{};
    int last_slot = -1;
    std::size_t nth = 0;
    for (const auto& [end, frame] : recording.frames) {
        const auto bits = canorb::can::frame_length(frame) - canorb::can::intermission_bits;
        const Duration begin = end - Duration{std::int64_t{bits} * 1'000'000'000 / bitrate};
        grid.pass(begin);
        const int slot = grid.slot(begin);
        ASSERT_EQ(grid.slot(end), slot) << candump_line(end, frame);
        ASSERT_TRUE(messages.contains(slot)) << candump_line(end, frame);
        nth = slot == last_slot ? nth : 0;
        last_slot = slot;

        const bool first = (frame.data[0] & 0x80) == 0;
        if (first) {
            message = {frame.id, frame.data[7]};
            ASSERT_LT(nth, messages.at(slot).size()) << candump_line(end, frame);
            ASSERT_EQ(messages.at(slot)[nth], message) << candump_line(end, frame);
            ++nth;
            ++seen[slot];
        } else {
            ASSERT_EQ(frame.id, message.first);
            // The slot's duration: one octet of CCDR.
            if (message == Message{0x021, 1})
                grid.set_next_length(std::chrono::milliseconds{frame.data[1]});
        }
    }
    // Nothing was left out either.
    for (const auto& [slot, wanted] : messages)
        EXPECT_GE(seen[slot] + 3, seen[0] * static_cast<int>(wanted.size())) << slot;
}

INSTANTIATE_TEST_SUITE_P(Bitrates, SlotOwners, testing::Values(250'000U, 500'000U, 1'000'000U));

// At each slot duration: the order that sets it, and how long it is.
struct Slots {
    char order;
    std::chrono::milliseconds length;
};

class EachSlotLength : public testing::TestWithParam<Slots> {
  protected:
    // A tank with these slots, which fills; past the round in which VE opened.
    void fill(VirtualTank& tank) const {
        tank.run_until(5s);
        while (!tank.plant().valves.inlet_open) {
            ASSERT_LT(tank.now(), 20s);
            tank.run_until(tank.now() + 1ms);
        }
        ASSERT_EQ(tank.plant().slot_length, GetParam().length);
    }
    VirtualTank::Options options() const { return {.orders = {{0s, GetParam().order}}}; }
};

TEST_P(EachSlotLength, a_dead_controller_leaves_no_valve_open) {
    const Duration slot = GetParam().length;
    // From the begin of node B's slot 6 on, whatever slot node A dies in.
    for (int sixths = 0; sixths < 6 * 12; sixths += 5) {
        Recording recording;
        VirtualTank tank{options(), recording.outputs()};
        fill(tank);
        // fill() looks every ms: go to a known place, the end of slot 6.
        const std::size_t rounds = recording.rounds.size();
        while (recording.rounds.size() == rounds) tank.run_until(tank.now() + 100us);
        const Duration slot_6_ended = recording.rounds.back().time;
        tank.run_until(slot_6_ended + slot * sixths / 6);
        ASSERT_TRUE(tank.plant().valves.outlet_open);
        const Duration killed = tank.now();
        tank.stop_a();

        tank.run_until(killed + 40 * slot);
        const Recording::Line* const said =
            recording.find_line("B", "no actuation for 3 rounds", killed);
        ASSERT_NE(said, nullptr) << sixths;
        EXPECT_LE(said->time, killed + 37 * slot) << sixths;
        // Three rounds from the begin of the slot 6 in which the last actuations were applied: one
        // more than when node A was killed if it lived to the middle of its slot 5, 10 later.
        const Duration last_applied =
            (sixths > 60 ? recording.rounds.back().time : slot_6_ended) - slot;
        EXPECT_EQ(said->time, last_applied + 36 * slot) << sixths;
        EXPECT_EQ(tank.plant().valves, Valves{});
        EXPECT_TRUE(tank.plant().controller_silent);
        EXPECT_THAT(panel_of(tank.plant()).lines[0], HasSubstr("LOST"));
    }
}

TEST_P(EachSlotLength, a_restarted_controller_takes_over) {
    Recording recording;
    VirtualTank tank{options(), recording.outputs()};
    fill(tank);
    tank.stop_a();
    tank.run_until(tank.now() + 5s);
    ASSERT_TRUE(tank.plant().controller_silent);
    const Duration restarted = tank.now();
    tank.start_a();
    // It begins with the defaults; node B follows after a round.
    tank.run_until(restarted + 1300ms);
    EXPECT_EQ(tank.plant().slot_length, 50ms);
    EXPECT_FALSE(tank.plant().controller_silent);
    EXPECT_NE(recording.find_line("B", "the controller is back", restarted), nullptr);
    tank.run_until(restarted + 20s);
    EXPECT_NEAR(tank.plant().level_mm, 500, 300);
    EXPECT_EQ(recording.find_line("B", "no actuation", restarted), nullptr);
}

TEST_P(EachSlotLength, a_controller_back_at_once_is_not_missed) {
    Recording recording;
    VirtualTank tank{options(), recording.outputs()};
    fill(tank);
    tank.stop_a();
    const Duration restarted = tank.now() + GetParam().length / 2;
    tank.run_until(restarted);
    tank.start_a();
    tank.run_until(restarted + 20s);
    EXPECT_NEAR(tank.plant().level_mm, 500, 300);
    EXPECT_FALSE(tank.plant().controller_silent);
}

TEST_P(EachSlotLength, a_dead_plant_node_is_noticed) {
    const Duration slot = GetParam().length;
    Recording recording;
    VirtualTank tank{options(), recording.outputs()};
    fill(tank);
    const Duration killed = tank.now();
    tank.stop_b();
    tank.run_until(killed + 24 * slot);
    EXPECT_TRUE(tank.controller().level_stale);
    EXPECT_TRUE(tank.controller().wanted.outlet_open);
    EXPECT_EQ(panel_of(tank.controller()).lines[1].substr(11), "STALE");
    tank.run_until(killed + 48 * slot);
    EXPECT_EQ(tank.controller().wanted, Valves{});
    EXPECT_NE(recording.find_line("A", "no level for 3 rounds: both valves ordered closed", killed),
              nullptr);
    EXPECT_THAT(recording.terminal, HasSubstr(" STALE, "));
}

TEST_P(EachSlotLength, a_restarted_plant_node_is_regulated_again) {
    Recording recording;
    VirtualTank tank{options(), recording.outputs()};
    fill(tank);
    tank.stop_b();
    tank.run_until(tank.now() + 5s);
    const Duration restarted = tank.now();
    tank.start_b();
    // In step after two rounds at most; the slots are still those that were ordered.
    tank.run_until(restarted + 24 * GetParam().length + 700ms);
    EXPECT_EQ(tank.plant().slot_length, GetParam().length);
    EXPECT_FALSE(tank.controller().level_stale);
    EXPECT_NE(recording.find_line("A", "the level is back", restarted), nullptr);
    // A full tank again.
    EXPECT_GT(tank.plant().level_mm, 1500);
    tank.run_until(restarted + 20s);
    EXPECT_NEAR(tank.plant().level_mm, 500, 300);
}

INSTANTIATE_TEST_SUITE_P(Slots, EachSlotLength,
                         testing::Values(Slots{'h', 5ms}, Slots{'j', 10ms}, Slots{'k', 50ms},
                                         Slots{'l', 100ms}),
                         [](const auto& instance) {
                             return std::to_string(instance.param.length.count()) + "ms";
                         });

TEST(TankStory, changing_slots_is_never_taken_for_silence) {
    for (const char from : {'h', 'j', 'k', 'l'}) {
        for (const char to : {'h', 'j', 'k', 'l'}) {
            Recording recording;
            VirtualTank tank{{.orders = {{0s, from}, {3s, to}, {6s, from}, {7s, to}}},
                             recording.outputs()};
            tank.run_until(15s);
            EXPECT_EQ(recording.find_line("B", ""), nullptr) << from << to;
            EXPECT_EQ(recording.find_line("A", "no level"), nullptr) << from << to;
        }
    }
}

TEST(TankStory, is_the_same_every_time) {
    const VirtualTank::Options options{.orders = {{1s, 'h'}, {5s, 'c'}, {9s, 'l'}},
                                       .temperatures = {{7s, 300}, {8s, 20}}};
    Recording first;
    Recording second;
    for (Recording* recording : {&first, &second}) {
        VirtualTank tank{options, recording->outputs()};
        tank.run_until(20s);
    }
    EXPECT_EQ(first.csv, second.csv);
    ASSERT_EQ(first.frames.size(), second.frames.size());
    for (std::size_t i = 0; i < first.frames.size(); ++i) {
        EXPECT_EQ(candump_line(first.frames[i].end, first.frames[i].frame),
                  candump_line(second.frames[i].end, second.frames[i].frame));
    }
}

}  // namespace
}  // namespace tank
