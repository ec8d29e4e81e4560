#include "orb/can/link/local_link.hpp"

#include <algorithm>
#include <condition_variable>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include "orb/can/link/descriptor.hpp"
#include "orb/can/link/pacer.hpp"
#include "orb/can/link/sharp_timers.hpp"
#include "orb/can/sim/bus.hpp"
#include "orb/can/sim/controller.hpp"

namespace canorb::can {
namespace {

constexpr std::uint32_t default_bitrate = 500'000;
/// So long the bus is worked on at once: who uses it waits no longer.
constexpr Duration work_at_once = std::chrono::milliseconds{2};
/// And so long others have the mutex meanwhile.
constexpr Duration pause_for_others = std::chrono::microseconds{100};

class LocalController;

/// Invariant: the bus is touched only under the mutex, and moved up to the present first, or as far
/// as it gets in a short time. What is asked of a bus that is behind happens at its own present.
class LocalBus {
  public:
    explicit LocalBus(std::uint32_t bitrate)
        : bus_(bitrate, monotonic_now()), thread_([this] { run(); }) {}

    ~LocalBus() {
        {
            const std::lock_guard lock{mutex_};
            stopping_ = true;
        }
        changed_.notify_one();
        thread_.join();
    }
    LocalBus(const LocalBus&) = delete;
    LocalBus& operator=(const LocalBus&) = delete;

    std::uint32_t bitrate() const { return bus_.bitrate(); }

    /// Access to the bus at the present moment. Its end wakes whom the changes concern.
    class Present {
      public:
        explicit Present(LocalBus& owner) : owner_(owner), lock_(owner.mutex_) {
            owner_.keep_pace();
        }
        ~Present() {
            owner_.wake_readers();
            // Only an event before the one the thread sleeps until is news to it.
            const TimePoint next = owner_.clock_.machine_time(owner_.bus_.next_event());
            if (next < owner_.wake_at_) owner_.changed_.notify_one();
        }
        Present(const Present&) = delete;
        Present& operator=(const Present&) = delete;

        sim::Bus& bus() const { return owner_.bus_; }
        const PacedClock& clock() const { return owner_.clock_; }

      private:
        LocalBus& owner_;
        std::lock_guard<std::mutex> lock_;
    };

    /// Within a Present.
    void add(LocalController* controller) { controllers_.push_back(controller); }
    void remove(LocalController* controller) { std::erase(controllers_, controller); }

  private:
    void run();
    bool keep_pace();
    void wake_readers();

    std::mutex mutex_;
    std::condition_variable changed_;
    sim::Bus bus_;
    std::vector<LocalController*> controllers_;
    Pacer pacer_;
    PacedClock clock_;
    TimePoint wake_at_ = never;
    bool stopping_ = false;
    std::thread thread_;  // the last member: it starts when all others are there
};

class LocalController final : public Controller {
  public:
    explicit LocalController(std::shared_ptr<LocalBus> bus) : bus_(std::move(bus)) {
        const LocalBus::Present present{*bus_};
        controller_.emplace(present.bus());
        bus_->add(this);
    }

    ~LocalController() override {
        const LocalBus::Present present{*bus_};
        bus_->remove(this);
        controller_.reset();
    }

    bool is_open() const { return readable_.is_open(); }

    Capabilities capabilities() const override {
        const LocalBus::Present present{*bus_};
        return controller_->capabilities();
    }
    [[nodiscard]] SendResult send(const Frame& frame, SendOptions options) override {
        const LocalBus::Present present{*bus_};
        return controller_->send(frame, options);
    }
    void abort(TransmitHandle handle) override {
        const LocalBus::Present present{*bus_};
        controller_->abort(handle);
    }
    [[nodiscard]] bool set_filters(std::span<const Filter> filters) override {
        const LocalBus::Present present{*bus_};
        return controller_->set_filters(filters);
    }
    [[nodiscard]] bool set_listen_only(bool on) override {
        const LocalBus::Present present{*bus_};
        return controller_->set_listen_only(on);
    }
    ErrorStatus error_status() const override {
        const LocalBus::Present present{*bus_};
        return controller_->error_status();
    }
    std::optional<std::string> recover() override {
        const LocalBus::Present present{*bus_};
        return controller_->recover();
    }
    std::optional<ControllerEvent> poll() override {
        const LocalBus::Present present{*bus_};
        auto event = controller_->poll();
        if (raised_ && !controller_->has_event()) {
            raised_ = false;
            readable_.clear();
        }
        if (event) return present.clock().machine_time(*event);
        return std::nullopt;
    }
    int event_fd() const override { return readable_.fd(); }

    /// Within a Present, or under its mutex.
    void wake_reader() {
        if (raised_ || !controller_->has_event()) return;
        raised_ = true;
        readable_.raise();
    }

  private:
    std::shared_ptr<LocalBus> bus_;
    std::optional<sim::Controller> controller_;
    Signal readable_;
    bool raised_ = false;
};

void LocalBus::wake_readers() {
    for (LocalController* controller : controllers_) controller->wake_reader();
}

/// Whether the bus is at the present moment.
bool LocalBus::keep_pace() {
    const TimePoint now = monotonic_now();
    if (clock_.advance(bus_, now, now + work_at_once)) return true;
    clock_.slip(bus_, now);
    return false;
}

void LocalBus::run() {
    use_sharp_timers();
    std::unique_lock lock{mutex_};
    while (!stopping_) {
        const bool in_time = keep_pace();
        wake_readers();
        wake_at_ = clock_.machine_time(pacer_.wake_at(bus_));
        if (!in_time) wake_at_ = std::max(wake_at_, monotonic_now() + pause_for_others);
        if (wake_at_ == never) {
            changed_.wait(lock);
        } else {
            // The steady clock is CLOCK_MONOTONIC, the bus's clock.
            changed_.wait_until(lock,
                                std::chrono::steady_clock::time_point{wake_at_.time_since_epoch()});
        }
    }
}

/// The process's local buses by name. A bus lives as long as a link or controller uses it.
class LocalBuses {
  public:
    Result<std::shared_ptr<LocalBus>, std::string> open(const LocalAddress& address) {
        const std::lock_guard lock{mutex_};
        std::erase_if(buses_, [](const auto& entry) { return entry.second.expired(); });
        auto& entry = buses_[address.name];
        if (auto bus = entry.lock()) {
            if (address.bitrate && *address.bitrate != bus->bitrate()) {
                return Failure{"local:" + address.name + " runs at " +
                               std::to_string(bus->bitrate()) + " bit/s, not at " +
                               std::to_string(*address.bitrate)};
            }
            return bus;
        }
        auto bus = std::make_shared<LocalBus>(address.bitrate.value_or(default_bitrate));
        entry = bus;
        return bus;
    }

  private:
    std::mutex mutex_;
    std::map<std::string, std::weak_ptr<LocalBus>> buses_;
};

class LocalLink final : public Link {
  public:
    explicit LocalLink(std::shared_ptr<LocalBus> bus) : bus_(std::move(bus)) {}

    Result<std::unique_ptr<Controller>, std::string> attach(std::string_view) override {
        auto controller = std::make_unique<LocalController>(bus_);
        if (!controller->is_open()) {
            return Failure{std::string{"no more file descriptors for a controller"}};
        }
        return std::unique_ptr<Controller>{std::move(controller)};
    }

    TimePoint now() const override { return monotonic_now(); }

  private:
    std::shared_ptr<LocalBus> bus_;
};

}  // namespace

Result<std::unique_ptr<Link>, std::string> open_local_link(const LocalAddress& address) {
    // Two parts of a process find the same bus by its name only through something they share.
    static LocalBuses buses;
    auto bus = buses.open(address);
    if (!bus) return Failure{bus.error()};
    return std::unique_ptr<Link>{std::make_unique<LocalLink>(*bus)};
}

}  // namespace canorb::can
