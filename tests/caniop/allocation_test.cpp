// The message path of CANIOP does not touch the heap after construction.

#include <gtest/gtest.h>

#include <vector>

#include "orb/caniop/reassembler.hpp"
#include "orb/caniop/transmit_queue.hpp"
#include "tests/caniop/test_format.hpp"
#include "tests/support/allocations.hpp"

namespace canorb::caniop {
namespace {

using canorb::test::allocations;

TEST(Allocation, NoneWhenMessagesAreSentAndReceived) {
    Counters counters;
    TransmitQueue queue({.max_messages = 8, .max_octets = 1000});
    Reassembler reassembler({.max_message = 500}, test::message_format, counters);
    std::vector<std::uint8_t> message(300, 0x55);
    message[0] = 0x10;
    write_be16(&message[1], 297);

    const std::size_t before = allocations;
    std::uint64_t next_handle = 1;
    std::size_t sent = 0;
    for (int round = 0; round < 200; ++round) {
        for (std::uint8_t sender = 0; sender < 4; ++sender) {
            if (!queue.enqueue({true, 3, sender}, message, never)) break;
        }
        for (int step = 0; step < 60; ++step) {
            const auto frame = queue.next_frame(TimePoint{});
            if (!frame) break;
            const auto handle = can::TransmitHandle{next_handle++};
            queue.handed_over(handle);
            const auto reception = reassembler.accept(*Identifier::from_can_id(frame->id),
                                                      frame->payload(), TimePoint{});
            if (std::holds_alternative<Message>(reception)) ++sent;
            queue.on_result({handle, can::TransmitOutcome::sent, TimePoint{}}, TimePoint{});
            while (queue.next_finished()) {
            }
        }
        if (round % 50 == 49) {
            queue.fail_all(TimePoint{});
            while (queue.next_finished()) {
            }
            while (queue.next_abort()) {
            }
        }
    }
    EXPECT_EQ(allocations - before, 0U);
    EXPECT_GT(sent, 200U);
}

}  // namespace
}  // namespace canorb::caniop
