#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <functional>
#include <future>
#include <mutex>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "canorb/orb.hpp"
#include "orb/can/link/link.hpp"
#include "tests/can/temporary_directory.hpp"
#include "tests/runtime/world.hpp"
#include "tests/socketcan/raw_socket.hpp"
#include "tests/support/child.hpp"

namespace canorb::test {

using can::test::TemporaryDirectory;
using canorb::test::Child;

/// Waits for what comes by itself, for as long as a loaded machine may take.
inline bool wait_until(const std::function<bool()>& condition) {
    const auto deadline = std::chrono::steady_clock::now() + 20s;
    while (!condition()) {
        if (std::chrono::steady_clock::now() > deadline) return false;
        std::this_thread::sleep_for(1ms);
    }
    return true;
}

/// Runs a command; a test that needs it to succeed stops here.
inline void run_command(const std::string& command) {
    if (std::system(command.c_str()) != 0) throw std::runtime_error("failed: " + command);
}

/// `ip link` and the like; needs root.
inline void ip(const std::string& arguments) {
    run_command("/sbin/ip " + arguments);
}

/// `ip link set INTERFACE up` or `down`, but without the time that a process takes.
inline void set_up(const std::string& interface, bool up) {
    const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    ifreq request{};
    interface.copy(request.ifr_name, IFNAMSIZ - 1);
    int result = ::ioctl(fd, SIOCGIFFLAGS, &request);
    request.ifr_flags =
        static_cast<short>(up ? request.ifr_flags | IFF_UP : request.ifr_flags & ~IFF_UP);
    if (result == 0) result = ::ioctl(fd, SIOCSIFFLAGS, &request);
    const std::system_error error{errno, std::generic_category(), "interface " + interface};
    ::close(fd);
    if (result != 0) throw error;
}

/// The interfaces that two nodes use: one that both are on, or two on one bus.
struct Interfaces {
    std::string first;
    std::string second;
};

/// From CANORB_TEST_VCAN and CANORB_TEST_CAN_PAIR; nothing where the variable is not set.
inline std::optional<Interfaces> vcan() {
    const char* name = std::getenv("CANORB_TEST_VCAN");
    if (name == nullptr) return {};
    return Interfaces{name, name};
}
inline std::optional<Interfaces> can_pair() {
    const char* names = std::getenv("CANORB_TEST_CAN_PAIR");
    if (names == nullptr) return {};
    const std::string_view both = names;
    const std::size_t comma = both.find(',');
    if (comma == std::string_view::npos) return {};
    return Interfaces{std::string{both.substr(0, comma)}, std::string{both.substr(comma + 1)}};
}

/// Tests with a virtual CAN interface. They are skipped where the environment names none.
class VcanTest : public testing::Test {
  protected:
    void SetUp() override {
        const std::optional<Interfaces> interfaces = vcan();
        if (!interfaces) GTEST_SKIP() << "CANORB_TEST_VCAN names no interface";
        interface = interfaces->first;
        address = "socketcan:" + interface;
    }

    std::string interface;
    std::string address;
};

/// An ORB, with a thread that runs its event loop, and what it told.
class Node {
  public:
    Node(const std::string& address, int number, OrbOptions options = {})
        : bus_(open_bus(address)), orb_(*bus_, with_number(options, number)) {
        orb_.on_event([this](const Event& event) {
            const std::lock_guard lock{mutex_};
            events_.push_back(event);
        });
        thread_ = std::thread{[this] { orb_.run(); }};
    }
    ~Node() {
        orb_.shutdown();
        thread_.join();
    }

    Orb& orb() { return orb_; }
    Orb* operator->() { return &orb_; }

    ObjectRef object_on(int node) {
        return orb_.string_to_object("corbaloc:caniop:" + std::to_string(node) + "/1");
    }

    std::vector<Event> events(Event::Kind kind) const {
        const std::lock_guard lock{mutex_};
        std::vector<Event> found;
        for (const Event& event : events_) {
            if (event.kind == kind) found.push_back(event);
        }
        return found;
    }
    /// Waits until it has told that its controller is in this state. (error_status() is ahead of
    /// that, and a call then may still end with the state before.)
    bool tells(can::ControllerState state) {
        const std::string text = " is " + std::string{can::name(state)};
        return wait_until([&] {
            const std::vector<Event> told = events(Event::Kind::controller_state);
            return !told.empty() && told.back().text.find(text) != std::string::npos;
        });
    }

  private:
    static OrbOptions with_number(OrbOptions options, int number) {
        options.node = number;
        if (options.default_timeout == OrbOptions{}.default_timeout) options.default_timeout = 20s;
        options.inter_frame_timeout = 20s;  // a loaded machine may stop a thread for long
        options.log = [](std::string_view) {};
        return options;
    }

    mutable std::mutex mutex_;
    std::vector<Event> events_;
    std::unique_ptr<Bus> bus_;
    Orb orb_;
    std::thread thread_;
};

/// A two-way call in a thread of its own, and how it ended.
class CallInProgress {
  public:
    using Clock = std::chrono::steady_clock;
    struct End {
        std::optional<SystemError> error;  ///< nothing: it was answered
        Clock::time_point time;
    };

    explicit CallInProgress(const ObjectRef& target)
        : end_(std::async(std::launch::async, [target] {
              try {
                  (void)target.invoke(7, {});
                  return End{{}, Clock::now()};
              } catch (const SystemException& exception) {
                  return End{exception.error(), Clock::now()};
              }
          })) {}

    /// Waits for it.
    End end() { return end_.get(); }

  private:
    std::future<End> end_;
};

}  // namespace canorb::test
