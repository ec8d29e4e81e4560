#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include "orb/can/controller.hpp"

namespace canorb::can::test {

/// A bus of one kind of link, for the tests that every link has to pass.
class TestBus {
  public:
    virtual ~TestBus() = default;
    TestBus(const TestBus&) = delete;
    TestBus& operator=(const TestBus&) = delete;

    virtual std::unique_ptr<Controller> attach() = 0;

    /// Lets time pass until one of the controllers may have an event. False: none will come.
    virtual bool wait(std::span<Controller* const> controllers) = 0;

    /// Returns when the bus knows that the controllers destroyed before have left.
    virtual void settle() {}

    /// Whether set_listen_only(true) has reached the bus.
    virtual bool is_silent(const Controller&) { return true; }

  protected:
    TestBus() = default;
};

/// One kind of link.
struct LinkKind {
    std::string name;
    std::function<std::unique_ptr<TestBus>(std::uint32_t bitrate)> open;
    bool keeps_to_clock = false;  ///< a frame takes its time on the clock of monotonic_now()
    bool has_event_fd = true;     ///< and may be used by several threads
    bool acknowledges = true;     ///< a frame waits until another node acknowledges it
    bool one_clock = true;        ///< all nodes have the same time stamp for a frame
    bool remote_length = true;    ///< a remote frame's DLC may be other than 0
    bool exact_times = true;      ///< time stamps are those of the bus, not of reading
    /// `sent` comes with the acknowledgement, not when something behind the link took the frame.
    bool sent_is_acknowledged = true;
    bool tells_error_counters = true;
    bool counts_losses = true;          ///< how many frames were lost, not only that some were
    bool wakes_for_events_only = true;  ///< event_fd() is readable only when there is an event

    /// For GoogleTest's messages.
    friend void PrintTo(const LinkKind& kind, std::ostream* out) { *out << kind.name; }
};

/// Every link there is. A new one is added here, and nothing else.
std::vector<LinkKind> all_links();

/// A controller and everything that it has told.
class Station {
  public:
    explicit Station(std::unique_ptr<Controller> controller) : controller_(std::move(controller)) {}

    Controller& operator*() { return *controller_; }
    Controller* operator->() { return controller_.get(); }

    /// Takes all events there are now.
    void drain();
    /// Leaves the bus.
    void leave() { controller_.reset(); }
    bool is_attached() const { return controller_ != nullptr; }

    std::vector<std::uint32_t> received_ids() const;
    std::vector<TransmitHandle> results_with(TransmitOutcome outcome) const;

    std::vector<Received> received;
    std::vector<TransmitResult> results;
    std::vector<StateChanged> states;
    std::uint64_t lost = 0;
    /// Of the same frame several times in a row only the last is kept. A silent node hears that
    /// of a lone sender which is error passive: its flag is recessive, and disturbs nothing.
    bool drops_repetitions = false;

  private:
    std::unique_ptr<Controller> controller_;
};

}  // namespace canorb::can::test
