// restart(): only where the application allows it, and not before who asked has the answer.

#include <canorb/node.hpp>

#include <thread>

#include "orb/runtime/orb_impl.hpp"
#include "tests/runtime/world.hpp"
#include "tests/support/octets.hpp"

namespace canorb::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class NodeRestart : public World {
  protected:
    static Node node_object(Orb& orb, int number) {
        return at(orb, number, 0).unchecked_narrow<Node>();
    }

    Orb server{bus, node(3)};
    Orb client{bus, node(1)};
};

TEST_F(NodeRestart, IsNotPermittedByItself) {
    EXPECT_EQ(error_of([&] { node_object(client, 3).restart(); }),
              (SystemError{SystemErrorKind::no_permission, Completion::no, 51}));

    int restarts = 0;
    server.on_restart([&] { ++restarts; });
    server.on_restart({});
    EXPECT_THROW(node_object(client, 3).restart(), NO_PERMISSION);
    simulation.run_for(5s);
    EXPECT_EQ(restarts, 0);
}

TEST_F(NodeRestart, BeginsWhenTheAnswerIsOnTheBus) {
    std::vector<std::string> on_the_bus;
    server.on_restart([&] {
        for (const Seen& one : seen) on_the_bus.push_back(hex(one.frame.payload()));
    });
    node_object(client, 3).restart();
    simulation.run_for(1ms);
    ASSERT_EQ(on_the_bus.size(), 2U);
    const std::string id = on_the_bus[0].substr(6, 4);
    // Request, object key: node 3, index 0; operation 7. Reply, NO_EXCEPTION.
    EXPECT_THAT(on_the_bus, ElementsAre("100005" + id + "180007", "110003" + id + "00"));
}

TEST_F(NodeRestart, WaitsForACallThatIsNotYetAnswered) {
    // Requests are served, and messages sent, between the asking and the answer.
    auto orb = std::make_shared<runtime::OrbImpl>(bus, node(7));
    TestServant lamp{{{0, nothing}}};
    client.root_poa().activate_object_with_id(1, lamp);
    std::vector<std::string> order;
    orb->on_restart([&] { order.emplace_back("restart"); });
    orb->set_management_object(
        std::make_unique<TestServant>(std::map<OperationId, TestServant::Operation>{
            {7, [&](ServerCall& call) {
                 EXPECT_TRUE(orb->request_restart());
                 orb->string_to_object("corbaloc:caniop:1/1").invoke(0, {});
                 order.emplace_back("answer");
                 nothing(call);
             }}}));
    node_object(client, 7).restart();
    simulation.run_for(1ms);
    EXPECT_EQ(lamp.calls, 1);
    EXPECT_THAT(order, ElementsAre("answer", "restart"));
    orb->on_restart({});
    orb->close();
}

TEST_F(NodeRestart, EndsTheEventLoopOfWhoShutsDown) {
    bool restart = false;
    server.on_restart([&] {
        restart = true;
        server.shutdown();
    });
    bool answered = false;
    simulation.at(simulation.now() + 1ms, [&] {
        node_object(client, 3).restart();
        answered = true;
    });
    EXPECT_FALSE(server.run_for(10s));
    EXPECT_TRUE(restart);
    simulation.run_for(1ms);
    EXPECT_TRUE(answered);
}

TEST_F(NodeRestart, BeginsOnceAndWithoutABusToo) {
    Simulation elsewhere;
    SimulatedBus& empty_bus = elsewhere.add_bus();
    Orb alone{empty_bus, node(7)};
    std::vector<Duration> restarts;
    const TimePoint begin = elsewhere.now();
    alone.on_restart([&] { restarts.push_back(elsewhere.now() - begin); });
    group(alone, 5).invoke(0, {});  // nobody acknowledges: it stays in the queue
    node_object(alone, 7).restart();
    node_object(alone, 7).restart();
    elsewhere.run_until(begin + 999ms);
    EXPECT_THAT(restarts, ElementsAre());
    elsewhere.run_until(begin + 10s);
    EXPECT_THAT(restarts, ElementsAre(1s));  // the default timeout

    node_object(alone, 7).restart();
    alone.on_restart({});
    elsewhere.run_until(begin + 20s);
    EXPECT_THAT(restarts, ElementsAre(1s));
}

TEST_F(NodeRestart, MayBeAskedForAgain) {
    int restarts = 0;
    server.on_restart([&] { ++restarts; });
    for (int i = 1; i <= 3; ++i) {
        node_object(client, 3).restart();
        simulation.run_for(1ms);
        EXPECT_EQ(restarts, i);
    }
}

TEST_F(NodeRestart, ThatThrowsIsReported) {
    server.on_restart([] { throw std::runtime_error("no way"); });
    node_object(client, 3).restart();
    simulation.run_for(1ms);
    ASSERT_EQ(log.size(), 1U);
    EXPECT_THAT(log[0], HasSubstr("node-3: the restart callback raised no way"));
    EXPECT_EQ(node_object(client, 3).identity().node, 3);
}

TEST_F(NodeRestart, CallbackMayReplaceItself) {
    std::vector<int> restarts;
    server.on_restart([&] {
        restarts.push_back(1);
        server.on_restart([&] { restarts.push_back(2); });
    });
    for (int i = 0; i < 2; ++i) {
        node_object(client, 3).restart();
        simulation.run_for(1ms);
    }
    EXPECT_THAT(restarts, ElementsAre(1, 2));
}

TEST_F(NodeRestart, CallbackKeepsNoOrbAlive) {
    // What it holds goes with the Orb, though it holds a reference to that.
    auto held = std::make_shared<int>(0);
    {
        Orb orb{bus, node(9)};
        orb.on_restart([held, self = at(orb, 9, 0)] {});
        EXPECT_EQ(held.use_count(), 2);
    }
    EXPECT_EQ(held.use_count(), 1);
}

TEST(NodeRestartThreads, TheCallerGetsItsAnswerAndTheServerStops) {
    const auto bus = open_bus("local:node-restart");
    Orb server{*bus, {.node = 3}};
    bool restart = false;
    server.on_restart([&] {
        restart = true;
        server.shutdown();
    });
    std::thread serving{[&] { server.run(); }};
    Orb client{*bus, {.node = 1}};
    const Node node = client.string_to_object("corbaloc:caniop:3/0").narrow<Node>();
    EXPECT_NO_THROW(node.with_timeout(10s).restart());
    serving.join();
    EXPECT_TRUE(restart);
}

}  // namespace
}  // namespace canorb::test
