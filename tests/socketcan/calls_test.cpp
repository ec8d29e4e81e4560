// Calls over CAN interfaces: every kind of them, on one virtual interface and between two real
// drivers.

#include <atomic>

#include "gauge.hpp"
#include "tests/socketcan/can_test.hpp"

namespace canorb::test {
namespace {

struct Kind {
    const char* name;
    std::optional<Interfaces> (*interfaces)();
    const char* variable;
    friend void PrintTo(const Kind& kind, std::ostream* out) { *out << kind.name; }
};

class Calls : public testing::TestWithParam<Kind> {
  protected:
    void SetUp() override {
        const std::optional<Interfaces> found = GetParam().interfaces();
        if (!found) GTEST_SKIP() << GetParam().variable << " names no interfaces";
        interfaces = *found;
    }

    Interfaces interfaces;
};

INSTANTIATE_TEST_SUITE_P(Interfaces, Calls,
                         testing::Values(Kind{"Vcan", vcan, "CANORB_TEST_VCAN"},
                                         Kind{"CanPair", can_pair, "CANORB_TEST_CAN_PAIR"}),
                         [](const auto& kind) { return std::string{kind.param.name}; });

TEST_P(Calls, VoidCall) {
    Node server{"socketcan:" + interfaces.first, 3};
    Node client{"socketcan:" + interfaces.second, 5};
    TestServant servant{{{7, nothing}}};
    server->root_poa().activate_object_with_id(1, servant);
    EXPECT_TRUE(client.object_on(3).invoke(7, {}).empty());
    EXPECT_EQ(servant.calls, 1);
    EXPECT_EQ(client->counters()[Counter::frames_sent], 1U);
    EXPECT_EQ(client->counters()[Counter::frames_received], 1U);
}

TEST_P(Calls, ManyInBothDirectionsAtOnce) {
    Node one{"socketcan:" + interfaces.first, 1};
    Node two{"socketcan:" + interfaces.second, 2};
    TestServant servants[2] = {TestServant{{{8, echo}}}, TestServant{{{8, echo}}}};
    one->root_poa().activate_object_with_id(1, servants[0]);
    two->root_poa().activate_object_with_id(1, servants[1]);
    const auto call = [](const ObjectRef& target, std::uint8_t seed) {
        int right = 0;
        for (std::uint8_t i = 0; i < 50; ++i) {
            const std::vector<std::uint8_t> octets(i, static_cast<std::uint8_t>(seed + i));
            if (target.invoke(8, octets) == octets) ++right;
        }
        return right;
    };
    const ObjectRef there = one.object_on(2);
    auto other = std::async(std::launch::async, call, there, 100);
    EXPECT_EQ(call(two.object_on(1), 0), 50);
    EXPECT_EQ(other.get(), 50);
}

class GaugeImpl final : public Measuring::GaugeServant {
  public:
    float value(std::uint16_t channel) override { return static_cast<float>(channel) + 0.25F; }
    Measuring::Samples taken(const std::string& name, std::int32_t& offset) override {
        if (name != "level") throw Measuring::NoSuchGauge{name};
        offset = -offset;
        return {1, 200, 30000};
    }
    void reset() override { ++resets; }

    std::atomic<int> resets = 0;
};

TEST_P(Calls, ThroughGeneratedStubs) {
    Node server{"socketcan:" + interfaces.first, 3};
    Node client{"socketcan:" + interfaces.second, 5};
    GaugeImpl impl;
    server->root_poa().activate_object_with_id(1, impl);
    const auto gauge = client.object_on(3).narrow<Measuring::Gauge>();
    EXPECT_EQ(gauge.value(1000), 1000.25F);
    std::int32_t offset = 70'000;
    EXPECT_EQ(gauge.taken("level", offset), (Measuring::Samples{1, 200, 30000}));
    EXPECT_EQ(offset, -70'000);
    try {
        (void)gauge.taken("a name that takes several frames", offset);
        FAIL();
    } catch (const Measuring::NoSuchGauge& exception) {
        EXPECT_EQ(exception.name, "a name that takes several frames");
    }
    gauge.reset();
    EXPECT_TRUE(wait_until([&] { return impl.resets == 1; }));
}

TEST_P(Calls, GroupWithMembersInThisProcessAndInOthers) {
    const auto start = [&](const std::string& interface, const char* number) {
        auto child = std::make_unique<Child>(std::vector<std::string>{
            SOCKETCAN_NODE, "socketcan:" + interface, number, "serve", "5"});
        EXPECT_TRUE(child->says("ready\n")) << child->text();
        return child;
    };
    const auto first = start(interfaces.first, "11");
    const auto second = start(interfaces.second, "12");
    const auto third = start(interfaces.second, "13");

    Node client{"socketcan:" + interfaces.first, 1};
    // Of the others' interface: members without the one that a call names ignore it.
    static constexpr InterfaceInfo bell_interface{"IDL:Test/Bell:1.0"};
    TestServant servant{{{7, nothing}}, bell_interface};
    client->object_join(client->root_poa().activate_object(servant), GroupId{5});
    for (int i = 0; i < 3; ++i) client->group_reference(GroupId{5}).invoke(7, {});
    for (const auto& member : {first.get(), second.get(), third.get()}) {
        for (int i = 0; i < 3; ++i) ASSERT_TRUE(member->says("called\n")) << member->text();
        member->send_signal(SIGTERM);
        EXPECT_EQ(member->wait(), 0);
        EXPECT_EQ(member->text(), "ready\ncalled\ncalled\ncalled\n");
    }
    EXPECT_TRUE(wait_until([&] { return servant.calls == 3; }));
}

TEST_P(Calls, MessageOfSixtyKibibytesBothWays) {
    OrbOptions options;
    options.max_message = 65'538;
    options.default_timeout = 60s;
    Node server{"socketcan:" + interfaces.first, 3, options};
    Node client{"socketcan:" + interfaces.second, 5, options};
    TestServant servant{{{8, echo}}};
    server->root_poa().activate_object_with_id(1, servant);
    std::vector<std::uint8_t> octets(60 * 1024);
    for (std::size_t i = 0; i < octets.size(); ++i) {
        octets[i] = static_cast<std::uint8_t>(i * 7 + i / 256);
    }
    EXPECT_EQ(client.object_on(3).invoke(8, octets), octets);
    EXPECT_EQ(client->counters()[Counter::frames_lost_by_link], 0U);
    EXPECT_EQ(server->counters()[Counter::frames_lost_by_link], 0U);
}

}  // namespace
}  // namespace canorb::test
