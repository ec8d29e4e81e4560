// Calls from within calls: while a servant waits for an answer, its ORB goes on serving.

#include "tests/runtime/world.hpp"

namespace canorb::test {
namespace {

class Nested : public World {
  protected:
    Orb a{bus, node(1)};
    Orb b{bus, node(2)};
};

TEST_F(Nested, CallbackIntoTheCaller) {
    TestServant listener{{{0, nothing}}};
    TestServant relay{{{0, [this](ServerCall& call) {
                            at(b, 1, 1).invoke(0, {});
                            nothing(call);
                        }}}};
    a.root_poa().activate_object_with_id(1, listener);
    b.root_poa().activate_object_with_id(1, relay);
    at(a, 2, 1).invoke(0, {});
    EXPECT_EQ(listener.calls, 1);
    EXPECT_EQ(relay.calls, 1);
    EXPECT_EQ(seen.size(), 4U);
}

TEST_F(Nested, ThroughThreeNodesAndBack) {
    Orb c{bus, node(3)};
    std::vector<std::string> order;
    const auto forward = [&](Orb& from, int to, std::string name) {
        return [&order, &from, to, name](ServerCall& call) {
            std::uint8_t hops{};
            if (!call.read(hops)) return;
            order.push_back(name);
            std::uint8_t sum = 1;
            if (hops > 0) {
                const std::uint8_t left[] = {static_cast<std::uint8_t>(hops - 1)};
                sum = static_cast<std::uint8_t>(sum + at(from, to, 1).invoke(0, left).at(0));
            }
            call.reply(sum);
        };
    };
    TestServant on_a{{{0, forward(a, 2, "a")}}};
    TestServant on_b{{{0, forward(b, 3, "b")}}};
    TestServant on_c{{{0, forward(c, 1, "c")}}};
    a.root_poa().activate_object_with_id(1, on_a);
    b.root_poa().activate_object_with_id(1, on_b);
    c.root_poa().activate_object_with_id(1, on_c);
    const std::uint8_t hops[] = {4};
    EXPECT_EQ(at(a, 2, 1).invoke(0, hops), std::vector<std::uint8_t>{5});
    EXPECT_EQ(order, (std::vector<std::string>{"b", "c", "a", "b", "c"}));
}

TEST_F(Nested, BeyondDepthEightIsTransient) {
    int depth_of_a = 0;
    int deepest = 0;
    const auto recurse = [](Orb& from, int to) {
        return [&from, to](ServerCall& call) {
            at(from, to, 1).invoke(0, {});
            nothing(call);
        };
    };
    TestServant on_a{{{0, [&](ServerCall& call) {
                           deepest = std::max(deepest, ++depth_of_a);
                           const auto leave =
                               std::shared_ptr<void>(nullptr, [&](void*) { --depth_of_a; });
                           recurse(a, 2)(call);
                       }}}};
    TestServant on_b{{{0, recurse(b, 1)}}};
    a.root_poa().activate_object_with_id(1, on_a);
    b.root_poa().activate_object_with_id(1, on_b);
    EXPECT_EQ(error_of([&] { at(a, 2, 1).invoke(0, {}); }),
              (SystemError{SystemErrorKind::transient, Completion::no, 14}));
    EXPECT_EQ(on_b.calls, 8);
    EXPECT_EQ(deepest, 8);
    EXPECT_EQ(depth_of_a, 0);
    EXPECT_EQ(b.counters()[Counter::requests_refused], 1U);
    // Both are as good as new.
    EXPECT_THROW(at(a, 2, 1).invoke(0, {}), TRANSIENT);
}

TEST_F(Nested, WithinOneNode) {
    TestServant inner{{{1, echo}}};
    TestServant outer{{{1, [this](ServerCall& call) {
                            const Bytes octets = call.remaining_parameters();
                            const auto answer = at(a, 1, 1).invoke(1, octets);
                            call.reply(RawOctets{answer});
                        }}}};
    a.root_poa().activate_object_with_id(1, inner);
    a.root_poa().activate_object_with_id(2, outer);
    const std::vector<std::uint8_t> octets{1, 2, 3};
    EXPECT_EQ(at(a, 1, 2).invoke(1, octets), octets);
    EXPECT_EQ(at(b, 1, 2).invoke(1, octets), octets);
}

TEST_F(Nested, DeadlineOfTheOuterCallHolds) {
    TestServant relay{{{0, [this](ServerCall& call) {
                            EXPECT_THROW(at(b, 9, 1).with_timeout(50ms).invoke(0, {}), TIMEOUT);
                            nothing(call);
                        }}}};
    b.root_poa().activate_object_with_id(1, relay);
    EXPECT_THROW(at(a, 2, 1).with_timeout(20ms).invoke(0, {}), TIMEOUT);
    // In a simulation the inner call is on the same stack, and returns first.
    EXPECT_GE(simulation.now(), TimePoint{50ms});
    EXPECT_LT(simulation.now(), TimePoint{51ms});
    simulation.run_for(1ms);
    EXPECT_EQ(a.counters()[Counter::unmatched_replies], 1U);
}

}  // namespace
}  // namespace canorb::test
