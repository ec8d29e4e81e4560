#pragma once

#include "orb/can/controller.hpp"
#include "orb/can/sim/bus.hpp"

namespace canorb::can::sim {

/// A controller on a Bus, for one thread: the one that advances the bus. It acts at the bus's
/// now() and has no event_fd(). The bus must outlive it.
class Controller : public can::Controller {
  public:
    explicit Controller(Bus& bus, const NodeOptions& options = {});
    ~Controller() override;

    Capabilities capabilities() const override;
    [[nodiscard]] SendResult send(const Frame& frame, SendOptions options = {}) override;
    void abort(TransmitHandle handle) override;
    [[nodiscard]] bool set_filters(std::span<const Filter> filters) override;
    [[nodiscard]] bool set_listen_only(bool on) override;
    ErrorStatus error_status() const override;
    std::optional<std::string> recover() override;
    std::optional<ControllerEvent> poll() override;
    int event_fd() const override { return -1; }

    /// Whether poll() would return an event.
    bool has_event() const { return !bus_.events(node_).empty(); }
    /// The event that poll() would return, or null.
    const ControllerEvent* next_event() const { return bus_.events(node_).front(); }
    /// Whether the next frame for it would be lost.
    bool is_full() const { return bus_.events(node_).receive_full(); }
    /// Its number on the bus, as in CompletedFrame::sender.
    NodeIndex node() const { return node_; }

  private:
    Bus& bus_;
    NodeIndex node_;
    std::uint64_t next_handle_ = 1;
};

}  // namespace canorb::can::sim
