// The management object costs no heap, but for a page of structs.

#include <gtest/gtest.h>

#include <array>

#include "canorb/simulation.hpp"
#include "orb/services/node_object.hpp"
#include "tests/support/allocations.hpp"
#include "tests/support/octets.hpp"

namespace canorb::services {
namespace {

using canorb::test::allocations;
using canorb::test::octets;

class Allocation : public testing::Test {
  protected:
    std::size_t allocations_of(OperationId operation, std::string_view parameters) {
        const auto in = octets(parameters);
        poa::ServerCall call{operation, ccdr::Decoder{in}, reply_};
        const std::size_t before = allocations;
        poa::dispatch(object_, call);
        const std::size_t after = allocations;
        EXPECT_EQ(call.outcome(), poa::ServerCall::Outcome::no_exception) << int{operation};
        return after - before;
    }

    Simulation simulation_;
    std::shared_ptr<runtime::OrbImpl> orb_ = std::make_shared<runtime::OrbImpl>(
        simulation_.add_bus(), OrbOptions{.node = 3, .name = "sixteen letters."});
    NodeObject object_{*orb_};
    std::array<std::uint8_t, 4096> reply_{};
};

TEST_F(Allocation, IsOneForAPageAndNoneForAllElse) {
    orb_->on_restart([] {});
    EXPECT_EQ(allocations_of(0, ""), 0U);          // identity
    EXPECT_EQ(allocations_of(1, ""), 0U);          // uptime_ms
    EXPECT_EQ(allocations_of(2, "00 08"), 1U);     // active_objects
    EXPECT_EQ(allocations_of(3, "00 08"), 1U);     // local_groups
    EXPECT_EQ(allocations_of(4, "05 00 20"), 0U);  // group_members
    EXPECT_EQ(allocations_of(5, "00 10"), 1U);     // counters
    EXPECT_EQ(allocations_of(6, ""), 0U);          // controller
    EXPECT_EQ(allocations_of(7, ""), 0U);          // restart
    orb_->close();
}

}  // namespace
}  // namespace canorb::services
