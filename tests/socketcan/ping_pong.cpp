// What the ORB costs on a CAN interface: void calls between two processes, compared with the same
// frames between two processes that do nothing but pass them back and forth.
//
//     socketcan_ping_pong INTERFACE [LEAST_RATIO [ROUND_TRIPS [ROUNDS]]]
//
// The two take turns, since the speed of a machine is not the same from one second to the next.
// Exit code 0 where the ORB makes at least LEAST_RATIO of the others' round trips in a second. The
// goal is 0.8, which is not reached where processors are emulated (doc/testing-socketcan.md); the
// least ratio, 0.25 unless given, is there to notice when the ORB gets slower.

#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <string>
#include <vector>

#include "canorb/orb.hpp"
#include "canorb/stub.hpp"
#include "tests/socketcan/raw_socket.hpp"

namespace {

using canorb::test::RawSocket;

// From node 5 to object 1 on node 3, operation 7, and back (doc/wire/caniop.md, doc/wire/giop.md).
constexpr std::uint32_t request_id = 0b1'00011'00101;
constexpr std::uint32_t reply_id = 0b1'00101'00011;
constexpr std::array<std::uint8_t, 8> request{0x10, 0x00, 0x05, 0x12, 0x34, 0x18, 0x01, 0x07};
constexpr std::array<std::uint8_t, 6> reply{0x11, 0x00, 0x03, 0x12, 0x34, 0x00};

constexpr double goal = 0.8;

constexpr canorb::InterfaceInfo bell_interface{"IDL:Test/Bell:1.0"};

class Bell final : public canorb::Servant {
  public:
    const canorb::InterfaceInfo& _interface_info() const override { return bell_interface; }
    void _dispatch(canorb::ServerCall& call) override {
        if (call.operation() == 7 && call.read()) call.reply();
    }
};

/// A process that answers, for as long as this object lives.
class Server {
  public:
    /// `serve` calls its argument when it is ready, and does not return.
    explicit Server(const std::function<void(const std::function<void()>& ready)>& serve) {
        int pipe_ends[2] = {};
        if (::pipe(pipe_ends) != 0) std::abort();
        pid_ = ::fork();
        if (pid_ == 0) {
            ::prctl(PR_SET_PDEATHSIG, SIGKILL);
            try {
                serve([&] { (void)!::write(pipe_ends[1], "r", 1); });
            } catch (const std::exception& exception) {
                std::fprintf(stderr, "server: %s\n", exception.what());
            }
            ::_exit(1);
        }
        ::close(pipe_ends[1]);
        char ready = 0;
        is_ready_ = ::read(pipe_ends[0], &ready, 1) == 1;
        ::close(pipe_ends[0]);
    }
    ~Server() {
        ::kill(pid_, SIGKILL);
        ::waitpid(pid_, nullptr, 0);
    }
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    bool is_ready() const { return is_ready_; }

  private:
    pid_t pid_ = 0;
    bool is_ready_ = false;
};

/// How many times in a second `round_trip` can be made.
double per_second(int round_trips, const std::function<void()>& round_trip) {
    using Clock = std::chrono::steady_clock;
    for (int i = 0; i < round_trips / 10; ++i) round_trip();
    const auto started = Clock::now();
    for (int i = 0; i < round_trips; ++i) round_trip();
    return round_trips / std::chrono::duration<double>(Clock::now() - started).count();
}

double bare_round(const std::string& interface, int round_trips) {
    const Server server{[&](const auto& ready) {
        RawSocket socket{interface};
        socket.accept_only(request_id);
        ready();
        for (;;) {
            (void)socket.receive();
            socket.send(reply_id, reply);
        }
    }};
    if (!server.is_ready()) std::exit(1);
    RawSocket socket{interface};
    socket.accept_only(reply_id);
    return per_second(round_trips, [&] {
        socket.send(request_id, request);
        (void)socket.receive();
    });
}

double orb_round(const std::string& interface, int round_trips) {
    const std::string address = "socketcan:" + interface;
    const Server server{[&](const auto& ready) {
        const auto bus = canorb::open_bus(address);
        canorb::Orb orb{*bus, {.node = 3}};
        Bell bell;
        orb.root_poa().activate_object_with_id(1, bell);
        ready();
        orb.run();
    }};
    if (!server.is_ready()) std::exit(1);
    const auto bus = canorb::open_bus(address);
    canorb::Orb orb{*bus, {.node = 5}};
    const canorb::ObjectRef object = orb.string_to_object("corbaloc:caniop:3/1");
    const canorb::OperationInfo ring{&bell_interface, 7, "ring", false, true};
    return per_second(round_trips, [&] {
        // As generated stubs do it.
        canorb::ClientCall call{object, ring};
        call.invoke();
        call.read();
    });
}

double median(std::vector<double> values) {
    std::nth_element(values.begin(),
                     values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2];
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2 || argc > 5) {
        std::fprintf(stderr, "usage: %s INTERFACE [LEAST_RATIO [ROUND_TRIPS [ROUNDS]]]\n", argv[0]);
        return 2;
    }
    const std::string interface = argv[1];
    const double least_ratio = argc > 2 ? std::atof(argv[2]) : 0.25;
    const int round_trips = argc > 3 ? std::atoi(argv[3]) : 500;
    const int rounds = argc > 4 ? std::atoi(argv[4]) : 21;
    try {
        std::vector<double> bare;
        std::vector<double> orb;
        std::vector<double> ratios;
        for (int round = 0; round < rounds; ++round) {
            bare.push_back(bare_round(interface, round_trips));
            orb.push_back(orb_round(interface, round_trips));
            ratios.push_back(orb.back() / bare.back());
            std::printf("bare %8.0f round trips/s, ORB %8.0f, ratio %.3f\n", bare.back(),
                        orb.back(), ratios.back());
            std::fflush(stdout);
        }
        const double ratio = median(ratios);
        std::printf("medians: bare %.0f round trips/s, ORB %.0f, ratio %.3f\n", median(bare),
                    median(orb), ratio);
        std::printf("the goal, %.1f, is %s; less than %.2f counts as a failure\n", goal,
                    ratio >= goal ? "reached" : "not reached", least_ratio);
        return ratio >= least_ratio ? 0 : 1;
    } catch (const std::exception& exception) {
        std::fprintf(stderr, "%s: %s\n", argv[0], exception.what());
        return 1;
    }
}
