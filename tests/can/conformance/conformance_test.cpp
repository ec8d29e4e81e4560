// What every link has to do, whatever is behind it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>

#include <array>
#include <deque>
#include <thread>

#include "orb/can/frame_length.hpp"
#include "orb/can/link/link.hpp"
#include "tests/can/conformance/test_bus.hpp"

namespace canorb::can::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;
using Ids = std::vector<std::uint32_t>;

constexpr std::array<Filter, 2> accept_all{Filter{0, 0, false}, Filter{0, 0, true}};

Frame data_frame(std::uint32_t id, std::vector<std::uint8_t> payload = {}) {
    return Frame::standard(id, payload);
}

Frame extended_frame(std::uint32_t id, std::vector<std::uint8_t> payload = {}) {
    Frame frame = Frame::standard(0, payload);
    frame.id = id;
    frame.extended = true;
    return frame;
}

Frame remote_frame(std::uint32_t id, std::uint8_t length) {
    Frame frame;
    frame.id = id;
    frame.remote = true;
    frame.length = length;
    return frame;
}

class Conformance : public testing::TestWithParam<LinkKind> {
  protected:
    static constexpr std::uint32_t bitrate = 500'000;
    /// The last frame of a test: what has not arrived before it never will.
    static constexpr std::uint32_t sentinel = 0x7EF;

    void open(std::uint32_t rate = bitrate) { bus_ = GetParam().open(rate); }

    /// A new node that accepts everything.
    Station& station() {
        Station& added = stations_.emplace_back(bus_->attach());
        EXPECT_TRUE(added->set_filters(accept_all));
        return added;
    }

    /// A new node that receives everything but acknowledges nothing yet, so that other nodes'
    /// frames wait until release(). Only together with one other node.
    Station& holding_station() {
        Station& added = station();
        added.drops_repetitions = true;
        EXPECT_TRUE(added->set_listen_only(true));
        EXPECT_TRUE(until([&] { return bus_->is_silent(*added); }));
        return added;
    }
    void release(Station& holder) { EXPECT_TRUE(holder->set_listen_only(false)); }

    TransmitHandle send(Station& from, const Frame& frame, SendOptions options = {}) {
        const SendResult result = from->send(frame, options);
        if (const auto* sent = std::get_if<TransmitResult>(&result)) {
            from.results.push_back(*sent);
            return sent->handle;
        }
        const auto* handle = std::get_if<TransmitHandle>(&result);
        EXPECT_NE(handle, nullptr)
            << "send() refused: " << static_cast<int>(std::get<SendError>(result));
        return handle != nullptr ? *handle : TransmitHandle{};
    }

    template <typename Condition>
    bool until(Condition condition) {
        while (true) {
            std::vector<Controller*> controllers;
            for (Station& each : stations_) {
                each.drain();
                if (each.is_attached()) controllers.push_back(&*each);
            }
            if (condition()) return true;
            if (!bus_->wait(controllers)) return false;
        }
    }

    /// Sends the sentinel and waits for it.
    void expect_sentinel(Station& from, Station& to) {
        send(from, data_frame(sentinel));
        EXPECT_TRUE(
            until([&] { return !to.received.empty() && to.received.back().frame.id == sentinel; }));
    }

    std::unique_ptr<TestBus> bus_;
    std::deque<Station> stations_;
};

/// Tests in which frames have to wait until the test lets them go.
class WaitingFrames : public Conformance {
  protected:
    /// Goes out before all others, so it does not matter that a link may have handed it on already
    /// when the others come.
    static constexpr std::uint32_t foremost = 0x001;

    void SetUp() override {
        open();
        if (!GetParam().acknowledges || !bus_->attach()->capabilities().listen_only) {
            GTEST_SKIP() << "on this link nothing keeps frames from going out at once";
        }
    }
};

TEST_P(Conformance, TellsItsCapabilities) {
    open();
    const Capabilities capabilities = station()->capabilities();
    EXPECT_EQ(capabilities.max_payload, 8);
    EXPECT_GE(capabilities.mailboxes, 2U);
    EXPECT_TRUE(capabilities.bitrate == 0 || capabilities.bitrate == bitrate);
}

TEST_P(Conformance, StartsErrorActive) {
    open();
    EXPECT_EQ(station()->error_status(), ErrorStatus{});
}

TEST_P(Conformance, DeliversEveryKindOfFrameUnchanged) {
    open();
    Station& sender = station();
    Station& receiver = station();
    std::vector<Frame> frames{
        data_frame(0x000),
        data_frame(0x123, {0xDE, 0xAD, 0xBE, 0xEF}),
        data_frame(0x7EF, {0, 0, 0, 0, 0, 0, 0, 0}),
        extended_frame(0x00000000, {0xFF}),
        extended_frame(0x1FFFFFFF, {1, 2, 3, 4, 5, 6, 7, 8}),
        remote_frame(0x321, 0),
    };
    if (GetParam().remote_length) frames.push_back(remote_frame(0x321, 8));
    for (std::size_t i = 0; i < frames.size(); ++i) {
        send(sender, frames[i]);
        ASSERT_TRUE(until([&] { return receiver.received.size() > i; }));
        EXPECT_EQ(receiver.received[i].frame, frames[i]) << i;
    }
}

TEST_P(Conformance, TellsTheSenderOnceAndWithTheReceiversTime) {
    open();
    Station& sender = station();
    Station& receiver = station();
    const TransmitHandle handle = send(sender, data_frame(0x100, {1}));
    ASSERT_TRUE(until([&] { return !sender.results.empty() && !receiver.received.empty(); }));
    expect_sentinel(sender, receiver);
    ASSERT_FALSE(sender.results.empty());
    EXPECT_EQ(sender.results[0].handle, handle);
    EXPECT_EQ(sender.results[0].outcome, TransmitOutcome::sent);
    if (GetParam().one_clock) {
        EXPECT_EQ(sender.results[0].time, receiver.received[0].time);
    }
    ASSERT_TRUE(until([&] { return sender.results.size() >= 2; }));
    EXPECT_THAT(sender.results, SizeIs(2));
}

TEST_P(Conformance, DoesNotReceiveItsOwnFrames) {
    open();
    Station& sender = station();
    Station& receiver = station();
    send(sender, data_frame(0x100));
    expect_sentinel(receiver, sender);
    EXPECT_EQ(sender.received_ids(), Ids{sentinel});
}

TEST_P(Conformance, ReachesAllOtherNodes) {
    open();
    Station& sender = station();
    Station& first = station();
    Station& second = station();
    send(sender, data_frame(0x100, {7}));
    EXPECT_TRUE(until([&] { return !first.received.empty() && !second.received.empty(); }));
    if (GetParam().one_clock) {
        EXPECT_EQ(first.received[0].time, second.received[0].time);
    }
}

TEST_P(Conformance, DeliversABurstInOrder) {
    open();
    Station& sender = station();
    Station& receiver = station();
    const auto mailboxes = static_cast<std::uint8_t>(sender->capabilities().mailboxes);
    for (std::uint8_t i = 0; i < mailboxes; ++i) send(sender, data_frame(0x100, {i}));
    ASSERT_TRUE(until([&] { return receiver.received.size() >= mailboxes; }));
    for (std::uint8_t i = 0; i < mailboxes; ++i) EXPECT_EQ(receiver.received[i].frame.data[0], i);
}

TEST_P(WaitingFrames, KeepsTheOrderWithinAnIdentifier) {
    Station& sender = station();
    Station& holder = holding_station();
    const auto mailboxes = static_cast<std::uint8_t>(sender->capabilities().mailboxes);
    for (std::uint8_t i = 0; i < mailboxes; ++i) send(sender, data_frame(0x100, {i}));
    release(holder);
    ASSERT_TRUE(until([&] { return holder.received.size() >= mailboxes; }));
    for (std::uint8_t i = 0; i < mailboxes; ++i) EXPECT_EQ(holder.received[i].frame.data[0], i);
}

TEST_P(WaitingFrames, SendsTheLowestIdentifierFirst) {
    Station& sender = station();
    Station& holder = holding_station();
    if (sender->capabilities().fifo) GTEST_SKIP() << "this link's mailboxes are a queue";
    for (const std::uint32_t id : {foremost, 0x300U, 0x100U, 0x7EFU, 0x200U}) {
        send(sender, data_frame(id));
    }
    release(holder);
    ASSERT_TRUE(until([&] { return holder.received.size() >= 5; }));
    EXPECT_EQ(holder.received_ids(), (Ids{foremost, 0x100, 0x200, 0x300, 0x7EF}));
}

TEST_P(WaitingFrames, SendsDataBeforeRemoteBeforeExtended) {
    Station& sender = station();
    Station& holder = holding_station();
    send(sender, data_frame(foremost));
    send(sender, extended_frame(0x100U << 18));
    send(sender, remote_frame(0x100, 0));
    send(sender, data_frame(0x100));
    release(holder);
    ASSERT_TRUE(until([&] { return holder.received.size() >= 4; }));
    EXPECT_FALSE(holder.received[1].frame.remote);
    EXPECT_TRUE(holder.received[2].frame.remote);
    EXPECT_TRUE(holder.received[3].frame.extended);
}

TEST_P(WaitingFrames, FramesOccupyTheBusForTheirExactLength) {
    if (!GetParam().exact_times) GTEST_SKIP() << "the time stamps are those of reading";
    Station& sender = station();
    Station& holder = holding_station();
    const std::array<Frame, 3> frames{data_frame(0x100, {0, 0, 0, 0}), data_frame(0x200),
                                      data_frame(0x300, {1, 2, 3, 4, 5, 6, 7, 8})};
    for (const Frame& frame : frames) send(sender, frame);
    release(holder);
    ASSERT_TRUE(until([&] { return holder.received.size() >= frames.size(); }));
    for (std::size_t i = 1; i < frames.size(); ++i) {
        const Duration distance = holder.received[i].time - holder.received[i - 1].time;
        EXPECT_EQ(distance, frame_length(frames[i]) * Duration{2000}) << i;  // at 500 kbit/s
    }
}

TEST_P(Conformance, ArbitratesBetweenNodes) {
    if (!GetParam().keeps_to_clock) {
        GTEST_SKIP() << "frames cannot be made to wait for each other on this link; the tests of "
                        "Bus cover it";
    }
    open(10'000);  // a frame takes 10 ms and more: time enough to send others meanwhile
    Station& first = station();
    Station& second = station();
    for (int attempt = 0; attempt < 20; ++attempt) {
        first.received.clear();
        second.received.clear();
        send(first, data_frame(0x400, {1, 2, 3, 4, 5, 6, 7, 8}));
        send(first, data_frame(0x300));
        send(second, data_frame(0x200));
        send(first, data_frame(0x100));
        const TimePoint all_sent = monotonic_now();
        ASSERT_TRUE(
            until([&] { return first.received.size() >= 1 && second.received.size() >= 3; }));
        if (all_sent > second.received[0].time) continue;  // this thread was too slow
        EXPECT_EQ(second.received_ids(), (Ids{0x400, 0x100, 0x300}));
        EXPECT_GT(first.received[0].time, second.received[1].time);
        EXPECT_LT(first.received[0].time, second.received[2].time);
        return;
    }
    GTEST_SKIP() << "this machine was too slow to send while a frame was on the bus";
}

TEST_P(Conformance, AcceptsNothingWithoutFilters) {
    open();
    Station& sender = station();
    Station& deaf = station();
    Station& receiver = station();
    EXPECT_TRUE(deaf->set_filters({}));
    send(sender, data_frame(0x100));
    expect_sentinel(sender, receiver);
    ASSERT_TRUE(until([&] { return sender.results.size() == 2; }));
    EXPECT_THAT(deaf.received, IsEmpty());
}

TEST_P(Conformance, AcceptsWhatAFilterAccepts) {
    open();
    Station& sender = station();
    Station& receiver = station();
    const std::array<Filter, 2> filters{Filter{0x7E0, 0x460, false},
                                        Filter{0x7FF, sentinel, false}};
    ASSERT_TRUE(receiver->set_filters(filters));
    for (const std::uint32_t id : {0x45FU, 0x460U, 0x47FU, 0x480U}) {
        send(sender, data_frame(id));
        ASSERT_TRUE(until([&] { return !sender.results.empty(); }));
        sender.results.clear();
    }
    send(sender, extended_frame(0x460));
    expect_sentinel(sender, receiver);
    EXPECT_EQ(receiver.received_ids(), (Ids{0x460, 0x47F, sentinel}));
}

TEST_P(Conformance, ReplacesAllFilters) {
    open();
    Station& sender = station();
    Station& receiver = station();
    const std::array<Filter, 1> filters{Filter{0x1FFFFFFF, 0x12345, true}};
    ASSERT_TRUE(receiver->set_filters(filters));
    send(sender, data_frame(0x100));
    send(sender, extended_frame(0x12345));
    EXPECT_TRUE(until([&] { return !receiver.received.empty() && sender.results.size() == 2; }));
    ASSERT_THAT(receiver.received, SizeIs(1));
    EXPECT_TRUE(receiver.received[0].frame.extended);
}

TEST_P(Conformance, KeepsTheFiltersWhenGivenTooMany) {
    open();
    Station& sender = station();
    Station& receiver = station();
    const std::size_t room = std::max<std::size_t>(receiver->capabilities().filter_list, 2);
    EXPECT_FALSE(receiver->set_filters(std::vector<Filter>(room + 1, Filter{0x7FF, 0x001})));
    EXPECT_TRUE(receiver->set_filters(std::vector<Filter>(room, Filter{0x7FF, sentinel})));
    expect_sentinel(sender, receiver);
}

TEST_P(Conformance, IsFullWhenAllMailboxesAreTaken) {
    open();
    Station& sender = station();  // alone: nothing goes out
    const std::size_t mailboxes = sender->capabilities().mailboxes;
    for (std::size_t i = 0; i < mailboxes; ++i) send(sender, data_frame(0x100));
    if (!sender.results.empty()) GTEST_SKIP() << "on this link each frame is sent at once";
    EXPECT_EQ(sender->send(data_frame(0x001)), SendResult{SendError::full});
    Station& receiver = station();
    ASSERT_TRUE(until([&] { return sender.results.size() == mailboxes; }));
    expect_sentinel(sender, receiver);
}

TEST_P(WaitingFrames, AbortsWhatWaits) {
    Station& sender = station();
    Station& holder = holding_station();
    const TransmitHandle zeroth = send(sender, data_frame(foremost));
    const TransmitHandle first = send(sender, data_frame(0x100));
    const TransmitHandle second = send(sender, data_frame(0x100, {1}));
    const TransmitHandle third = send(sender, data_frame(0x200));
    sender->abort(first);
    sender->abort(third);
    ASSERT_TRUE(until([&] { return sender.results_with(TransmitOutcome::aborted).size() == 2; }));
    EXPECT_THAT(sender.results_with(TransmitOutcome::aborted),
                testing::UnorderedElementsAre(first, third));
    release(holder);
    ASSERT_TRUE(until([&] { return sender.results.size() == 4 && holder.received.size() == 2; }));
    EXPECT_THAT(sender.results_with(TransmitOutcome::sent), ElementsAre(zeroth, second));
    expect_sentinel(sender, holder);
    EXPECT_EQ(holder.received_ids(), (Ids{foremost, 0x100, sentinel}));
}

TEST_P(Conformance, IgnoresAbortsOfWhatIsOver) {
    open();
    Station& sender = station();
    Station& receiver = station();
    const TransmitHandle handle = send(sender, data_frame(0x100));
    ASSERT_TRUE(until([&] { return !sender.results.empty(); }));
    sender->abort(handle);
    sender->abort(TransmitHandle{0xFFFF'FFFF'FFFF});
    expect_sentinel(sender, receiver);
    ASSERT_TRUE(until([&] { return sender.results.size() >= 2; }));
    EXPECT_THAT(sender.results_with(TransmitOutcome::sent), SizeIs(2));
}

TEST_P(Conformance, RefusesFramesBeyondItsCapabilities) {
    open();
    Station& sender = station();
    const SendResult unsupported{SendError::unsupported};
    EXPECT_EQ(sender->send(data_frame(0x800)), unsupported);
    EXPECT_EQ(sender->send(extended_frame(0x20000000)), unsupported);
    EXPECT_EQ(sender->send(data_frame(0x100, std::vector<std::uint8_t>(12))), unsupported);
    EXPECT_EQ(sender->send(remote_frame(0x100, 9)), unsupported);
    Frame error;
    error.error = true;
    EXPECT_EQ(sender->send(error), unsupported);
}

TEST_P(Conformance, ALoneNodeGoesErrorPassiveAndSendsWhenSomebodyComes) {
    if (!GetParam().acknowledges) GTEST_SKIP() << "nothing is acknowledged on this link";
    open();
    Station& lone = station();
    send(lone, data_frame(0x100, {42}));
    ASSERT_TRUE(until([&] { return !lone.states.empty(); }));
    EXPECT_EQ(lone.states[0].status.state, ControllerState::error_passive);
    if (GetParam().tells_error_counters) {
        EXPECT_EQ(lone.states[0].status.tec, 128);
    }
    EXPECT_EQ(lone->error_status().state, ControllerState::error_passive);
    if (GetParam().sent_is_acknowledged) {
        EXPECT_THAT(lone.results, IsEmpty());
    }
    Station& other = station();
    ASSERT_TRUE(until([&] { return lone.results.size() == 1; }));
    EXPECT_EQ(lone.results[0].outcome, TransmitOutcome::sent);
    // The acknowledged frame brings the counter back below the limit.
    ASSERT_TRUE(until([&] { return lone.states.size() == 2; }));
    EXPECT_EQ(lone.states[1].status.state, ControllerState::error_active);
    expect_sentinel(lone, other);
}

TEST_P(Conformance, OneShotFailsWithoutAcknowledgement) {
    open();
    Station& lone = station();
    if (!lone->capabilities().one_shot) GTEST_SKIP() << "the link has no one-shot";
    const TransmitHandle handle = send(lone, data_frame(0x100), {.one_shot = true});
    ASSERT_TRUE(until([&] { return !lone.results.empty(); }));
    EXPECT_THAT(lone.results_with(TransmitOutcome::failed), ElementsAre(handle));
}

TEST_P(Conformance, OneShotGoesOutUndisturbed) {
    open();
    Station& sender = station();
    Station& receiver = station();
    if (!sender->capabilities().one_shot) GTEST_SKIP() << "the link has no one-shot";
    send(sender, data_frame(0x100), {.one_shot = true});
    EXPECT_TRUE(until([&] { return !receiver.received.empty(); }));
}

TEST_P(WaitingFrames, ListenOnlyReceivesButNeitherSendsNorAcknowledges) {
    Station& sender = station();
    Station& listener = holding_station();
    EXPECT_EQ(listener->send(data_frame(0x100)), SendResult{SendError::unsupported});
    send(sender, data_frame(0x100));
    ASSERT_TRUE(until([&] { return !sender.states.empty(); }));
    if (GetParam().sent_is_acknowledged) {
        EXPECT_THAT(sender.results, IsEmpty());
    }
    // Once the sender is error passive the listener may have it, although it was not sent.
    Station& third = station();
    ASSERT_TRUE(until([&] { return !sender.results.empty() && !listener.received.empty(); }));
    expect_sentinel(sender, third);
}

TEST_P(WaitingFrames, ANodeThatLeavesTakesItsWaitingFramesWithIt) {
    Station& leaver = station();
    Station& holder = holding_station();
    send(leaver, data_frame(0x100));
    leaver.leave();
    bus_->settle();
    release(holder);
    Station& sender = station();
    expect_sentinel(sender, holder);
    EXPECT_THAT(sender.received, IsEmpty());
}

TEST_P(Conformance, RecoverDoesNothingOutsideBusOff) {
    open();
    Station& sender = station();
    Station& receiver = station();
    sender->recover();
    expect_sentinel(sender, receiver);
    EXPECT_THAT(sender.states, IsEmpty());
}

TEST_P(Conformance, CountsTheFramesThatItLoses) {
    open();
    Station& sender = station();
    Station& slow = station();
    constexpr std::size_t total = 4000;
    std::size_t sent = 0;
    std::array<Controller*, 1> only_sender{&*sender};
    while (sender.results.size() < total) {
        while (sent < total) {
            const SendResult result = sender->send(data_frame(0x100));
            if (std::holds_alternative<SendError>(result)) break;
            ++sent;
            if (const auto* known = std::get_if<TransmitResult>(&result)) {
                sender.results.push_back(*known);
            }
        }
        const std::size_t before = sender.results.size();
        sender.drain();
        if (sender.results.size() == before && before < total) {
            ASSERT_TRUE(bus_->wait(only_sender));
        }
    }
    ASSERT_TRUE(until([&] {
        return GetParam().counts_losses ? slow.received.size() + slow.lost >= total : slow.lost > 0;
    }));
    EXPECT_GT(slow.lost, 0U);
    EXPECT_GT(slow.received.size(), 100U);
    slow.received.clear();
    expect_sentinel(sender, slow);
    if (GetParam().counts_losses) {
        EXPECT_EQ(slow.received_ids(), Ids{sentinel});
    }
}

TEST_P(Conformance, EventFdIsReadableWhileThereAreEvents) {
    open();
    Station& sender = station();
    Station& receiver = station();
    if (!GetParam().has_event_fd) {
        EXPECT_EQ(sender->event_fd(), -1);
        GTEST_SKIP() << "a virtual bus has nothing to wait for";
    }
    const auto readable = [](Station& each, int patience_ms) {
        pollfd descriptor{each->event_fd(), POLLIN, 0};
        return ::poll(&descriptor, 1, patience_ms) == 1;
    };
    const bool tells_of_nothing = !GetParam().wakes_for_events_only;
    EXPECT_TRUE(tells_of_nothing || !readable(receiver, 0));
    send(sender, data_frame(0x100));
    EXPECT_TRUE(readable(receiver, 20'000));
    EXPECT_TRUE(readable(receiver, 0)) << "waiting does not consume it";
    ASSERT_TRUE(until([&] { return !receiver.received.empty() && !sender.results.empty(); }));
    EXPECT_EQ(receiver->poll(), std::nullopt);
    EXPECT_TRUE(tells_of_nothing || !readable(receiver, 0));
}

TEST_P(Conformance, ThreadsMaySendAtOnce) {
    if (!GetParam().has_event_fd) GTEST_SKIP() << "a virtual bus belongs to one thread";
    open();
    Station& sender = station();
    Station& receiver = station();
    constexpr std::size_t per_thread = 100;
    const auto send_all = [&](std::uint32_t id) {
        for (std::size_t sent = 0; sent < per_thread;) {
            const SendResult result = sender->send(data_frame(id));
            if (!std::holds_alternative<SendError>(result)) {
                ++sent;
            } else {
                std::this_thread::yield();  // the main thread frees mailboxes
            }
        }
    };
    std::thread first{send_all, 0x100};
    std::thread second{send_all, 0x200};
    EXPECT_TRUE(until([&] { return receiver.received.size() == 2 * per_thread; }));
    first.join();
    second.join();
}

std::string link_name(const testing::TestParamInfo<LinkKind>& parameter) {
    return parameter.param.name;
}

INSTANTIATE_TEST_SUITE_P(Links, Conformance, testing::ValuesIn(all_links()), link_name);
INSTANTIATE_TEST_SUITE_P(Links, WaitingFrames, testing::ValuesIn(all_links()), link_name);

}  // namespace
}  // namespace canorb::can::test
