#include "orb/can/link/local_link.hpp"

#include <algorithm>
#include <array>
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
/// So much happens at once on a bus that is not paced, where a frame that nobody may acknowledge
/// is repeated for ever.
constexpr int max_steps_at_once = 1000;
/// A reader that keeps the bus waiting for longer loses frames.
constexpr Duration longest_stall = std::chrono::milliseconds{100};

class LocalController;

/// Those who are to be woken at the end, not at once: who is woken on the same CPU would run, and
/// only wait for the mutex. As many as this has room for; more are woken at once.
class Wakers {
  public:
    Wakers() = default;
    ~Wakers() {
        for (std::size_t i = 0; i < count_; ++i) wakers_[i]->wake();
    }
    Wakers(const Wakers&) = delete;
    Wakers& operator=(const Wakers&) = delete;

    void add(const std::shared_ptr<Waker>& waker) {
        const auto end = wakers_.begin() + static_cast<std::ptrdiff_t>(count_);
        if (std::find(wakers_.begin(), end, waker) != end) return;
        if (count_ < wakers_.size()) {
            wakers_[count_++] = waker;
        } else {
            waker->wake();
        }
    }

  private:
    std::array<std::shared_ptr<Waker>, 4> wakers_;
    std::size_t count_ = 0;
};

/// Invariants: the bus is touched only under the mutex. A paced one is moved up to the present
/// first, or as far as it gets in a short time; what is asked of a bus that is behind happens at
/// its own present. One that is not paced runs when somebody does something on it, until all is
/// sent; its thread goes on where that was not all: a reader must catch up, or there was too much
/// of it.
class LocalBus {
  public:
    LocalBus(std::uint32_t bitrate, bool paced)
        : bus_(bitrate, monotonic_now()),
          paced_(paced),
          thread_([this] { paced_ ? run() : finish(); }) {}

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
    bool paced() const { return paced_; }

    /// Access to the bus at the present moment. Its end wakes whom the changes concern.
    class Present {
      public:
        explicit Present(LocalBus& owner) : owner_(owner), lock_(owner.mutex_) {
            if (owner_.paced_) owner_.keep_pace();
        }
        ~Present() {
            if (!owner_.paced_) {
                settle();
                return;
            }
            owner_.wake_readers(wakers_);
            // Only an event before the one the thread sleeps until is news to it.
            const TimePoint next = owner_.clock_.machine_time(owner_.bus_.next_event());
            if (next < owner_.wake_at_) owner_.changed_.notify_one();
        }
        Present(const Present&) = delete;
        Present& operator=(const Present&) = delete;

        /// On a bus that is not paced: all that can happen, happens.
        void settle() {
            owner_.unfinished_ = !owner_.run_until_quiet();
            owner_.wake_readers(wakers_);
            if (owner_.unfinished_) owner_.changed_.notify_one();
        }
        sim::Bus& bus() const { return owner_.bus_; }
        const PacedClock& clock() const { return owner_.clock_; }

      private:
        LocalBus& owner_;
        Wakers wakers_;  // before the lock: they are woken when that is released
        std::lock_guard<std::mutex> lock_;
    };

    /// Within a Present.
    void add(LocalController* controller) { controllers_.push_back(controller); }
    void remove(LocalController* controller) { std::erase(controllers_, controller); }

  private:
    void run();
    void finish();
    bool keep_pace();
    bool run_until_quiet();
    bool is_stalled();
    void wake_readers(Wakers& wakers);

    std::mutex mutex_;
    std::condition_variable changed_;
    sim::Bus bus_;
    std::vector<LocalController*> controllers_;
    Pacer pacer_;
    PacedClock clock_;  ///< stands still on a bus that is not paced
    TimePoint wake_at_ = never;
    std::optional<TimePoint> stalled_since_;  ///< something on the bus waits for a reader
    bool unfinished_ = false;                 ///< the thread of a bus without a pace has to go on
    bool stopping_ = false;
    const bool paced_;
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
        LocalBus::Present present{*bus_};
        const SendResult sent = controller_->send(frame, options);
        const auto* handle = std::get_if<TransmitHandle>(&sent);
        if (handle == nullptr || bus_->paced()) return sent;
        // Mostly it is on the bus at once: then nobody need be woken to hear of it.
        telling_ = true;
        present.settle();
        telling_ = false;
        const auto* event = controller_->next_event();
        const auto* result = event == nullptr ? nullptr : std::get_if<TransmitResult>(event);
        if (result == nullptr || result->handle != *handle) return sent;
        TransmitResult known = *result;
        known.time = monotonic_now();
        controller_->poll();
        return known;
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
        if (!controller_->is_full()) lagging_ = false;
        if (raised_ && !controller_->has_event()) {
            raised_ = false;
            readable_.clear();
        }
        if (!event) return std::nullopt;
        if (bus_->paced()) return present.clock().machine_time(*event);
        // The clock of such a bus says nothing about how long its users take.
        std::visit([now = monotonic_now()](auto& each) { each.time = now; }, *event);
        return event;
    }
    int event_fd() const override {
        const LocalBus::Present present{*bus_};
        watched_ = true;
        return readable_.fd();
    }
    bool wake_with(std::shared_ptr<Waker> waker) override {
        const LocalBus::Present present{*bus_};
        waker_ = std::move(waker);
        return true;
    }

    /// Within a Present, or under its mutex. Whether the bus is to wait until it has read.
    bool keeps_waiting() const { return controller_ && !lagging_ && controller_->is_full(); }
    /// The bus has waited for it long enough: it loses frames until it has read.
    void give_up() { lagging_ = lagging_ || keeps_waiting(); }

    /// Within a Present, or under its mutex.
    void wake_reader(Wakers& wakers) {
        if (telling_ || !controller_ || !controller_->has_event()) return;
        if (waker_) wakers.add(waker_);
        if (raised_ || !watched_) return;
        raised_ = true;
        readable_.raise();
    }

  private:
    std::shared_ptr<LocalBus> bus_;
    std::optional<sim::Controller> controller_;
    Signal readable_;
    bool raised_ = false;
    mutable bool watched_ = false;  ///< somebody has the descriptor
    std::shared_ptr<Waker> waker_;
    bool telling_ = false;  ///< its reader is being told by send()
    bool lagging_ = false;
};

void LocalBus::wake_readers(Wakers& wakers) {
    for (LocalController* controller : controllers_) controller->wake_reader(wakers);
}

/// Whether the bus is at the present moment.
bool LocalBus::keep_pace() {
    const TimePoint now = monotonic_now();
    if (clock_.advance(bus_, now, now + work_at_once)) return true;
    clock_.slip(bus_, now);
    return false;
}

/// False: it has to go on later.
bool LocalBus::run_until_quiet() {
    for (int i = 0; i < max_steps_at_once; ++i) {
        if (bus_.is_quiet()) {
            stalled_since_.reset();
            return true;
        }
        if (is_stalled()) return false;
        bus_.advance_one();
    }
    return false;
}

/// Whether what is on the bus has to wait for a reader, so that no frame is lost only because the
/// bus is faster than any real one; though not for ever.
bool LocalBus::is_stalled() {
    if (std::ranges::none_of(controllers_, &LocalController::keeps_waiting)) {
        stalled_since_.reset();
        return false;
    }
    const TimePoint now = monotonic_now();
    if (!stalled_since_) stalled_since_ = now;
    if (now - *stalled_since_ < longest_stall) return true;
    stalled_since_.reset();
    for (LocalController* controller : controllers_) controller->give_up();
    return false;
}

void LocalBus::finish() {
    std::unique_lock lock{mutex_};
    while (!stopping_) {
        if (!unfinished_) {
            changed_.wait(lock);
            continue;
        }
        const TimePoint next =
            stalled_since_ ? *stalled_since_ + longest_stall : monotonic_now() + pause_for_others;
        changed_.wait_until(lock, std::chrono::steady_clock::time_point{next.time_since_epoch()});
        if (stopping_ || !unfinished_) continue;
        Wakers wakers;
        unfinished_ = !run_until_quiet();
        wake_readers(wakers);
    }
}

void LocalBus::run() {
    use_sharp_timers();
    std::unique_lock lock{mutex_};
    while (!stopping_) {
        const bool in_time = keep_pace();
        {
            Wakers wakers;
            wake_readers(wakers);
        }
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
            if (address.paced && *address.paced != bus->paced()) {
                return Failure{"local:" + address.name + (bus->paced() ? " is" : " is not") +
                               " paced: its clock cannot be changed while it is in use"};
            }
            if (address.bitrate && *address.bitrate != bus->bitrate()) {
                return Failure{"local:" + address.name + " runs at " +
                               std::to_string(bus->bitrate()) + " bit/s, not at " +
                               std::to_string(*address.bitrate)};
            }
            return bus;
        }
        auto bus = std::make_shared<LocalBus>(address.bitrate.value_or(default_bitrate),
                                              address.paced.value_or(true));
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
