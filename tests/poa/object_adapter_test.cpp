#include "orb/poa/object_adapter.hpp"

#include <gtest/gtest.h>

#include <initializer_list>
#include <optional>
#include <vector>

namespace canorb::poa {
namespace {

constexpr InterfaceInfo pump_interface{"IDL:Test/Pump:1.0"};

class Pump final : public Servant {
  public:
    const InterfaceInfo& _interface_info() const override { return pump_interface; }
    void _dispatch(ServerCall&) override {}
};

class ObjectAdapterTest : public testing::Test {
  protected:
    ObjectAdapter adapter_;
    Pump pump_;
    Pump other_;
};

TEST_F(ObjectAdapterTest, SystemIdsCountUpFrom1024) {
    EXPECT_EQ(*adapter_.activate(root_poa, pump_), 1024);
    EXPECT_EQ(*adapter_.activate(root_poa, other_), 1025);
    EXPECT_EQ(adapter_.find(1024), &pump_);
    EXPECT_EQ(adapter_.find(1025), &other_);
    EXPECT_EQ(adapter_.find(1026), nullptr);
}

TEST_F(ObjectAdapterTest, ASystemIdIsNeverUsedAgain) {
    for (ObjectIndex expected = 1024; expected < 1034; ++expected) {
        ASSERT_EQ(*adapter_.activate(root_poa, pump_), expected);
        ASSERT_TRUE(adapter_.deactivate(expected));
        EXPECT_EQ(adapter_.find(expected), nullptr);
    }
}

TEST_F(ObjectAdapterTest, SystemIdsEndAt2047) {
    std::vector<Pump> pumps(1024);
    for (Pump& pump : pumps) ASSERT_TRUE(adapter_.activate(root_poa, pump).ok());
    EXPECT_EQ(adapter_.find(2047), &pumps.back());
    EXPECT_EQ(adapter_.activate(root_poa, pump_).error(), ActivationError::exhausted);
    // That one is free again does not help: references to it may still be around.
    ASSERT_TRUE(adapter_.deactivate(1024));
    EXPECT_EQ(adapter_.activate(root_poa, pump_).error(), ActivationError::exhausted);
    EXPECT_TRUE(adapter_.activate_with_id(root_poa, 1, pump_).ok());
}

TEST_F(ObjectAdapterTest, UserIdsAreFrom1To1023) {
    EXPECT_EQ(*adapter_.activate_with_id(root_poa, 1, pump_), 1);
    EXPECT_EQ(*adapter_.activate_with_id(root_poa, 1023, other_), 1023);
    EXPECT_EQ(adapter_.find(1), &pump_);
    EXPECT_EQ(adapter_.find(1023), &other_);
    Pump third;
    for (const ObjectIndex index : std::initializer_list<ObjectIndex>{0, 1024, 2047, 2048, 65535}) {
        EXPECT_EQ(adapter_.activate_with_id(root_poa, index, third).error(),
                  ActivationError::index_out_of_range)
            << index;
        EXPECT_EQ(adapter_.find(index), nullptr) << index;
    }
}

TEST_F(ObjectAdapterTest, AUserIdThatIsFreeAgainMayBeUsedAgain) {
    ASSERT_TRUE(adapter_.activate_with_id(root_poa, 7, pump_).ok());
    EXPECT_EQ(adapter_.activate_with_id(root_poa, 7, other_).error(),
              ActivationError::object_already_active);
    EXPECT_EQ(adapter_.find(7), &pump_);
    ASSERT_TRUE(adapter_.deactivate(7));
    EXPECT_EQ(*adapter_.activate_with_id(root_poa, 7, other_), 7);
}

TEST_F(ObjectAdapterTest, AServantIsOneObject) {
    ASSERT_TRUE(adapter_.activate_with_id(root_poa, 7, pump_).ok());
    EXPECT_EQ(adapter_.activate_with_id(root_poa, 8, pump_).error(),
              ActivationError::servant_already_active);
    EXPECT_EQ(adapter_.activate(root_poa, pump_).error(), ActivationError::servant_already_active);
    EXPECT_EQ(adapter_.activate_with_id(root_poa, 7, pump_).error(),
              ActivationError::object_already_active);
    // What failed has used nothing up.
    EXPECT_EQ(*adapter_.activate(root_poa, other_), 1024);
    ASSERT_TRUE(adapter_.deactivate(7));
    EXPECT_EQ(*adapter_.activate(root_poa, pump_), 1025);
}

TEST_F(ObjectAdapterTest, OnlyAnActiveObjectCanBeDeactivated) {
    for (const ObjectIndex index :
         std::initializer_list<ObjectIndex>{0, 7, 1024, 2047, 2048, 65535}) {
        EXPECT_FALSE(adapter_.deactivate(index)) << index;
    }
    ASSERT_TRUE(adapter_.activate_with_id(root_poa, 7, pump_).ok());
    EXPECT_TRUE(adapter_.deactivate(7));
    EXPECT_FALSE(adapter_.deactivate(7));
}

// ---- child POAs

TEST_F(ObjectAdapterTest, ChildrenHaveNamesUniqueAmongThem) {
    const auto a = adapter_.create(root_poa, "a", root_manager, {});
    ASSERT_TRUE(a.ok());
    EXPECT_EQ(adapter_.create(root_poa, "a", root_manager, {}).error(),
              CreationError::already_exists);
    const auto nested = adapter_.create(*a, "a", root_manager, {});
    ASSERT_TRUE(nested.ok());
    EXPECT_EQ(adapter_.find_child(root_poa, "a"), *a);
    EXPECT_EQ(adapter_.find_child(*a, "a"), *nested);
    EXPECT_EQ(adapter_.find_child(*nested, "a"), std::nullopt);
    EXPECT_EQ(adapter_.parent(*nested), *a);
    EXPECT_EQ(adapter_.parent(root_poa), std::nullopt);
    EXPECT_TRUE(adapter_.is_within(*nested, root_poa));
    EXPECT_FALSE(adapter_.is_within(root_poa, *nested));
}

TEST_F(ObjectAdapterTest, ADestroyedPoaTakesThoseBelowWithItAndFreesItsName) {
    const auto a = *adapter_.create(root_poa, "a", root_manager, {});
    const auto below = *adapter_.create(a, "below", root_manager, {});
    const auto beside = *adapter_.create(root_poa, "beside", root_manager, {});
    adapter_.destroy(a);
    EXPECT_FALSE(adapter_.exists(a));
    EXPECT_FALSE(adapter_.exists(below));
    EXPECT_TRUE(adapter_.exists(beside));
    EXPECT_EQ(adapter_.children(root_poa), std::vector<PoaId>{beside});
    const auto again = adapter_.create(root_poa, "a", root_manager, {});
    ASSERT_TRUE(again.ok());
    EXPECT_NE(*again, a);
}

// CORBA 2.6, 11.3.8.3 and SPEC's own rule: the system counts its ids anew in every run.
TEST_F(ObjectAdapterTest, PersistentNeedsUserId) {
    for (const auto uniqueness : {IdUniquenessPolicy::unique_id, IdUniquenessPolicy::multiple_id}) {
        for (const auto lifespan : {LifespanPolicy::transient, LifespanPolicy::persistent}) {
            for (const auto assignment :
                 {IdAssignmentPolicy::system_id, IdAssignmentPolicy::user_id}) {
                ObjectAdapter adapter;
                const bool legal = lifespan == LifespanPolicy::transient ||
                                   assignment == IdAssignmentPolicy::user_id;
                const auto made = adapter.create(root_poa, "child", root_manager,
                                                 {lifespan, uniqueness, assignment});
                EXPECT_EQ(made.ok(), legal);
                if (!made) {
                    EXPECT_EQ(made.error(), CreationError::invalid_policy);
                }
            }
        }
    }
}

TEST_F(ObjectAdapterTest, OneIndexSpaceForAllPoas) {
    const auto a = *adapter_.create(root_poa, "a", root_manager, {});
    const auto b = *adapter_.create(root_poa, "b", root_manager,
                                    {.id_assignment = IdAssignmentPolicy::user_id});
    EXPECT_EQ(*adapter_.activate(root_poa, pump_), 1024);
    EXPECT_EQ(*adapter_.activate(a, other_), 1025);
    // UNIQUE_ID is a rule of each POA.
    EXPECT_EQ(*adapter_.activate_with_id(b, 7, pump_), 7);
    EXPECT_EQ(adapter_.activate_with_id(root_poa, 7, other_).error(),
              ActivationError::object_already_active);
    EXPECT_EQ(adapter_.poa_of(1025), a);
    EXPECT_EQ(adapter_.poa_of(7), b);
    EXPECT_EQ(adapter_.poa_of(8), std::nullopt);
    EXPECT_EQ(adapter_.index_of(b, pump_), 7);
    EXPECT_EQ(adapter_.index_of(a, pump_), std::nullopt);
}

TEST_F(ObjectAdapterTest, AServantIsManyObjectsWhereItMayBe) {
    const auto many = *adapter_.create(root_poa, "many", root_manager,
                                       {.id_uniqueness = IdUniquenessPolicy::multiple_id});
    EXPECT_EQ(*adapter_.activate(many, pump_), 1024);
    EXPECT_EQ(*adapter_.activate(many, pump_), 1025);
    EXPECT_EQ(adapter_.index_of(many, pump_), 1024);
}

TEST_F(ObjectAdapterTest, WhoChoosesIds) {
    const auto user = *adapter_.create(root_poa, "user", root_manager,
                                       {.id_assignment = IdAssignmentPolicy::user_id});
    const auto system = *adapter_.create(root_poa, "system", root_manager, {});
    EXPECT_EQ(adapter_.activate(user, pump_).error(), ActivationError::wrong_policy);
    EXPECT_EQ(adapter_.reserve(user).error(), ActivationError::wrong_policy);
    EXPECT_EQ(adapter_.activate_with_id(user, 1024, pump_).error(),
              ActivationError::index_out_of_range);
    EXPECT_EQ(adapter_.activate_with_id(system, 1, pump_).error(),
              ActivationError::not_from_this_poa);
    EXPECT_EQ(adapter_.activate_with_id(system, 1024, pump_).error(),
              ActivationError::not_from_this_poa);
    // One that it was given, and that is free again, it may use again.
    const auto reserved = adapter_.reserve(system);
    ASSERT_EQ(*reserved, 1024);
    EXPECT_EQ(adapter_.find(1024), nullptr);
    EXPECT_EQ(*adapter_.activate_with_id(system, 1024, pump_), 1024);
    EXPECT_EQ(adapter_.activate_with_id(root_poa, 1024, other_).error(),
              ActivationError::index_out_of_range);
}

TEST_F(ObjectAdapterTest, ManagersDecideOverAllTheirPoas) {
    const auto own = *adapter_.create(root_poa, "own", std::nullopt, {});
    const auto shared = *adapter_.create(own, "shared", adapter_.manager(own), {});
    ASSERT_TRUE(adapter_.activate(own, pump_).ok());
    ASSERT_TRUE(adapter_.activate(shared, pump_).ok());
    ASSERT_TRUE(adapter_.activate(root_poa, pump_).ok());
    const auto admissions = [&] {
        return std::vector<Admission>{adapter_.admission(1024), adapter_.admission(1025),
                                      adapter_.admission(1026)};
    };
    using enum Admission;
    EXPECT_EQ(admissions(), (std::vector<Admission>{hold, hold, dispatch}));
    ASSERT_TRUE(adapter_.set_state(adapter_.manager(own), PoaManagerState::active));
    EXPECT_EQ(admissions(), (std::vector<Admission>{dispatch, dispatch, dispatch}));
    ASSERT_TRUE(adapter_.set_state(adapter_.manager(own), PoaManagerState::discarding));
    EXPECT_EQ(admissions(), (std::vector<Admission>{discard, discard, dispatch}));
    ASSERT_TRUE(adapter_.set_state(adapter_.manager(own), PoaManagerState::inactive));
    EXPECT_EQ(admissions(), (std::vector<Admission>{inactive, inactive, dispatch}));
    EXPECT_FALSE(adapter_.set_state(adapter_.manager(own), PoaManagerState::active));
    EXPECT_EQ(adapter_.create(root_poa, "late", adapter_.manager(own), {}).error(),
              CreationError::manager_inactive);
    EXPECT_EQ(adapter_.admission(1027), not_active);
    EXPECT_EQ(adapter_.admission(0xFFFF), not_active);
}

TEST_F(ObjectAdapterTest, TheManagementObjectIsInNoPoa) {
    EXPECT_EQ(adapter_.admission(0), Admission::not_active);
    adapter_.activate_management_object(pump_);
    ASSERT_TRUE(adapter_.set_state(root_manager, PoaManagerState::inactive));
    EXPECT_EQ(adapter_.admission(0), Admission::dispatch);
    EXPECT_EQ(adapter_.poa_of(0), std::nullopt);
    EXPECT_EQ(adapter_.find(0), &pump_);
    EXPECT_EQ(adapter_.next_active(0), 0);
}

TEST_F(ObjectAdapterTest, ActiveObjectsAreFoundInTheOrderOfTheirIndices) {
    EXPECT_EQ(adapter_.next_active(0), std::nullopt);
    ASSERT_TRUE(adapter_.activate(root_poa, other_).ok());
    ASSERT_TRUE(adapter_.activate_with_id(root_poa, 7, pump_).ok());
    EXPECT_EQ(adapter_.next_active(0), 7);
    EXPECT_EQ(adapter_.next_active(7), 7);
    EXPECT_EQ(adapter_.next_active(8), 1024);
    EXPECT_EQ(adapter_.next_active(1025), std::nullopt);
    EXPECT_EQ(adapter_.next_active(65535), std::nullopt);
    ASSERT_TRUE(adapter_.deactivate(7));
    EXPECT_EQ(adapter_.next_active(0), 1024);
}

}  // namespace
}  // namespace canorb::poa
