#include "tests/can/slcan_adapter.hpp"

#include <fcntl.h>

#include <array>
#include <chrono>
#include <cstdlib>

#include "orb/can/link/slcan_protocol.hpp"

namespace canorb::can::test {
namespace {

using namespace std::chrono_literals;

constexpr Duration patience = 5ms;

std::unique_ptr<Controller> attached_to(const std::string& address) {
    auto link = open_link(address);
    if (!link) throw std::runtime_error(link.error());
    auto controller = std::move(*(*link)->attach("adapter"));
    const std::array<Filter, 2> all{Filter{0, 0, false}, Filter{0, 0, true}};
    if (!controller->set_filters(all) || !controller->set_listen_only(true)) {
        throw std::logic_error("a local bus can do this");
    }
    return controller;
}

}  // namespace

SlcanAdapter::SlcanAdapter(const std::string& bus_address) : controller_(attached_to(bus_address)) {
    ::fcntl(line_.peer(), F_SETFL, O_NONBLOCK);
    thread_ = std::thread{[this] { run(); }};
}

SlcanAdapter::~SlcanAdapter() {
    stop_.raise();
    thread_.join();
}

bool SlcanAdapter::is_open() const {
    const std::lock_guard lock{mutex_};
    return channel_ != Channel::closed;
}

bool SlcanAdapter::listens_only() const {
    const std::lock_guard lock{mutex_};
    return channel_ == Channel::listening;
}

void SlcanAdapter::run() {
    while (true) {
        std::array<pollfd, 3> ready{{{stop_.fd(), POLLIN, 0}, {line_.peer(), POLLIN, 0}, {}}};
        {
            const std::lock_guard lock{mutex_};
            if (!output_.empty()) ready[1].events |= POLLOUT;
            ready[2] = {controller_->event_fd(), POLLIN, 0};
        }
        ::poll(ready.data(), ready.size(), waiting_ ? 1 : -1);
        if (ready[0].revents != 0) return;
        const std::lock_guard lock{mutex_};
        read_commands();
        take_events();
        if (waiting_ && monotonic_now() >= refuse_at_) {
            waiting_.reset();
            answer("\a");
        }
        write();
    }
}

void SlcanAdapter::read_commands() {
    std::array<char, 256> buffer;
    const ssize_t count = ::read(line_.peer(), buffer.data(), buffer.size());
    for (ssize_t i = 0; i < count; ++i) {
        const char octet = buffer[static_cast<std::size_t>(i)];
        if (octet != '\r') {
            command_ += octet;
        } else {
            obey(command_);
            command_.clear();
        }
    }
}

void SlcanAdapter::obey(std::string_view command) {
    if (waiting_) {
        waiting_.reset();
        answer("\a");
    }
    const bool is_closed = channel_ == Channel::closed;
    const auto message = slcan::parse_line(command);
    const auto* frame = std::get_if<Frame>(&message);
    if (frame != nullptr && channel_ == Channel::open) {
        transmit(*frame);
    } else if (command == "V") {
        answer("V1013\r");
    } else if (command.size() == 2 && command[0] == 'S' && is_closed) {
        const auto index = static_cast<std::size_t>(command[1] - '0');
        // A real one would find out on the bus that it is the wrong one.
        bitrate_set_ = index < slcan::bitrates.size() &&
                       controller_->capabilities().bitrate == slcan::bitrates[index];
        answer(bitrate_set_ ? "\r" : "\a");
    } else if (command == "X1" && is_closed) {
        answer("\r");
    } else if ((command == "O" || command == "L") && is_closed && bitrate_set_) {
        set_channel(command == "O" ? Channel::open : Channel::listening);
        answer("\r");
    } else if (command == "C" && !is_closed) {
        set_channel(Channel::closed);
        answer("\r");
    } else if (command == "F" && !is_closed) {
        const bool passive = controller_->error_status().state == ControllerState::error_passive;
        answer(passive ? (overrun_ ? "F28\r" : "F20\r") : (overrun_ ? "F08\r" : "F00\r"));
        overrun_ = false;
    } else {
        answer("\a");
    }
}

void SlcanAdapter::set_channel(Channel channel) {
    take_events();  // by the rules of the old one
    channel_ = channel;
    on_its_way_.reset();
    if (!controller_->set_listen_only(channel != Channel::open)) std::abort();
}

void SlcanAdapter::transmit(const Frame& frame) {
    if (on_its_way_) {
        waiting_ = frame;
        refuse_at_ = monotonic_now() + patience;
        return;
    }
    const SendResult result = controller_->send(frame);
    if (const auto* handle = std::get_if<TransmitHandle>(&result)) on_its_way_ = *handle;
    answer(!on_its_way_ ? "\a" : frame.extended ? "Z\r" : "z\r");
}

void SlcanAdapter::take_events() {
    while (const auto event = controller_->poll()) {
        const auto* received = std::get_if<Received>(&*event);
        const auto* result = std::get_if<TransmitResult>(&*event);
        if (received != nullptr && channel_ != Channel::closed) {
            write();
            if (output_.empty()) {
                answer(slcan::transmit_command(received->frame).text());
            } else {
                overrun_ = true;  // the host does not read
            }
        } else if (result != nullptr && on_its_way_ == result->handle) {
            on_its_way_.reset();
            if (waiting_) transmit(*std::exchange(waiting_, std::nullopt));
        } else if (const auto* lost = std::get_if<FramesLost>(&*event)) {
            overrun_ = overrun_ || lost->count > 0;
        }
    }
}

void SlcanAdapter::answer(std::string_view text) {
    output_ += text;
}

void SlcanAdapter::write() {
    const ssize_t count = ::write(line_.peer(), output_.data(), output_.size());
    if (count > 0) output_.erase(0, static_cast<std::size_t>(count));
}

}  // namespace canorb::can::test
