// What a node tells its application, and what garbage on the bus does to it: nothing.

#include <algorithm>
#include <random>

#include "tests/runtime/world.hpp"

namespace canorb::test {
namespace {

class Events : public World {};

TEST_F(Events, DuplicateNodeIsToldAndHarmsOnlyItself) {
    Orb one{bus, node(1)};
    Orb two{bus, node(2)};
    Orb original{bus, node(3)};
    Orb duplicate{bus, node(3)};
    TestServant servants[2] = {TestServant{{{0, nothing}}}, TestServant{{{0, nothing}}}};
    original.object_join(original.root_poa().activate_object(servants[0]), GroupId{5});
    two.root_poa().activate_object_with_id(1, servants[1]);
    std::vector<Event> events;
    original.on_event([&](const Event& event) { events.push_back(event); });

    for (int i = 0; i < 100; ++i) {
        group(duplicate, 5).invoke(0, {});
        at(one, 2, 1).invoke(0, {});
        simulation.run_for(10ms);
    }
    EXPECT_EQ(servants[0].calls, 0);
    EXPECT_EQ(servants[1].calls, 100);
    EXPECT_EQ(original.counters()[Counter::frames_of_duplicate_node], 100U);
    ASSERT_EQ(events.size(), 2U);  // once a second
    EXPECT_EQ(events[0].kind, Event::Kind::duplicate_node);
    EXPECT_THAT(events[0].text,
                testing::HasSubstr("node-3: another node on this bus uses node id 3"));
    EXPECT_EQ(log, (std::vector<std::string>{events[0].text, events[1].text}));

    // A new number, and all is well.
    duplicate.set_node(4);
    group(duplicate, 5).invoke(0, {});
    simulation.run_for(10ms);
    EXPECT_EQ(servants[0].calls, 1);
}

TEST_F(Events, DuplicateNodeThatTalksToOthersOnlyIsToldToo) {
    Orb server{bus, node(2)};
    Orb original{bus, node(3)};
    Orb duplicate{bus, node(3)};
    TestServant servant{{{0, nothing}}};
    server.root_poa().activate_object_with_id(1, servant);
    std::vector<Event> events;
    original.on_event([&](const Event& event) { events.push_back(event); });

    group(duplicate, 9).invoke(0, {});  // nobody here is a member
    simulation.run_for(1ms);
    EXPECT_EQ(original.counters()[Counter::frames_of_duplicate_node], 1U);
    at(duplicate, 2, 1).invoke(0, {});
    EXPECT_EQ(servant.calls, 1);
    EXPECT_EQ(original.counters()[Counter::frames_of_duplicate_node], 2U);
    ASSERT_EQ(events.size(), 1U);
    EXPECT_EQ(events[0].kind, Event::Kind::duplicate_node);
}

TEST_F(Events, ControllerStateIsTold) {
    Orb alone{bus, node(1)};
    std::vector<Event> events;
    alone.on_event([&](const Event& event) { events.push_back(event); });
    group(alone, 5).invoke(0, {});
    simulation.run_for(1s);
    ASSERT_EQ(events.size(), 1U);
    EXPECT_EQ(events[0].kind, Event::Kind::controller_state);
    EXPECT_THAT(events[0].text, testing::HasSubstr("error passive (TEC 128, REC 0)"));
    EXPECT_EQ(alone.error_status().tec, 128);
}

TEST_F(Events, CallbackThatThrowsIsLoggedOnce) {
    Orb orb{bus, node(1)};
    int events = 0;
    orb.on_event([&](const Event&) {
        ++events;
        throw std::runtime_error{"a bug"};
    });
    orb.at(TimePoint{1ms}, [] { throw 1; });
    simulation.run_for(1s);
    EXPECT_EQ(events, 1);
    ASSERT_EQ(log.size(), 2U);
    EXPECT_THAT(log[1], testing::HasSubstr("node-1: the event callback raised a bug"));
}

TEST_F(Events, LogThatThrowsHarmsNobody) {
    OrbOptions options;
    options.node = 1;
    options.log = [](std::string_view) { throw std::runtime_error{"disk full"}; };
    Orb orb{bus, options};
    orb.at(TimePoint{1ms}, [] { throw 1; });
    simulation.run_for(1s);
}

TEST_F(Events, CountersTellOfTraffic) {
    Orb server{bus, node(1)};
    Orb client{bus, node(2)};
    TestServant servant{{{1, echo}}};
    server.root_poa().activate_object_with_id(1, servant);
    at(client, 1, 1).invoke(1, std::vector<std::uint8_t>(20));
    simulation.run_for(1ms);  // the confirmation of the Reply
    const Counters sent = client.counters();
    const Counters received = server.counters();
    EXPECT_EQ(sent[Counter::messages_sent], 1U);
    EXPECT_EQ(sent[Counter::frames_sent], 4U);
    EXPECT_EQ(sent[Counter::messages_received], 1U);
    EXPECT_EQ(received[Counter::messages_received], 1U);
    EXPECT_EQ(received[Counter::frames_received], 4U);
    EXPECT_EQ(received[Counter::requests_dispatched], 1U);
    EXPECT_EQ(received[Counter::messages_sent], 1U);
}

/// Keeps a controller's mailboxes full of random frames.
class Garbage {
  public:
    Garbage(Bus& bus, unsigned seed) : controller_(bus.attach("garbage")), random_(seed) {}

    void refill() {
        while (const auto event = controller_->poll()) {
            if (std::holds_alternative<can::TransmitResult>(*event)) ++sent;
        }
        controller_->recover();  // where its collisions drove it to bus-off
        while (std::holds_alternative<can::TransmitHandle>(controller_->send(frame()))) {
        }
    }

    int sent = 0;

  private:
    unsigned below(unsigned n) { return static_cast<unsigned>(random_()) % n; }

    can::Frame frame() {
        can::Frame frame;
        frame.extended = below(50) == 0;
        frame.remote = below(50) == 0;
        frame.length = static_cast<std::uint8_t>(below(9));
        for (std::size_t i = 0; i < frame.length; ++i) {
            frame.data[i] = static_cast<std::uint8_t>(random_());
        }
        frame.id = below(2048);
        if (below(2) == 0) {  // to node 1, or to group 5, which listen
            frame.id = below(2) == 0 ? 0x400 | 1 << 5 | below(32) : 5 << 5 | below(32);
        }
        if (below(2) == 0) {  // almost a message
            static constexpr std::uint8_t begins[] = {0x10, 0x11, 0x12, 0x81, 0x82, 0x20};
            frame.data[0] = begins[below(6)];
            frame.data[1] = below(8) == 0 ? 1 : 0;
            frame.data[2] = static_cast<std::uint8_t>(below(24));
            frame.data[5] = 0x08;
            frame.data[6] = static_cast<std::uint8_t>(below(3));
        }
        return frame;
    }

    std::unique_ptr<can::Controller> controller_;
    std::mt19937 random_;
};

TEST_F(Events, GarbageAtFullLoadHarmsNothing) {
    Orb server{bus, node(1)};
    Orb client{bus, node(2)};
    server.on_event([&](const Event&) { server.recover(); });
    client.on_event([&](const Event&) { client.recover(); });
    TestServant servant{{{0, nothing}, {1, echo}}};
    const ObjectRef self = server.root_poa().activate_object_with_id(1, servant);
    server.object_join(self, GroupId{5});
    int frames = 0;
    bool stopped = false;  // outlives the garbage, as the simulation's callback does
    {
        Garbage garbage{bus, 1};
        simulation.every(300us, simulation.now(), [&] {
            if (!stopped) garbage.refill();
        });
        const TimerId timer = client.every(10ms, [&] {
            try {
                at(client, 1, 1).with_timeout(8ms).invoke(1, {});
            } catch (const SystemException&) {  // with this on the bus, anything
            }
        });
        simulation.run_for(10s);
        stopped = true;
        client.cancel(timer);
        frames = garbage.sent;
    }
    EXPECT_GT(frames, 40'000);  // full load
    EXPECT_GT(server.counters()[Counter::malformed_messages], 0U);
    EXPECT_GT(server.counters()[Counter::frames_not_caniop], 0U);
    simulation.run_for(1s);
    const std::vector<std::uint8_t> octets{1, 2, 3, 4, 5, 6, 7, 8, 9};
    EXPECT_EQ(at(client, 1, 1).invoke(1, octets), octets);
    const int before = servant.calls;
    group(client, 5).invoke(0, {});
    simulation.run_for(10ms);
    EXPECT_EQ(servant.calls, before + 1);
}

}  // namespace
}  // namespace canorb::test
