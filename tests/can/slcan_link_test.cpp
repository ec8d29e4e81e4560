// The host's side of the LAWICEL protocol: the test is the adapter, with octets written by hand.

#include "orb/can/link/slcan_link.hpp"

#include <gmock/gmock.h>
#include <grp.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <future>

#include "orb/can/link/descriptor.hpp"
#include "tests/can/pseudo_terminal.hpp"
#include "tests/can/temporary_directory.hpp"

namespace canorb::can::test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

Frame standard(std::uint32_t id, std::vector<std::uint8_t> payload = {}) {
    return Frame::standard(id, payload);
}

using Attached = Result<std::unique_ptr<Controller>, std::string>;

Attached attach_to(const std::string& address) {
    auto link = open_link(address);
    if (!link) return Failure{link.error()};
    return (*link)->attach("test");
}

class SlcanLinkTest : public testing::Test {
  protected:
    std::string address(const std::string& options = "") const {
        return "slcan:" + line_->device() + options;
    }

    /// The adapter reads exactly this.
    void expect(std::string_view octets) { EXPECT_EQ(line_->read(octets.size()), octets); }
    void answer(std::string_view octets) { line_->write(octets); }

    static constexpr std::string_view has_flags = "F00\r";
    static constexpr std::string_view no_flags = "\a";

    /// The whole opening of an adapter in a good mood. One without flags is not asked for them
    /// later, however long a test takes.
    void greet(std::string_view flags = no_flags, std::string_view open = "O\r") {
        expect("\r\r\rC\rV\r");
        answer("\a\a\a\rV1013\r");
        expect("S6\r");
        answer("\r");
        expect("X1\r");
        answer("\r");
        expect(open);
        answer("\r");
        expect("F\r");
        answer(flags);
    }

    void attach(std::string_view flags = no_flags) {
        auto attached = std::async(std::launch::async, attach_to, address());
        greet(flags);
        take(attached.get());
    }
    void take(Attached attached) {
        ASSERT_TRUE(attached) << attached.error();
        controller_ = std::move(*attached);
        const std::array<Filter, 2> all{Filter{0, 0, false}, Filter{0, 0, true}};
        ASSERT_TRUE(controller_->set_filters(all));
    }

    /// The error with which attach() ends while the adapter plays `part`.
    template <typename Part>
    std::string error_while(Part part, const std::string& options = "") {
        auto attached = std::async(std::launch::async, attach_to, address(options));
        part();
        const auto result = attached.get();
        return result ? "attached" : result.error();
    }

    TransmitHandle send(const Frame& frame) {
        const SendResult result = controller_->send(frame);
        const auto* handle = std::get_if<TransmitHandle>(&result);
        EXPECT_NE(handle, nullptr);
        return handle != nullptr ? *handle : TransmitHandle{};
    }

    std::optional<ControllerEvent> next_event(int patience_ms = 20'000) {
        const TimePoint end = monotonic_now() + std::chrono::milliseconds{patience_ms};
        while (true) {
            if (auto event = controller_->poll()) return event;
            const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - monotonic_now());
            pollfd readable{controller_->event_fd(), POLLIN, 0};
            if (left <= 0ms || ::poll(&readable, 1, static_cast<int>(left.count())) != 1) {
                return std::nullopt;
            }
        }
    }
    /// There may be an event.
    bool is_readable() const {
        pollfd readable{controller_->event_fd(), POLLIN, 0};
        return ::poll(&readable, 1, 0) == 1;
    }
    template <typename Event>
    Event next() {
        const auto event = next_event();
        EXPECT_TRUE(event && std::holds_alternative<Event>(*event));
        return event && std::holds_alternative<Event>(*event) ? std::get<Event>(*event) : Event{};
    }
    void expect_result(TransmitHandle handle, TransmitOutcome outcome) {
        const auto result = next<TransmitResult>();
        EXPECT_EQ(result.handle, handle);
        EXPECT_EQ(result.outcome, outcome);
    }
    void expect_state(ControllerState state) {
        EXPECT_EQ(next<StateChanged>().status.state, state);
        EXPECT_EQ(controller_->error_status().state, state);
    }
    void expect_received(const Frame& frame) { EXPECT_EQ(next<Received>().frame, frame); }

    /// Until the adapter reads these octets: what is asked for by a timer takes a poll().
    void poll_until(std::string_view octets) {
        std::string got;
        while (got.size() < octets.size()) {
            EXPECT_EQ(controller_->poll(), std::nullopt);
            got += line_->read(octets.size() - got.size(), 1);
        }
        EXPECT_EQ(got, octets);
    }

    std::unique_ptr<PseudoTerminal> line_ = std::make_unique<PseudoTerminal>();
    std::unique_ptr<Controller> controller_;
};

TEST_F(SlcanLinkTest, OpensAnAdapter) {
    attach();
    const Capabilities capabilities = controller_->capabilities();
    EXPECT_EQ(capabilities.bitrate, 500'000U);
    EXPECT_EQ(capabilities.mailboxes, 8U);
    EXPECT_EQ(capabilities.filter_list, 64U);
    EXPECT_TRUE(capabilities.listen_only);
    EXPECT_FALSE(capabilities.one_shot);
    EXPECT_FALSE(capabilities.fifo);
    EXPECT_EQ(controller_->error_status(), ErrorStatus{});
    EXPECT_EQ(controller_->explanation(), "");
    EXPECT_EQ(controller_->poll(), std::nullopt);
    EXPECT_EQ(controller_->send(standard(0x100), {.one_shot = true}),
              SendResult{SendError::unsupported});
    controller_.reset();
    expect("C\r");
}

TEST_F(SlcanLinkTest, TakesAnAdapterThatKnowsNeitherAutoPollNorFlags) {
    auto attached =
        std::async(std::launch::async, attach_to, address("?bitrate=1000000&baud=3000000"));
    expect("\r\r\rC\rV\r");
    // What an earlier session left behind.
    answer("t1230\r\a\r\r\aF00\rxyz\rN1234\rV1013\r");
    expect("S8\r");
    answer("\r");
    expect("X1\r");
    answer("\a");
    expect("O\r");
    answer("\r");
    expect("F\r");
    answer("\a");
    take(attached.get());
    EXPECT_EQ(controller_->capabilities().bitrate, 1'000'000U);
    EXPECT_EQ(next_event(600), std::nullopt);
    const TransmitHandle handle = send(standard(0x001));
    expect("t0010\r");  // and not F
    answer("\a");
    poll_until("t0010\r");  // nor now, when other adapters could tell why they refuse
    answer("z\r");
    expect_result(handle, TransmitOutcome::sent);
    EXPECT_EQ(next_event(600), std::nullopt);
    EXPECT_EQ(controller_->error_status(), ErrorStatus{});
    controller_.reset();
    expect("C\r");
}

TEST_F(SlcanLinkTest, WaitsForAnAdapterThatStartsSlowly) {
    auto attached = std::async(std::launch::async, attach_to, address());
    expect("\r\r\rC\rV\r");
    expect("\r\r\rC\rV\r");
    answer("\a\a\a\a");
    answer("V1013\r");
    answer("\r\r\r\r\aV1013\r");  // late, and no answer to what is asked next
    expect("S6\r");
    answer("\r");
    expect("X1\r");
    answer("\r");
    expect("O\r");
    answer("\r");
    expect("F\r");
    answer("F00\r");
    take(attached.get());
}

TEST_F(SlcanLinkTest, TransmitsAndTakesEveryKindOfAnswer) {
    attach();
    for (const char* done : {"z\r", "Z\r", "\r"}) {
        const TransmitHandle handle = send(standard(0x123, {0xDE, 0xAD}));
        expect("t1232DEAD\r");
        EXPECT_EQ(controller_->poll(), std::nullopt);
        answer(done);
        expect_result(handle, TransmitOutcome::sent);
    }
    Frame frame;
    frame.id = 0x1ABCDEF0;
    frame.extended = true;
    frame.length = 1;
    frame.data[0] = 0x0F;
    send(frame);
    expect("T1ABCDEF010F\r");
    answer("Z\r");
    next<TransmitResult>();
    frame.remote = true;
    send(frame);
    expect("R1ABCDEF01\r");
}

TEST_F(SlcanLinkTest, AsksForOneThingAtATimeTheLowestIdentifierFirst) {
    attach();
    const TransmitHandle first = send(standard(0x300));
    const TransmitHandle third = send(standard(0x200, {1}));
    const TransmitHandle fourth = send(standard(0x200, {2}));
    const TransmitHandle second = send(standard(0x100));
    expect("t3000\r");
    EXPECT_EQ(line_->read(1, 20), "");
    answer("z\r");
    expect_result(first, TransmitOutcome::sent);
    expect("t1000\r");
    answer("z\r");
    expect_result(second, TransmitOutcome::sent);
    expect("t200101\r");
    answer("z\r");
    expect_result(third, TransmitOutcome::sent);
    expect("t200102\r");
    answer("z\r");
    expect_result(fourth, TransmitOutcome::sent);
}

TEST_F(SlcanLinkTest, TriesAgainWhatTheAdapterHasNoRoomFor) {
    attach();
    const TransmitHandle handle = send(standard(0x100));
    expect("t1000\r");
    answer("\a");
    poll_until("t1000\r");
    answer("\a");
    const TransmitHandle urgent = send(standard(0x050));
    poll_until("t0500\r");
    answer("z\r");
    expect_result(urgent, TransmitOutcome::sent);
    poll_until("t1000\r");
    answer("z\r");
    expect_result(handle, TransmitOutcome::sent);
}

TEST_F(SlcanLinkTest, AsksForTheFlagsWhenTheAdapterHasNoRoomForLong) {
    attach(has_flags);
    send(standard(0x100));
    std::string command;
    for (int refused = 0; command != "F\r"; ++refused) {
        ASSERT_LT(refused, 100);
        command.clear();
        while (!command.ends_with('\r')) {
            controller_->poll();
            command += line_->read(1, 1);
        }
        if (command == "t1000\r") answer("\a");
    }
    answer("F22\r");
    expect_state(ControllerState::error_passive);
}

TEST_F(SlcanLinkTest, AbortsWhatTheAdapterHasNot) {
    attach();
    const TransmitHandle taken = send(standard(0x100));
    const TransmitHandle waiting = send(standard(0x200));
    controller_->abort(taken);
    controller_->abort(waiting);
    controller_->abort(TransmitHandle{12345});
    expect_result(waiting, TransmitOutcome::aborted);
    expect("t1000\r");
    answer("z\r");
    expect_result(taken, TransmitOutcome::sent);
    const TransmitHandle refused = send(standard(0x100));
    controller_->abort(refused);
    expect("t1000\r");
    answer("\a");
    expect_result(refused, TransmitOutcome::aborted);
    EXPECT_EQ(line_->read(1, 20), "");
}

TEST_F(SlcanLinkTest, IsReadableWhileItHasResults) {
    attach();
    const TransmitHandle taken = send(standard(0x100));
    const TransmitHandle waiting[] = {send(standard(0x200)), send(standard(0x300))};
    expect("t1000\r");
    EXPECT_FALSE(is_readable());
    controller_->abort(waiting[0]);
    EXPECT_TRUE(is_readable());
    expect_result(waiting[0], TransmitOutcome::aborted);
    EXPECT_FALSE(is_readable());
    controller_->abort(taken);  // which the adapter has
    EXPECT_FALSE(is_readable());
    ASSERT_TRUE(controller_->set_listen_only(true));
    EXPECT_TRUE(is_readable());
    expect_result(waiting[1], TransmitOutcome::aborted);
    EXPECT_FALSE(is_readable());
}

TEST_F(SlcanLinkTest, IsReadableWithTheResultsOfAPeerWithoutAnswers) {
    take(attach_to(address("?answers=no")));
    expect("\r\r\rC\rS6\rO\r");
    EXPECT_FALSE(is_readable());
    const TransmitHandle first = send(standard(0x200));
    EXPECT_TRUE(is_readable());
    const TransmitHandle second = send(standard(0x100));
    expect_result(first, TransmitOutcome::sent);
    EXPECT_TRUE(is_readable());
    expect_result(second, TransmitOutcome::sent);
    EXPECT_FALSE(is_readable());
}

TEST_F(SlcanLinkTest, IsReadableWhenSendFindsTheTerminalGone) {
    take(attach_to(address("?answers=no")));
    expect("\r\r\rC\rS6\rO\r");
    line_->unplug();
    const TransmitHandle handle = send(standard(0x100));
    EXPECT_TRUE(is_readable());
    expect_state(ControllerState::stopped);
    EXPECT_TRUE(is_readable());
    expect_result(handle, TransmitOutcome::failed);
}

TEST_F(SlcanLinkTest, ReceivesHoweverTheOctetsArrive) {
    attach();
    const std::string octets = "t1232DEAD\rt12310F12AB\rR1ABCDEF08\r";
    Frame remote;
    remote.id = 0x1ABCDEF0;
    remote.extended = remote.remote = true;
    remote.length = 8;
    const std::vector<Frame> frames{standard(0x123, {0xDE, 0xAD}), standard(0x123, {0x0F}), remote};
    answer(octets);
    for (const Frame& frame : frames) expect_received(frame);
    std::vector<Frame> received;
    for (const char octet : octets) {
        answer({&octet, 1});
        if (const auto event = next_event(octet == '\r' ? 20'000 : 5)) {
            received.push_back(std::get<Received>(*event).frame);
        }
    }
    EXPECT_EQ(received, frames);
}

TEST_F(SlcanLinkTest, FramesBetweenACommandAndItsAnswerAreNoAnswer) {
    attach();
    const TransmitHandle handle = send(standard(0x100));
    expect("t1000\r");
    answer("t1230\rsa000000\re1a\rF00\rV1013\rC\rt1240\rz\r");
    expect_received(standard(0x123));
    expect_received(standard(0x124));
    expect_result(handle, TransmitOutcome::sent);
}

TEST_F(SlcanLinkTest, FiltersWhatItReceives) {
    attach();
    const std::array<Filter, 1> filters{Filter{0x7E0, 0x460, false, true}};
    ASSERT_TRUE(controller_->set_filters(filters));
    answer("t45F0\rt4600\rr4600\rt47F0\rt4800\rT000004600\r");
    expect_received(standard(0x460));
    expect_received(standard(0x47F));
    EXPECT_EQ(next_event(20), std::nullopt);
    EXPECT_FALSE(controller_->set_filters(std::vector<Filter>(65)));
    EXPECT_TRUE(controller_->set_filters(std::vector<Filter>(64)));
}

TEST_F(SlcanLinkTest, SaysThatFramesWereLostInGarbage) {
    attach();
    for (const std::string& garbage :
         {std::string{"t12\r"}, std::string{"\x80\xFF\r"}, std::string{"t1231\a"},
          std::string(5000, 'x') + "\r", std::string{"t123t1230\r"}}) {
        answer(garbage);
        EXPECT_EQ(next<FramesLost>().count, 1U) << garbage;
        answer("t1230\r");
        expect_received(standard(0x123));
    }
    answer("\r\a\rz\rsa000000\r");  // harmless
    EXPECT_EQ(next_event(20), std::nullopt);
}

TEST_F(SlcanLinkTest, GarbageWithoutEndKeepsNobodyBusy) {
    attach();
    std::atomic<bool> done = false;
    std::thread flood{[&] {
        while (!done) {
            pollfd writable{line_->peer(), POLLOUT, 0};
            if (::poll(&writable, 1, 10) == 1) answer(std::string(200, 'x'));
        }
    }};
    for (int i = 0; i < 1000; ++i) EXPECT_EQ(controller_->poll(), std::nullopt);
    done = true;
    flood.join();
}

TEST_F(SlcanLinkTest, TellsWhatTheFlagsTell) {
    attach(has_flags);
    poll_until("F\r");
    answer("F04\r");  // error warning is error active
    poll_until("F\r");
    answer("F20\r");
    expect_state(ControllerState::error_passive);
    send(standard(0x100));
    expect("t1000\r");
    answer("\r");
    next<TransmitResult>();
    poll_until("F\r");
    answer("F29\r");
    EXPECT_EQ(next<FramesLost>().count, 1U);
    poll_until("F\r");
    answer("FC2\r");  // bus error, arbitration lost, transmit FIFO full
    expect_state(ControllerState::error_active);
}

TEST_F(SlcanLinkTest, TellsTheStatesThatAPeerTells) {
    attach();
    answer("sw100010\r");
    answer("t1230\r");
    next<Received>();
    EXPECT_EQ(controller_->error_status(), (ErrorStatus{ControllerState::error_active, 10, 100}));
    answer("sp000128\r");
    expect_state(ControllerState::error_passive);
    EXPECT_EQ(controller_->error_status().tec, 128);
    const TransmitHandle taken = send(standard(0x100));
    const TransmitHandle waiting = send(standard(0x200));
    expect("t1000\r");
    answer("sb000256\r");
    expect_state(ControllerState::bus_off);
    expect_result(taken, TransmitOutcome::failed);
    expect_result(waiting, TransmitOutcome::failed);
    EXPECT_EQ(controller_->send(standard(0x100)), SendResult{SendError::bus_off});
    EXPECT_EQ(controller_->recover(), std::nullopt);
    answer("z\r");
    // The setup is answered by another thread, so that this one can poll.
    std::thread adapter{[&] { greet(); }};
    expect_state(ControllerState::error_active);
    adapter.join();
    send(standard(0x100));
    expect("t1000\r");
}

TEST_F(SlcanLinkTest, ListensOnly) {
    attach();
    const TransmitHandle waiting[] = {send(standard(0x100)), send(standard(0x200))};
    ASSERT_TRUE(controller_->set_listen_only(true));
    EXPECT_EQ(controller_->send(standard(0x100)), SendResult{SendError::unsupported});
    expect_result(waiting[1], TransmitOutcome::aborted);
    expect("t1000\r");
    answer("z\r");
    expect_result(waiting[0], TransmitOutcome::sent);
    expect("C\rL\r");
    answer("\r\r");
    answer("t1230\r");
    expect_received(standard(0x123));
    ASSERT_TRUE(controller_->set_listen_only(false));
    expect("C\rO\r");
    answer("\r\r");
    send(standard(0x100));
    EXPECT_EQ(controller_->poll(), std::nullopt);
    poll_until("t1000\r");
}

TEST_F(SlcanLinkTest, IsStoppedWhenTheAdapterCannotListenOnly) {
    attach();
    ASSERT_TRUE(controller_->set_listen_only(true));
    expect("C\rL\r");
    answer("\r\a");
    expect_state(ControllerState::stopped);
    EXPECT_THAT(controller_->explanation(), HasSubstr("refuses to open its channel for listening"));
}

TEST_F(SlcanLinkTest, IsStoppedWhenItsAdapterIsPulledOut) {
    attach();
    const TransmitHandle taken = send(standard(0x100));
    const TransmitHandle waiting = send(standard(0x200));
    expect("t1000\r");
    answer("t12");
    line_->unplug();
    expect_state(ControllerState::stopped);
    EXPECT_EQ(controller_->explanation(), line_->device() + " is gone; plug the adapter in again");
    expect_result(taken, TransmitOutcome::failed);
    expect_result(waiting, TransmitOutcome::failed);
    EXPECT_EQ(controller_->send(standard(0x100)), SendResult{SendError::stopped});
    EXPECT_EQ(controller_->poll(), std::nullopt);
}

TEST_F(SlcanLinkTest, ComesBackWithItsFiltersWhenTheAdapterDoes) {
    const TemporaryDirectory directory;
    const std::string name = directory.path() + "/adapter";
    std::filesystem::create_symlink(line_->device(), name);
    auto attached = std::async(std::launch::async, attach_to, "slcan:" + name);
    greet();
    take(attached.get());
    const std::array<Filter, 1> filters{Filter{0x7FF, 0x124, false}};
    ASSERT_TRUE(controller_->set_filters(filters));
    ASSERT_TRUE(controller_->set_listen_only(true));
    expect("C\rL\r");
    answer("\r\r");
    EXPECT_EQ(next_event(20), std::nullopt);
    line_->unplug();
    std::filesystem::remove(name);
    expect_state(ControllerState::stopped);
    EXPECT_EQ(next_event(600), std::nullopt);
    EXPECT_EQ(controller_->explanation(),
              "there is no " + name + ": is the adapter plugged in, is that its name?");

    line_ = std::make_unique<PseudoTerminal>();
    std::filesystem::create_symlink(line_->device(), name);
    controller_->recover();  // not needed, and does no harm
    std::thread adapter{[&] { greet(no_flags, "L\r"); }};
    expect_state(ControllerState::error_active);
    adapter.join();
    EXPECT_EQ(controller_->explanation(), "");
    answer("t1230\rt1240\r");
    expect_received(standard(0x124));
}

TEST_F(SlcanLinkTest, IsStoppedWhenTheAdapterAnswersNoMore) {
    attach();
    const TransmitHandle handle = send(standard(0x100));
    expect("t1000\r");
    answer("t1230\r");
    expect_received(standard(0x123));
    expect_state(ControllerState::stopped);
    EXPECT_EQ(controller_->explanation(),
              "the adapter at " + line_->device() + " does not answer any more; it is tried again");
    expect_result(handle, TransmitOutcome::failed);
    // It is asked again.
    std::thread adapter{[&] { greet(); }};
    expect_state(ControllerState::error_active);
    adapter.join();
}

TEST_F(SlcanLinkTest, IsSetUpAgainWhenItWasWithoutPower) {
    attach(has_flags);
    poll_until("F\r");
    answer("\a");
    expect_state(ControllerState::stopped);
    EXPECT_THAT(controller_->explanation(), HasSubstr("has closed its channel"));
    std::thread adapter{[&] { greet(); }};
    expect_state(ControllerState::error_active);
    adapter.join();
}

TEST_F(SlcanLinkTest, AnAnswerThatWasThereInTimeIsNotLate) {
    attach();
    const TransmitHandle handle = send(standard(0x100));
    expect("t1000\r");
    answer("z\r");
    std::this_thread::sleep_for(1100ms);  // nobody polls
    expect_result(handle, TransmitOutcome::sent);
}

TEST_F(SlcanLinkTest, GivesTheTerminalItsSettingsBack) {
    const termios before = line_->settings();
    auto attached = std::async(std::launch::async, attach_to, address("?baud=230400"));
    greet();
    take(attached.get());
    termios during = line_->settings();
    EXPECT_EQ(::cfgetospeed(&during), static_cast<speed_t>(B230400));
    EXPECT_EQ(during.c_lflag & (ICANON | ECHO | ISIG), 0U);
    EXPECT_EQ(during.c_iflag & (IXON | ICRNL), 0U);
    EXPECT_EQ(during.c_cflag & (CSIZE | CLOCAL | CREAD),
              static_cast<tcflag_t>(CS8 | CLOCAL | CREAD));
    controller_.reset();
    expect("C\r");
    termios after = line_->settings();
    EXPECT_EQ(::cfgetospeed(&after), ::cfgetospeed(&before));
    EXPECT_EQ(after.c_iflag, before.c_iflag);
    EXPECT_EQ(after.c_oflag, before.c_oflag);
    EXPECT_EQ(after.c_lflag, before.c_lflag);
    EXPECT_EQ(after.c_cflag, before.c_cflag);
    EXPECT_FALSE(line_->is_in_use());
}

TEST_F(SlcanLinkTest, APeerWithoutAnswers) {
    take(attach_to(address("?answers=no&bitrate=125000")));
    expect("\r\r\rC\rS4\rO\r");
    EXPECT_FALSE(controller_->capabilities().listen_only);
    EXPECT_FALSE(controller_->set_listen_only(true));
    EXPECT_EQ(controller_->poll(), std::nullopt);
    const TransmitHandle first = send(standard(0x200));
    const TransmitHandle second = send(standard(0x100));
    expect_result(first, TransmitOutcome::sent);
    expect_result(second, TransmitOutcome::sent);
    expect("t2000\rt1000\r");
    // Commands of the other host, and what would be answers.
    answer("C\rS6\rF\rO\r\a\r\rz\rF20\rV1013\rt1230\r");
    expect_received(standard(0x123));
    answer("sp128000\r");
    expect_state(ControllerState::error_passive);
    EXPECT_EQ(next_event(600), std::nullopt);
    controller_.reset();
    expect("C\r");  // and no F
}

TEST_F(SlcanLinkTest, WaitsWhereTheLineIsFull) {
    take(attach_to(address("?answers=no")));
    std::string expected = "\r\r\rC\rS6\rO\r";
    std::uint8_t number = 0;
    while (true) {
        const SendResult result = controller_->send(standard(0x123, {number}));
        if (std::holds_alternative<SendError>(result)) {
            EXPECT_EQ(result, SendResult{SendError::full});
            if (!next_event(20)) break;  // nobody takes any more
        } else {
            expected += std::string{"t1231"} + "0123456789ABCDEF"[number >> 4] +
                        "0123456789ABCDEF"[number & 0xF] + '\r';
            ++number;
        }
        ASSERT_LT(expected.size(), 1'000'000U);
    }
    std::string got;
    while (got.size() < expected.size()) {
        got += line_->read(std::min<std::size_t>(expected.size() - got.size(), 100), 1);
        controller_->poll();
    }
    EXPECT_EQ(got, expected);
    EXPECT_EQ(line_->read(1, 20), "");
}

TEST_F(SlcanLinkTest, SaysWhatIsWrongWithTheTerminal) {
    const TemporaryDirectory directory;
    const auto error = [](const std::string& device) {
        const auto link = open_link("slcan:" + device);
        return link ? "opened" : link.error();
    };
    const std::string missing = directory.path() + "/ttyACM7";
    EXPECT_EQ(error(missing),
              "there is no " + missing + ": is the adapter plugged in, is that its name?");
    const std::string file = directory.path() + "/file";
    std::ofstream{file} << "V1013\r";
    EXPECT_THAT(error(file), HasSubstr(file + " is not a terminal"));
    EXPECT_THAT(error("/dev/null"), HasSubstr("/dev/null is not a terminal"));
    EXPECT_THAT(error(directory.path()), HasSubstr("cannot open " + directory.path()));
}

TEST_F(SlcanLinkTest, SaysWhoMayUseTheTerminal) {
    const group* const dialout = ::getgrnam("dialout");
    if (::geteuid() != 0 || dialout == nullptr) {
        GTEST_SKIP() << "only the superuser can become somebody else";
    }
    const auto error_with = [&](mode_t mode) {
        EXPECT_EQ(::chown(line_->device().c_str(), 0, dialout->gr_gid), 0);
        EXPECT_EQ(::chmod(line_->device().c_str(), mode), 0);
        EXPECT_EQ(::seteuid(65534), 0);
        const auto link = open_link(address());
        EXPECT_EQ(::seteuid(0), 0);
        return link ? "opened" : link.error();
    };
    EXPECT_EQ(error_with(0660), "no permission to use " + line_->device() +
                                    ": add yourself to the group dialout (usermod -aG dialout "
                                    "USER) and log in again");
    EXPECT_EQ(error_with(0600),
              "no permission to use " + line_->device() + ": it is for the user root only");
}

TEST_F(SlcanLinkTest, HasOneControllerOnly) {
    const auto link = open_link(address());
    ASSERT_TRUE(link);
    attach();
    const std::string in_use = line_->device() + " is in use by another program";
    const auto second = (*link)->attach("second");
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error(), in_use);
    EXPECT_EQ(open_link(address()).error(), in_use);
    controller_.reset();
    expect("C\r");
    attach();
}

TEST_F(SlcanLinkTest, SaysWhatTheAdapterRefuses) {
    EXPECT_EQ(error_while(
                  [&] {
                      expect("\r\r\rC\rV\r");
                      answer("V1013\r");
                      expect("S7\r");
                      answer("\a");
                  },
                  "?bitrate=800000"),
              "the adapter at " + line_->device() + " has no bit rate of 800000 bit/s");
    EXPECT_EQ(error_while([&] {
                  expect("\r\r\rC\rV\r");
                  answer("V1013\r");
                  expect("S6\r");
                  answer("\r");
                  expect("X1\r");
                  answer("\a");
                  expect("O\r");
                  answer("\a");
              }),
              "the adapter at " + line_->device() + " refuses to open its channel");
    EXPECT_EQ(error_while([&] {
                  expect("\r\r\rC\rV\r");
                  line_->unplug();
              }),
              line_->device() + " is gone; plug the adapter in again");
}

TEST_F(SlcanLinkTest, SaysThatNothingAnswers) {
    EXPECT_EQ(error_while([&] {
                  for (int i = 0; i < 6; ++i) {
                      expect("\r\r\rC\rV\r");
                      answer("login: \r\a");  // not an adapter
                  }
              }),
              "nothing at " + line_->device() +
                  " answers like a LAWICEL adapter: is it another port, or another baud=? A peer "
                  "that does not answer as an adapter does takes answers=no");
}

}  // namespace
}  // namespace canorb::can::test
