#include "tests/can/slcan_adapter.hpp"

#include <fcntl.h>

#include <array>
#include <chrono>

#include "orb/can/link/slcan_protocol.hpp"

namespace canorb::can::test {
namespace {

using namespace std::chrono_literals;

constexpr Duration patience = 5ms;

std::unique_ptr<Link> opened(const std::string& address) {
    auto link = open_link(address);
    if (!link) throw std::runtime_error(link.error());
    return std::move(*link);
}

}  // namespace

SlcanAdapter::SlcanAdapter(const std::string& bus_address) : link_(opened(bus_address)) {
    ::fcntl(line_.peer(), F_SETFL, O_NONBLOCK);
    thread_ = std::thread{[this] { run(); }};
}

SlcanAdapter::~SlcanAdapter() {
    stop_.raise();
    thread_.join();
}

bool SlcanAdapter::is_open() const {
    const std::lock_guard lock{mutex_};
    return controller_ != nullptr;
}

bool SlcanAdapter::listens_only() const {
    const std::lock_guard lock{mutex_};
    return controller_ != nullptr && listen_only_;
}

void SlcanAdapter::run() {
    while (true) {
        std::array<pollfd, 3> ready{{{stop_.fd(), POLLIN, 0}, {line_.peer(), POLLIN, 0}, {}}};
        {
            const std::lock_guard lock{mutex_};
            if (!output_.empty()) ready[1].events |= POLLOUT;
            ready[2] = {controller_ ? controller_->event_fd() : -1, POLLIN, 0};
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
    const bool is_open = controller_ != nullptr;
    const auto message = slcan::parse_line(command);
    const auto* frame = std::get_if<Frame>(&message);
    if (frame != nullptr && is_open && !listen_only_) {
        transmit(*frame);
    } else if (command == "V") {
        answer("V1013\r");
    } else if (command.size() == 2 && command[0] == 'S' && !is_open) {
        const auto index = static_cast<std::size_t>(command[1] - '0');
        // A wrong bit rate would be seen on the bus only.
        bitrate_set_ = index < slcan::bitrates.size() &&
                       link_->attach("")->get()->capabilities().bitrate == slcan::bitrates[index];
        answer(bitrate_set_ ? "\r" : "\a");
    } else if (command == "X1" && !is_open) {
        answer("\r");
    } else if ((command == "O" || command == "L") && !is_open && bitrate_set_) {
        open(command == "L");
        answer("\r");
    } else if (command == "C" && is_open) {
        controller_.reset();
        busy_ = false;
        answer("\r");
    } else if (command == "F" && is_open) {
        const bool passive = controller_->error_status().state == ControllerState::error_passive;
        answer(passive ? (overrun_ ? "F28\r" : "F20\r") : (overrun_ ? "F08\r" : "F00\r"));
        overrun_ = false;
    } else {
        answer("\a");
    }
}

void SlcanAdapter::open(bool listen_only) {
    controller_ = std::move(*link_->attach("adapter"));
    listen_only_ = listen_only;
    const std::array<Filter, 2> all{Filter{0, 0, false}, Filter{0, 0, true}};
    if (!controller_->set_filters(all) || !controller_->set_listen_only(listen_only)) {
        throw std::logic_error("a local bus can do this");
    }
}

void SlcanAdapter::transmit(const Frame& frame) {
    if (busy_) {
        waiting_ = frame;
        refuse_at_ = monotonic_now() + patience;
        return;
    }
    busy_ = std::holds_alternative<TransmitHandle>(controller_->send(frame));
    answer(!busy_ ? "\a" : frame.extended ? "Z\r" : "z\r");
}

void SlcanAdapter::take_events() {
    while (controller_) {
        const auto event = controller_->poll();
        if (!event) return;
        if (const auto* received = std::get_if<Received>(&*event)) {
            write();
            if (output_.empty()) {
                answer(slcan::transmit_command(received->frame).text());
            } else {
                overrun_ = true;  // the host does not read
            }
        } else if (std::holds_alternative<FramesLost>(*event)) {
            overrun_ = true;
        } else if (std::holds_alternative<TransmitResult>(*event)) {
            busy_ = false;
            if (waiting_) transmit(*std::exchange(waiting_, std::nullopt));
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
