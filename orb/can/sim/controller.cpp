#include "orb/can/sim/controller.hpp"

namespace canorb::can::sim {

Controller::Controller(Bus& bus, const NodeOptions& options)
    : bus_(bus), node_(bus.attach(options)) {}

Controller::~Controller() {
    bus_.detach(node_);
}

Capabilities Controller::capabilities() const {
    return bus_.capabilities(node_);
}

SendResult Controller::send(const Frame& frame, SendOptions options) {
    const TransmitHandle handle{next_handle_};
    if (const auto error = bus_.submit(node_, frame, handle, options)) return *error;
    ++next_handle_;
    return handle;
}

void Controller::abort(TransmitHandle handle) {
    bus_.abort(node_, handle);
}

bool Controller::set_filters(std::span<const Filter> filters) {
    return bus_.set_filters(node_, filters);
}

bool Controller::set_listen_only(bool on) {
    bus_.set_listen_only(node_, on);
    return true;
}

ErrorStatus Controller::error_status() const {
    return bus_.error_status(node_);
}

std::optional<std::string> Controller::recover() {
    bus_.recover(node_);
    return std::nullopt;
}

std::optional<ControllerEvent> Controller::poll() {
    return bus_.poll(node_);
}

}  // namespace canorb::can::sim
