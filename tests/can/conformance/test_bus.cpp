#include "tests/can/conformance/test_bus.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <deque>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "orb/can/link/bus_server.hpp"
#include "orb/can/link/link.hpp"
#include "orb/can/sim/bus.hpp"
#include "orb/can/sim/controller.hpp"
#include "tests/can/slcan_adapter.hpp"
#include "tests/can/temporary_directory.hpp"

namespace canorb::can::test {
namespace {

constexpr int patience_ms = 20'000;

class VirtualBus final : public TestBus {
  public:
    explicit VirtualBus(std::uint32_t bitrate) : bus_(bitrate) {}

    std::unique_ptr<Controller> attach() override {
        return std::make_unique<sim::Controller>(bus_);
    }
    bool wait(std::span<Controller* const>) override { return bus_.advance_one(); }

  private:
    sim::Bus bus_;
};

/// A bus that goes on by itself and wakes through event_fd().
class LinkBus : public TestBus {
  public:
    std::unique_ptr<Controller> attach() override {
        auto controller = link_->attach("test");
        if (!controller) throw std::runtime_error(controller.error());
        return std::move(*controller);
    }

    bool wait(std::span<Controller* const> controllers) override {
        std::vector<pollfd> descriptors;
        for (const Controller* controller : controllers) {
            descriptors.push_back({controller->event_fd(), POLLIN, 0});
        }
        int ready = 0;
        do {
            ready = ::poll(descriptors.data(), descriptors.size(), patience_ms);
        } while (ready < 0 && errno == EINTR);
        return ready > 0;
    }

  protected:
    void open(const std::string& address) {
        auto link = open_link(address);
        if (!link) throw std::runtime_error(link.error());
        link_ = std::move(*link);
    }

  private:
    std::unique_ptr<Link> link_;
};

class LocalBus final : public LinkBus {
  public:
    explicit LocalBus(std::uint32_t bitrate) {
        open("local:conformance?bitrate=" + std::to_string(bitrate));
    }
};

class SimBus final : public LinkBus {
  public:
    SimBus(std::uint32_t bitrate, bool paced) {
        BusServerOptions options;
        options.path = directory_.path() + "/bus";
        options.bitrate = bitrate;
        options.paced = paced;
        auto server = BusServer::open(options);
        if (!server) throw std::runtime_error(server.error());
        server_ = std::move(*server);
        thread_ = std::thread{[this] { server_->run(); }};
        address_ = "sim:" + options.path;
        open(address_);
    }
    /// What is asked now is answered after it has seen what happened before.
    void settle() override {
        if (!open_link(address_)) throw std::runtime_error("the daemon does not answer");
    }
    ~SimBus() override {
        server_->stop();
        thread_.join();
    }

  private:
    TemporaryDirectory directory_;
    std::string address_;
    std::unique_ptr<BusServer> server_;
    std::thread thread_;
};

/// Interfaces that are joined, one after the other for each controller. They belong to the machine:
/// what other tests sent there may be on its way still.
class SocketCanBus final : public LinkBus {
  public:
    explicit SocketCanBus(std::vector<std::string> interfaces)
        : interfaces_(std::move(interfaces)) {}

    std::unique_ptr<Controller> attach() override {
        open("socketcan:" + interfaces_[attached_++ % interfaces_.size()]);
        return LinkBus::attach();
    }

  private:
    std::vector<std::string> interfaces_;
    std::size_t attached_ = 0;
};

/// Each controller has an adapter of its own; those are nodes of one local bus.
class SlcanBus final : public LinkBus {
  public:
    explicit SlcanBus(std::uint32_t bitrate) : bitrate_(std::to_string(bitrate)) {}

    std::unique_ptr<Controller> attach() override {
        Node& node = nodes_.emplace_back("local:behind-adapters?bitrate=" + bitrate_);
        open("slcan:" + node.adapter.device() + "?bitrate=" + bitrate_);
        auto controller = LinkBus::attach();
        node.controller = controller.get();
        return controller;
    }
    void settle() override {
        for (const Node& node : nodes_) {
            while (node.adapter.is_open() && !node.adapter.is_in_use()) std::this_thread::yield();
        }
    }
    bool is_silent(const Controller& controller) override {
        return std::any_of(nodes_.begin(), nodes_.end(), [&](const Node& node) {
            return node.controller == &controller && node.adapter.listens_only();
        });
    }

  private:
    struct Node {
        explicit Node(const std::string& bus_address) : adapter(bus_address) {}
        SlcanAdapter adapter;
        const Controller* controller = nullptr;
    };

    std::string bitrate_;
    std::deque<Node> nodes_;
};

/// The interfaces that an environment variable names, as "can0,can1".
std::vector<std::string> interfaces_in(const char* variable) {
    std::vector<std::string> names;
    const char* const value = std::getenv(variable);
    std::istringstream text{value != nullptr ? value : ""};
    for (std::string name; std::getline(text, name, ',');) names.push_back(name);
    return names;
}

}  // namespace

std::vector<LinkKind> all_links() {
    std::vector<LinkKind> links;
    links.push_back(
        {.name = "Virtual",
         .open = [](std::uint32_t bitrate) { return std::make_unique<VirtualBus>(bitrate); },
         .has_event_fd = false});
    links.push_back(
        {.name = "Local",
         .open = [](std::uint32_t bitrate) { return std::make_unique<LocalBus>(bitrate); },
         .keeps_to_clock = true});
    links.push_back(
        {.name = "SimPaced",
         .open = [](std::uint32_t bitrate) { return std::make_unique<SimBus>(bitrate, true); },
         .keeps_to_clock = true});
    links.push_back({.name = "SimUnpaced", .open = [](std::uint32_t bitrate) {
                         return std::make_unique<SimBus>(bitrate, false);
                     }});
    links.push_back(
        {.name = "Slcan",
         .open = [](std::uint32_t bitrate) { return std::make_unique<SlcanBus>(bitrate); },
         .one_clock = false,
         .exact_times = false,
         .sent_is_acknowledged = false,
         .tells_error_counters = false,
         .counts_losses = false,
         .wakes_for_events_only = false});
    if (const auto names = interfaces_in("CANORB_TEST_VCAN"); !names.empty()) {
        links.push_back(
            {.name = "Vcan",
             .open = [names](std::uint32_t) { return std::make_unique<SocketCanBus>(names); },
             .acknowledges = false,
             .one_clock = false});
    }
    if (const auto names = interfaces_in("CANORB_TEST_CAN_PAIR"); !names.empty()) {
        links.push_back(
            {.name = "CanPair",
             .open = [names](std::uint32_t) { return std::make_unique<SocketCanBus>(names); },
             .acknowledges = false,
             .one_clock = false,
             // The SJA1000 of QEMU 7.2 takes as many octets out of its receive buffer as the DLC of
             // a remote frame says, and never put any in: what comes behind is garbage.
             .remote_length = false});
    }
    return links;
}

void Station::drain() {
    if (!controller_) return;
    while (const auto event = controller_->poll()) {
        if (const auto* frame = std::get_if<Received>(&*event)) {
            const bool repeated = !received.empty() && received.back().frame == frame->frame;
            if (repeated && drops_repetitions) received.pop_back();
            received.push_back(*frame);
        }
        if (const auto* result = std::get_if<TransmitResult>(&*event)) results.push_back(*result);
        if (const auto* change = std::get_if<StateChanged>(&*event)) states.push_back(*change);
        if (const auto* loss = std::get_if<FramesLost>(&*event)) lost += loss->count;
    }
}

std::vector<std::uint32_t> Station::received_ids() const {
    std::vector<std::uint32_t> ids;
    for (const Received& each : received) ids.push_back(each.frame.id);
    return ids;
}

std::vector<TransmitHandle> Station::results_with(TransmitOutcome outcome) const {
    std::vector<TransmitHandle> handles;
    for (const TransmitResult& each : results) {
        if (each.outcome == outcome) handles.push_back(each.handle);
    }
    return handles;
}

}  // namespace canorb::can::test
