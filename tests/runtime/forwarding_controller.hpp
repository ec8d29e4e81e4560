#pragma once

#include <memory>
#include <utility>

#include "orb/can/controller.hpp"

namespace canorb::test {

/// Hands everything on to a real controller; a test's own one derives from it and spoils something.
class ForwardingController : public can::Controller {
  public:
    explicit ForwardingController(std::unique_ptr<can::Controller> real) : real_(std::move(real)) {}

    can::Capabilities capabilities() const override { return real_->capabilities(); }
    can::SendResult send(const can::Frame& frame, can::SendOptions options) override {
        return real_->send(frame, options);
    }
    void abort(can::TransmitHandle handle) override { real_->abort(handle); }
    bool set_filters(std::span<const can::Filter> filters) override {
        return real_->set_filters(filters);
    }
    bool set_listen_only(bool on) override { return real_->set_listen_only(on); }
    can::ErrorStatus error_status() const override { return real_->error_status(); }
    std::optional<std::string> recover() override { return real_->recover(); }
    int event_fd() const override { return real_->event_fd(); }
    std::optional<can::ControllerEvent> poll() override { return real_->poll(); }

  private:
    std::unique_ptr<can::Controller> real_;
};

}  // namespace canorb::test
