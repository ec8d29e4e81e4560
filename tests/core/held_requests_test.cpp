// Requests whose POA manager is not active: held, refused, or let go again.

#include "tests/core/test_engine.hpp"

namespace canorb::core::test {
namespace {

class Bell final : public poa::Servant {
  public:
    const InterfaceInfo& _interface_info() const override { return bell; }
    void _dispatch(poa::ServerCall&) override {}
};

/// Node 5 with object 1 in a POA of its own, whose manager holds.
class HeldRequests : public testing::Test {
  protected:
    HeldRequests() : node(options()) {
        poa = *adapter().create(poa::root_poa, "held", std::nullopt,
                                {.id_assignment = IdAssignmentPolicy::user_id});
        EXPECT_TRUE(adapter().activate_with_id(poa, 1, servant).ok());
        EXPECT_TRUE(adapter().activate_with_id(poa::root_poa, 2, other).ok());
    }

    static EngineOptions options() {
        EngineOptions result = TestEngine::options();
        result.max_held_requests = 2;
        return result;
    }
    poa::ObjectAdapter& adapter() { return node.engine.adapter(); }
    bool become(PoaManagerState state) {
        return node.engine.set_manager_state(adapter().manager(poa), state);
    }

    TestEngine node;
    Bell servant;
    Bell other;
    poa::PoaId poa{};
};

TEST_F(HeldRequests, WaitInTheirOrderUntilTheManagerIsActive) {
    node.receive("4A3 1000050001280101");
    node.receive("4A4 1000050001280102");
    node.receive("4A3 1000050002280203");
    EXPECT_EQ(node.requests(), Texts{"object 2 operation 3 "});
    EXPECT_FALSE(node.engine.has_request());
    EXPECT_EQ(node.transmit(), Texts{});
    ASSERT_TRUE(become(PoaManagerState::active));
    EXPECT_TRUE(node.engine.has_request());
    node.receive("4A3 1000050003280104");
    EXPECT_EQ(node.requests(),
              (Texts{"object 1 operation 1 ", "object 1 operation 2 ", "object 1 operation 4 "}));
    EXPECT_FALSE(node.engine.has_request());
}

TEST_F(HeldRequests, BeyondTheQueueAreTransient) {
    for (const char* frame : {"4A3 1000050001280101", "4A3 1000050002280101"}) node.receive(frame);
    EXPECT_EQ(node.requests(), Texts{});
    node.receive("4A3 1000050003280101");
    EXPECT_EQ(node.requests(), Texts{});
    // TRANSIENT, minor 45, completion NO, for request 0003.
    EXPECT_EQ(node.transmit(),
              frames_of("465", system_exception_reply("0003", "TRANSIENT", "2D", "01")));
    EXPECT_EQ(node.counted()["requests_refused"], 1U);
}

TEST_F(HeldRequests, AreRefusedAsTheManagerSays) {
    node.receive("4A3 1000050001280101");
    EXPECT_EQ(node.requests(), Texts{});
    ASSERT_TRUE(become(PoaManagerState::discarding));
    EXPECT_EQ(node.requests(), Texts{});
    // TRANSIENT, minor 44.
    EXPECT_EQ(node.transmit(),
              frames_of("465", system_exception_reply("0001", "TRANSIENT", "2C", "01")));
    ASSERT_TRUE(become(PoaManagerState::inactive));
    node.receive("4A3 1000050002280101");
    EXPECT_EQ(node.requests(), Texts{});
    // OBJ_ADAPTER, minor 46.
    EXPECT_EQ(node.transmit(),
              frames_of("465", system_exception_reply("0002", "OBJ_ADAPTER", "2E", "01")));
    EXPECT_FALSE(become(PoaManagerState::active));
}

TEST_F(HeldRequests, AreHandedOutWhenTheirObjectGoes) {
    node.receive("4A3 1000050001280101");
    EXPECT_EQ(node.requests(), Texts{});
    ASSERT_TRUE(node.engine.deactivate(1));
    // Its owner finds no servant, and answers OBJECT_NOT_EXIST.
    EXPECT_EQ(node.requests(), Texts{"object 1 operation 1 "});
}

TEST_F(HeldRequests, OfThisNodeDoNotOutliveTheirDeadline) {
    const CallHandle call = node.call("2801", 1, "", 10ms);
    EXPECT_EQ(node.requests(), Texts{});
    node.advance(10ms);
    EXPECT_EQ(node.result(call), "TIMEOUT NO 3");
    ASSERT_TRUE(become(PoaManagerState::active));
    EXPECT_EQ(node.requests(), Texts{});
}

TEST_F(HeldRequests, OneMemberOfAGroupIsHeld) {
    ASSERT_TRUE(node.engine.join(GroupId{7}, {1, &bell}));
    ASSERT_TRUE(node.engine.join(GroupId{7}, {2, &bell}));
    node.receive("0E3 10000500014DDB02");
    auto request = node.engine.next_request(node.now);
    ASSERT_TRUE(request.has_value());
    EXPECT_FALSE(node.engine.admit(*request, 1));
    EXPECT_TRUE(node.engine.admit(*request, 2));
    EXPECT_FALSE(request->one_member);
    ASSERT_TRUE(become(PoaManagerState::active));
    const auto held = node.engine.next_request(node.now);
    ASSERT_TRUE(held.has_value());
    EXPECT_TRUE(held->one_member);
    EXPECT_EQ(held->object, 1);
    EXPECT_EQ(held->interface_key, 0x4DDB);
    EXPECT_TRUE(held->group == GroupId{7});
    ASSERT_TRUE(become(PoaManagerState::discarding));
    EXPECT_FALSE(node.engine.admit(*held, 1));
    EXPECT_EQ(node.counted()["group_requests_dropped"], 1U);
}

}  // namespace
}  // namespace canorb::core::test
