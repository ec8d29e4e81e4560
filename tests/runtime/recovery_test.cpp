// What goes wrong in the middle of a call, on a simulated bus with faults: the exception, the
// counter, and that calls work again afterwards without a restart. On a real interface this is
// tests/socketcan/errors_test.cpp and interface_test.cpp; that processes die, tests/stress.

#include "orb/can/sim/fault_injector.hpp"
#include "orb/runtime/simulation_impl.hpp"
#include "tests/runtime/forwarding_controller.hpp"
#include "tests/runtime/world.hpp"

namespace canorb::test {
namespace {

constexpr SystemError timeout_maybe{SystemErrorKind::timeout, Completion::maybe, 2};
constexpr SystemError still_off{SystemErrorKind::comm_failure, Completion::no, 4};
constexpr SystemError off_during_call{SystemErrorKind::comm_failure, Completion::maybe, 6};
constexpr SystemError given_up{SystemErrorKind::comm_failure, Completion::maybe, 7};

/// Node 1 serves object 1, node 2 calls it; fault scripts know them as node-1 and node-2.
class Recovery : public World {
  protected:
    Recovery() { serve(); }
    ~Recovery() override { frames.set_disturbance(nullptr); }

    void serve() {
        server.emplace(bus, node(1));
        server->root_poa().activate_object_with_id(1, servant);
    }

    /// From the next frame on.
    void disturb(std::string_view script) {
        auto parsed = can::sim::parse_fault_script(script);
        ASSERT_TRUE(parsed.ok());
        injector.emplace(std::move(*parsed), frames.bitrate(), TimePoint{});
        frames.set_disturbance(&*injector);
    }

    ObjectRef target() { return at(client, 1, 1).with_timeout(1s); }

    can::sim::Bus& frames = simulation.impl().frames(0);
    std::optional<can::sim::FaultInjector> injector;
    TestServant servant{{{0, nothing}, {1, echo}}};
    std::optional<Orb> server;
    Orb client{bus, node(2)};
};

// Each attempt to send adds 8 to the TEC, and bus-off is above 255.
constexpr std::string_view to_bus_off = "frame from node-2 attempt 1..32 at crc.3 flip wire";

TEST_F(Recovery, BusOffFailsTheCallAndAfterRecoverTheNextOneWorks) {
    disturb(to_bus_off);
    EXPECT_EQ(error_of([&] { target().invoke(0, {}); }), off_during_call);
    EXPECT_EQ(client.error_status().state, can::ControllerState::bus_off);
    EXPECT_EQ(client.counters()[Counter::messages_failed], 1U);
    // At once, until somebody asks for recovery.
    const TimePoint now = simulation.now();
    EXPECT_EQ(error_of([&] { target().invoke(0, {}); }), still_off);
    EXPECT_EQ(simulation.now(), now);
    simulation.run_for(1s);
    EXPECT_EQ(client.error_status().state, can::ControllerState::bus_off);

    client.recover();
    simulation.run_for(10ms);
    EXPECT_EQ(client.error_status().state, can::ControllerState::error_active);
    EXPECT_THAT(log,
                testing::Contains(testing::HasSubstr("node-2: the CAN controller is bus off")));
    EXPECT_THAT(log.back(), testing::HasSubstr("node-2: the CAN controller is error active"));
    target().invoke(0, {});
    EXPECT_EQ(servant.calls, 1);
}

TEST_F(Recovery, BusOffInAMessageIsMaybe) {
    // The second frame of four, the first is confirmed.
    disturb("frame from node-2 attempt 2..33 at crc.3 flip wire");
    const std::vector<std::uint8_t> octets(20, 1);
    EXPECT_EQ(error_of([&] { target().invoke(1, octets); }), off_during_call);
    client.recover();
    simulation.run_for(10ms);
    EXPECT_EQ(target().invoke(1, octets), octets);
    EXPECT_EQ(servant.calls, 1);
    EXPECT_EQ(server->counters()[Counter::interrupted_messages], 1U);
}

TEST_F(Recovery, BusOffOfAFrameThatWasNotConfirmedIsMaybe) {
    // All receivers take it, and its sender alone sees an error in its last bit; it repeats it
    // until it is off.
    disturb(
        "frame from node-2 attempt 1 at eof.7 dominant node-2\n"
        "frame from node-2 attempt 2..32 at crc.3 flip wire");
    TestServant slow{{{0, [&](ServerCall& call) {
                           server->run_for(20ms);  // else the answer would come before
                           nothing(call);
                       }}}};
    server->root_poa().activate_object_with_id(2, slow);
    EXPECT_EQ(error_of([&] { at(client, 1, 2).invoke(0, {}); }), off_during_call);
    EXPECT_EQ(slow.calls, 1);
}

TEST_F(Recovery, WhatAnErrorPassiveReceiverLosesMakesNoWrongMessage) {
    static constexpr OperationInfo open{&lamp_interface, 1, "open", true, true};
    static constexpr OperationInfo close{&lamp_interface, 2, "close", true, true};
    std::vector<std::string> executed;
    const auto note = [&](std::string_view operation) {
        return [&executed, operation](ServerCall& call) {
            executed.push_back(std::string{operation} + " " +
                               std::to_string(call.remaining_parameters().front()));
        };
    };
    TestServant valve{{{1, note("open")}, {2, note("close")}}};
    server->root_poa().activate_object_with_id(2, valve);
    OrbOptions with_gap = node(4);
    with_gap.continuation_gap = 500us;
    Orb sender{bus, with_gap};
    const ObjectRef remote = at(sender, 1, 2);

    disturb("frame from node-1 attempt 1..20 at crc.3 flip wire");
    target().invoke(0, {});
    ASSERT_EQ(server->error_status().state, can::ControllerState::error_passive);

    // Two messages of two frames. Node 1 alone cannot read the end of the first; its error flag is
    // recessive, so nobody repeats it, and lasts into the beginning of the second, which is lost,
    // too.
    disturb("frame from node-4 attempt 2 at crc.3 flip node-1");
    call_through(remote, open, std::vector<std::uint8_t>{1, 0, 0});
    call_through(remote, close, std::vector<std::uint8_t>{2, 0, 0});
    simulation.run_for(10ms);
    EXPECT_THAT(executed, testing::IsEmpty());
    EXPECT_EQ(server->counters()[Counter::partials_lost_with_frames], 1U);
    EXPECT_EQ(server->counters()[Counter::continuations_without_message], 1U);

    call_through(remote, close, std::vector<std::uint8_t>{3, 0, 0});
    simulation.run_for(10ms);
    EXPECT_THAT(executed, testing::ElementsAre("close 3"));
}

TEST_F(Recovery, WhatWasQueuedAtBusOffIsNotSentAfterIt) {
    disturb(to_bus_off);
    for (int i = 0; i < 5; ++i) call_through(target(), ring_oneway);
    call_through(group(client, 5), ring);
    simulation.run_for(100ms);
    EXPECT_EQ(client.counters()[Counter::messages_failed], 6U);
    client.recover();
    simulation.run_for(1s);
    EXPECT_EQ(client.error_status().state, can::ControllerState::error_active);
    EXPECT_TRUE(seen.empty());
    EXPECT_EQ(servant.calls, 0);
    call_through(target(), ring_oneway);
    simulation.run_for(1ms);
    EXPECT_EQ(servant.calls, 1);
}

TEST_F(Recovery, AServersBusOffIsATimeoutOfItsCallers) {
    disturb("frame from node-1 attempt 1..32 at crc.3 flip wire");
    EXPECT_EQ(error_of([&] { target().invoke(0, {}); }), timeout_maybe);
    EXPECT_EQ(servant.calls, 1);
    EXPECT_EQ(server->counters()[Counter::messages_failed], 1U);
    // While it is away nobody acknowledges, and the frame is repeated until it is back.
    EXPECT_EQ(error_of([&] { target().with_timeout(10ms).invoke(0, {}); }), timeout_maybe);
    server->recover();
    simulation.run_for(100ms);
    EXPECT_EQ(servant.calls, 2);
    EXPECT_EQ(client.counters()[Counter::unmatched_replies], 1U);
    target().invoke(0, {});
    EXPECT_EQ(client.counters()[Counter::calls_timed_out], 2U);
}

TEST_F(Recovery, AMessageWhoseNextFrameDoesNotGetOutIsStopped) {
    disturb("frame from node-2 attempt 3 at sof cut-off node-2 for 200ms");
    const std::vector<std::uint8_t> octets(60, 1);
    const TimePoint begin = simulation.now();
    EXPECT_EQ(error_of([&] { target().invoke(1, octets); }), given_up);
    // Half the inter-frame timeout after its second frame, long before the deadline.
    EXPECT_LT(simulation.now() - begin, 60ms);
    EXPECT_EQ(client.counters()[Counter::messages_stopped], 1U);
    simulation.run_for(1s);
    EXPECT_EQ(target().invoke(1, octets), octets);
    EXPECT_EQ(servant.calls, 1);
    const Counters counters = server->counters();
    EXPECT_EQ(counters[Counter::reassembly_timeouts] + counters[Counter::interrupted_messages] +
                  counters[Counter::sequence_errors],
              1U);
}

TEST_F(Recovery, ANodeAloneOnTheBusIsHeardWhenSomebodyComes) {
    server.reset();
    EXPECT_EQ(error_of([&] { target().with_timeout(20ms).invoke(0, {}); }), timeout_maybe);
    EXPECT_EQ(error_of([&] { target().with_timeout(20ms).invoke(0, {}); }).kind,
              SystemErrorKind::timeout);
    EXPECT_EQ(client.counters()[Counter::calls_timed_out], 2U);
    serve();
    simulation.run_for(100ms);
    // What was in the controller was sent to its end: MAYBE. Its sender has forgotten it.
    const int late = servant.calls;
    EXPECT_GE(late, 1);
    EXPECT_EQ(client.counters()[Counter::unmatched_replies], static_cast<std::uint64_t>(late));
    target().invoke(0, {});
    EXPECT_EQ(servant.calls, late + 1);
}

/// Has room for one frame at a time, although it says that there is more: as a CAN interface whose
/// queue is full with other programs' frames (ENOBUFS).
class CrowdedController final : public ForwardingController {
  public:
    CrowdedController(std::unique_ptr<can::Controller> real, int& refused)
        : ForwardingController(std::move(real)), refused_(refused) {}

    can::SendResult send(const can::Frame& frame, can::SendOptions options) override {
        if (occupied_) {
            ++refused_;
            return can::SendError::full;
        }
        occupied_ = true;
        return ForwardingController::send(frame, options);
    }
    std::optional<can::ControllerEvent> poll() override {
        auto event = ForwardingController::poll();
        if (event && std::holds_alternative<can::TransmitResult>(*event)) occupied_ = false;
        return event;
    }

  private:
    int& refused_;
    bool occupied_ = false;
};

class CrowdedBus final : public Bus {
  public:
    explicit CrowdedBus(Bus& real) : real_(real) {}
    std::unique_ptr<can::Controller> attach(std::string_view name) override {
        return std::make_unique<CrowdedController>(real_.attach(name), refused);
    }
    TimePoint now() const override { return real_.now(); }
    Simulation* simulation() override { return real_.simulation(); }

    int refused = 0;

  private:
    Bus& real_;
};

TEST_F(Recovery, AControllerWithoutRoomIsNotTheCallersError) {
    CrowdedBus crowded{bus};
    Orb caller{crowded, node(3)};
    const std::vector<std::uint8_t> octets(60, 1);
    for (int i = 0; i < 20; ++i) call_through(at(caller, 1, 1), ring_oneway);
    EXPECT_EQ(at(caller, 1, 1).invoke(1, octets), octets);
    EXPECT_EQ(servant.calls, 21);
    EXPECT_GT(crowded.refused, 20);
    // One frame each, and ten; none was sent twice.
    EXPECT_EQ(caller.counters()[Counter::frames_sent], 20U + 10);
    EXPECT_EQ(caller.counters()[Counter::messages_sent], 21U);
}

TEST_F(Recovery, APeerThatRestartsInTheMiddleOfACallIsATimeout) {
    // Its request waits in the server when that goes.
    server->root_poa().the_POAManager().hold_requests(false);
    simulation.at(simulation.now() + 5ms, [&] {
        server.reset();
        serve();
    });
    EXPECT_EQ(error_of([&] { target().invoke(0, {}); }), timeout_maybe);
    EXPECT_EQ(client.counters()[Counter::calls_timed_out], 1U);
    EXPECT_EQ(servant.calls, 0);
    target().invoke(0, {});
    EXPECT_EQ(servant.calls, 1);
}

TEST_F(Recovery, APeerThatRestartsInTheMiddleOfItsAnswerIsATimeout) {
    const std::vector<std::uint8_t> octets(200, 1);
    // 26 frames there, and the 5th frame of the answer is on its way.
    int answer_frames = 0;
    bool restart = false;
    bus.on_frame([&](const can::Frame& frame, TimePoint) {
        if (frame.id == 0x441 && ++answer_frames == 5) restart = true;
    });
    simulation.every(100us, simulation.now(), [&] {
        if (!std::exchange(restart, false)) return;
        server.reset();
        serve();
    });
    EXPECT_EQ(error_of([&] { target().invoke(1, octets); }), timeout_maybe);
    EXPECT_EQ(servant.calls, 1);
    EXPECT_EQ(target().invoke(1, octets), octets);
    EXPECT_EQ(client.counters()[Counter::interrupted_messages] +
                  client.counters()[Counter::reassembly_timeouts],
              1U);
}

TEST_F(Recovery, AnAnswerToACallerThatHasRestartedIsDropped) {
    std::optional<Orb> caller{std::in_place, bus, node(3)};
    server->root_poa().the_POAManager().hold_requests(false);
    EXPECT_EQ(error_of([&] { at(*caller, 1, 1).with_timeout(5ms).invoke(0, {}); }), timeout_maybe);
    caller.reset();
    caller.emplace(bus, node(3));
    simulation.run_for(1ms);
    server->root_poa().the_POAManager().activate();
    at(*caller, 1, 1).invoke(0, {});
    EXPECT_EQ(caller->counters()[Counter::unmatched_replies], 1U);
    EXPECT_EQ(servant.calls, 2);
}

}  // namespace
}  // namespace canorb::test
