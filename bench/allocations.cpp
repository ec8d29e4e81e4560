// How often a call touches the heap, once as many buffers have been made as are in use at a time:
// calls of operator new, by the thread that calls, the one that serves and the one that is the bus.
// What it takes to throw an exception is counted, except for the memory of the exception itself,
// which the C++ runtime takes from malloc().
//
// With --stacks NAME each place that allocates in the operation of that name is printed.

#include <execinfo.h>
#include <unistd.h>
#include <canorb/orb.hpp>

#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <new>
#include <string_view>
#include <thread>

#include "allocations.hpp"

namespace {

enum Thread : std::size_t { others, calling, serving, thread_kinds };

std::array<std::atomic<std::uint64_t>, thread_kinds> allocations{};
std::atomic<bool> tracing = false;
thread_local Thread this_thread = others;

void print_stack() {
    std::array<void*, 24> frames;
    const int depth = ::backtrace(frames.data(), static_cast<int>(frames.size()));
    ::backtrace_symbols_fd(frames.data(), depth, STDOUT_FILENO);
    static_cast<void>(!::write(STDOUT_FILENO, "\n", 1));
}

}  // namespace

// Not inlined: gcc would take malloc() and delete for a mismatch.
[[gnu::noinline]] void* operator new(std::size_t size) {
    ++allocations[this_thread];
    if (tracing.exchange(false)) {
        print_stack();
        tracing = true;
    }
    if (void* memory = std::malloc(size)) return memory;
    std::abort();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
    std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}

namespace {

using namespace std::chrono_literals;

class DeviceImpl final : public Bounded::DeviceServant {
  public:
    explicit DeviceImpl(Bounded::Callback client = {}) : client_(std::move(client)) {}

    void touch() override {}
    std::int64_t exchange(std::int32_t a, std::uint16_t& b, double& c) override {
        c = 0.5;
        return a + b++;
    }
    canorb::BoundedString<60> name(const canorb::BoundedString<60>& wanted) override {
        return wanted;
    }
    Bounded::Samples sample(const Bounded::Samples& channels, Bounded::Reading& last) override {
        last = {1, 20.5F, "degrees"};
        return channels;
    }
    void refuse() override { throw Bounded::Refused{7, "because"}; }
    void forbid() override { throw canorb::NO_PERMISSION(); }
    void tell(std::uint32_t) override { ++told; }
    void announce(std::uint32_t) override { ++told; }
    void call_back(std::uint32_t ticket) override { client_.ready(ticket); }

    std::atomic<std::uint64_t> told = 0;

  private:
    Bounded::Callback client_;
};

class CallbackImpl final : public Bounded::CallbackServant {
  public:
    void ready(std::uint32_t) override {}
};

constexpr int warm_up = 200;
constexpr int calls = 1000;

void measure(std::string_view name, std::string_view traced, const std::function<void()>& call) {
    for (int i = 0; i < warm_up; ++i) call();
    std::array<std::uint64_t, thread_kinds> before{};
    for (std::size_t i = 0; i < thread_kinds; ++i) before[i] = allocations[i];
    tracing = name == traced;
    for (int i = 0; i < (tracing ? 1 : calls); ++i) call();
    tracing = false;
    const auto per_call = [&](Thread thread) {
        return static_cast<double>(allocations[thread] - before[thread]) / calls;
    };
    std::printf("%-42s %8.3f %8.3f %8.3f\n", std::string{name}.c_str(), per_call(calling),
                per_call(serving), per_call(others));
}

}  // namespace

int main(int argc, char** argv) {
    using Bounded::Device;
    const std::string_view traced =
        argc == 3 && std::string_view{argv[1]} == "--stacks" ? argv[2] : "";
    const auto bus = canorb::open_bus("local:allocations?bitrate=1000000");
    CallbackImpl callback;
    canorb::Orb client{*bus, {.node = 1}};
    const auto ready = client.root_poa().activate_object(callback);

    canorb::Orb server{*bus, {.node = 2}};
    DeviceImpl servant{
        server.string_to_object(client.object_to_string(ready)).narrow<Bounded::Callback>()};
    const auto object = server.root_poa().activate_object_with_id(1, servant);
    server.object_join(object, canorb::GroupId{5});
    std::thread loop{[&] {
        this_thread = serving;
        server.run();
    }};
    this_thread = calling;

    std::printf("%-42s %8s %8s %8s\n", "calls of operator new for each", "caller", "servant",
                "bus");
    const auto device = client.string_to_object("corbaloc:caniop:2/1").narrow<Device>();
    measure("void touch()", traced, [&] { device.touch(); });
    measure("touch(), with_timeout", traced,
            [&] { device.with_timeout(1s).unchecked_narrow<Device>().touch(); });
    measure("long long exchange(in, inout, out)", traced, [&] {
        std::uint16_t b = 1;
        double c = 0;
        static_cast<void>(device.exchange(-1, b, c));
    });
    const canorb::BoundedString<60> name{"a name that takes several frames"};
    measure("string<60> name(in string<60>)", traced,
            [&] { static_cast<void>(device.name(name)); });
    const Bounded::Samples channels{1, 2, 3, 400, 50'000};
    measure("sequence and struct", traced, [&] {
        Bounded::Reading last;
        static_cast<void>(device.sample(channels, last));
    });
    measure("user exception", traced, [&] {
        try {
            device.refuse();
        } catch (const Bounded::Refused&) {
        }
    });
    measure("system exception", traced, [&] {
        try {
            device.forbid();
        } catch (const canorb::NO_PERMISSION&) {
        }
    });
    // Followed by a call that is answered, so that they do not pile up in the queue.
    measure("oneway void tell(in), touch()", traced, [&] {
        device.tell(1);
        device.touch();
    });
    measure("nested: calls back into the caller", traced, [&] { device.call_back(1); });

    DeviceImpl here;
    const auto own = client.root_poa().activate_object(here);
    const auto local = own.narrow<Device>();
    measure("touch() of an object of the own node", traced, [&] { local.touch(); });
    client.object_join(own, canorb::GroupId{5});
    const auto group = client.group_reference(canorb::GroupId{5}).narrow<Device>();
    measure("to a group with a local member, touch()", traced, [&] {
        group.announce(1);
        device.touch();
    });
    std::uint64_t sent = 0;
    const auto with_sent = device.with_sent([&sent] { ++sent; }).unchecked_narrow<Device>();
    measure("touch(), with_sent", traced, [&] { with_sent.touch(); });

    server.shutdown();
    loop.join();
}
