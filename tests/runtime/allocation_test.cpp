// A call of bounded types touches the heap neither at the caller nor at the servant, nor in the
// link, once as many buffers have been made as are in use at a time. Also over the event loop of a
// real clock, since a simulation keeps no thread waiting.

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>

#include "bounded.hpp"
#include "canorb/orb.hpp"
#include "tests/support/allocations.hpp"

namespace canorb::test {
namespace {

using namespace std::chrono_literals;

class DeviceImpl final : public Bounded::DeviceServant {
  public:
    void touch() override {}
    std::int64_t exchange(std::int32_t a, std::uint16_t& b, double& c) override {
        c = 0.5;
        return a + b++;
    }
    Bounded::Samples sample(const BoundedString<60>& name, const Bounded::Samples& channels,
                            Bounded::Reading& last) override {
        last = {1, 20.5F, name.view().substr(0, 7)};
        return channels;
    }
    void refuse() override { throw Bounded::Refused{7, "because"}; }
    void tell(std::uint32_t) override { ++told; }
    void announce(std::uint32_t) override { ++told; }
    void call_back() override { back.touch(); }

    Bounded::Device back;
    std::atomic<int> told = 0;
};

class BoundedCalls : public testing::Test {
  protected:
    BoundedCalls() {
        auto object = server.root_poa().activate_object_with_id(1, servant);
        server.object_join(object, GroupId{5});
        const ObjectRef own = client.root_poa().activate_object_with_id(1, here);
        client.object_join(own, GroupId{5});
        local = own.narrow<Bounded::Device>();
        servant.back =
            server.string_to_object("corbaloc:caniop:1/1").unchecked_narrow<Bounded::Device>();
        device = client.string_to_object("corbaloc:caniop:2/1").unchecked_narrow<Bounded::Device>();
        group = client.group_reference(GroupId{5}).unchecked_narrow<Bounded::Device>();
        loop = std::thread{[this] { server.run(); }};
    }
    ~BoundedCalls() override {
        server.shutdown();
        loop.join();
    }

    static void expect_no_allocation(const std::function<void()>& call) {
        for (int i = 0; i < 100; ++i) call();
        const std::size_t before = allocations;
        for (int i = 0; i < 100; ++i) call();
        EXPECT_EQ(allocations - before, 0U);
    }

    static OrbOptions node(int number) {
        OrbOptions options;
        options.node = number;
        options.default_timeout = 20s;
        options.inter_frame_timeout = 10s;  // threads may be kept waiting on a busy machine
        return options;
    }

    std::unique_ptr<Bus> bus = open_bus("local:bounded_calls?bitrate=1000000");
    DeviceImpl servant;
    DeviceImpl here;
    Orb server{*bus, node(2)};
    Orb client{*bus, node(1)};
    Bounded::Device device;
    Bounded::Device local;
    Bounded::Device group;
    std::thread loop;
};

TEST_F(BoundedCalls, OfOneFrame) {
    expect_no_allocation([&] { device.touch(); });
}

TEST_F(BoundedCalls, WithADeadlineOfTheirOwn) {
    expect_no_allocation(
        [&] { device.with_timeout(10s).unchecked_narrow<Bounded::Device>().touch(); });
}

TEST_F(BoundedCalls, WithParametersOfAllDirections) {
    expect_no_allocation([&] {
        std::uint16_t b = 1;
        double c = 0;
        static_cast<void>(device.exchange(-1, b, c));
        Bounded::Reading last;
        static_cast<void>(device.sample("a name of several frames", {1, 2, 50'000}, last));
    });
}

TEST_F(BoundedCalls, WithAUserException) {
    // Its own memory is the C++ runtime's, which does not ask operator new.
    expect_no_allocation([&] { EXPECT_THROW(device.refuse(), Bounded::Refused); });
}

TEST_F(BoundedCalls, OnewayAndToAGroupWithALocalMember) {
    int calls = 0;
    expect_no_allocation([&] {
        device.tell(1);
        group.announce(2);
        device.touch();  // so that they do not pile up
        ++calls;
    });
    client.run_for(1ms);
    EXPECT_EQ(servant.told, 2 * calls);
    EXPECT_EQ(here.told, calls);
}

TEST_F(BoundedCalls, ThatCallBackIntoTheirCaller) {
    expect_no_allocation([&] { device.call_back(); });
}

TEST_F(BoundedCalls, OfTheOwnNode) {
    expect_no_allocation([&] { local.touch(); });
}

}  // namespace
}  // namespace canorb::test
