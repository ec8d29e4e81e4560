// Any frames, from anybody, at any time, between an owner's calls, answers and controller events:
// the engine stays within its limits, ends each call by its deadline, and a call afterwards works.
//
// Input: records of an action (1 octet) and an octet for it; a frame's identifier has one octet
// more, and its payload, as long as the low half of the action says (modulo 9), follows.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <optional>
#include <utility>
#include <variant>

#include "orb/core/engine.hpp"
#include "orb/giop/message.hpp"

namespace {

using namespace canorb;
using namespace std::chrono_literals;

constexpr InterfaceInfo bell{"IDL:Test/Bell:1.0"};
constexpr NodeId self{5};
constexpr NodeId peer{3};
constexpr std::size_t max_message = 64;
constexpr std::size_t max_calls = 4;

void require(bool holds) {
    if (!holds) std::abort();
}

core::EngineOptions options() {
    core::EngineOptions options;
    options.node = self;
    options.max_outstanding_calls = max_calls;
    options.max_incoming_requests = 4;
    options.answer_lifetime = 50ms;
    options.receive.max_message = max_message;
    options.receive.max_reassemblies = 3;
    options.transmit.max_messages = 8;
    options.transmit.max_octets = 512;
    return options;
}

class Owner {
  public:
    void receive(std::uint32_t id, Bytes payload) {
        engine_.on_event(can::Received{can::Frame::standard(id, payload), now_}, now_);
    }

    void act(std::uint8_t action, std::uint8_t value) {
        switch (action % 12) {
            case 0:
                pass(1ms * value);
                break;
            case 1:
                call(ObjectKey{peer, 1}, value);
                break;
            case 2:
                call(ObjectKey{self, 1}, value);
                break;
            case 3: {
                auto message = request(value);
                (void)engine_
                    .send(ObjectKey{value % 2 == 0 ? peer : self, 1}, 2,
                          MutableBytes{message}.first(8 + value % 40U), now_ + 30ms)
                    .ok();
                break;
            }
            case 4: {
                auto message = request(value);
                (void)engine_
                    .multicast(GroupId{7}, value, 2, MutableBytes{message}.first(8 + value % 40U),
                               now_ + 30ms)
                    .ok();
                break;
            }
            case 5:
                hand_over();
                finish_frame(static_cast<can::TransmitOutcome>(value % 3));
                break;
            case 6:
                answer(value);
                break;
            case 7:
                set_state(static_cast<can::ControllerState>(value % 4));
                break;
            case 8:
                engine_.on_event(can::FramesLost{value, now_}, now_);
                break;
            case 9: {
                const GroupId group{static_cast<std::uint8_t>(1 + value % 31)};
                if (value < 128) {
                    require(engine_.join(group, {1, &bell}));
                } else {
                    engine_.leave(group, 1);
                }
                can::Capabilities capabilities;
                capabilities.filter_list = value % 8U;
                (void)engine_.take_filters(capabilities);
                break;
            }
            case 10:
                engine_.set_node(NodeId::from(value));
                break;
            case 11:
                while (engine_.next_notice()) {
                }
                break;
        }
        check();
    }

    void finish() {
        set_state(can::ControllerState::error_active);
        engine_.set_node(self);
        for (int i = 0; i < 100; ++i) {
            hand_over();
            while (!in_controller_.empty()) finish_frame(can::TransmitOutcome::sent);
            answer(0);
            pass(50ms);
            check();
        }
        require(calls_.empty());
        require(engine_.queued_messages() == 0);
        require(engine_.next_deadline() == never);

        auto message = request(0);
        const auto made =
            engine_.call(ObjectKey{peer, 1}, 2, MutableBytes{message}.first(8), now_ + 1s);
        require(made.ok());
        const auto frame = engine_.next_frame(now_);
        require(frame && frame->id == 0x465 && frame->length == 8 && frame->data[0] == 0x10);
        receive(0x4A3,
                std::array<std::uint8_t, 7>{0x11, 0, 4, frame->data[3], frame->data[4], 0, 0x2A});
        const auto result = engine_.take_result(*made);
        require(result.has_value());
        const auto* answer = std::get_if<core::CallAnswer>(&*result);
        require(answer != nullptr && answer->body == core::Buffer{0x2A});
    }

  private:
    struct Call {
        core::CallHandle handle;
        TimePoint deadline;
    };

    static std::array<std::uint8_t, 64> request(std::uint8_t value) {
        std::array<std::uint8_t, 64> message{};
        message.fill(value);
        return message;
    }

    void call(ObjectKey target, std::uint8_t value) {
        auto message = request(value);
        const TimePoint deadline = now_ + 1ms * (value % 100U);
        const auto made =
            engine_.call(target, value, MutableBytes{message}.first(8 + value % 40U), deadline);
        if (made) calls_.push_back({*made, deadline});
    }

    void pass(Duration time) {
        now_ += time;
        engine_.on_time(now_);
        require(engine_.next_deadline() > now_);
        std::erase_if(calls_, [this](const Call& made) {
            if (!engine_.ended(made.handle)) {
                require(made.deadline > now_);
                return false;
            }
            auto result = engine_.take_result(made.handle);
            require(result.has_value());
            if (auto* answer = std::get_if<core::CallAnswer>(&*result)) {
                require(answer->body.size() <= max_message);
                engine_.buffers().release(std::move(answer->body));
            }
            return true;
        });
    }

    void hand_over() {
        while (const auto abort = engine_.next_abort()) aborted_.push_back(*abort);
        while (const auto frame = engine_.next_frame(now_)) {
            require(frame->length <= 8 && frame->id < 0x7E0);
            in_controller_.push_back(can::TransmitHandle{++last_frame_});
            engine_.handed_over(in_controller_.back());
        }
        require(in_controller_.size() <= 2 + aborted_.size());
    }

    void finish_frame(can::TransmitOutcome outcome) {
        if (in_controller_.empty()) return;
        const can::TransmitHandle handle = in_controller_.front();
        in_controller_.pop_front();
        engine_.on_event(can::TransmitResult{handle, outcome, now_}, now_);
    }

    void set_state(can::ControllerState state) {
        engine_.on_event(can::StateChanged{{state, 0, 0}, now_}, now_);
        if (state == can::ControllerState::bus_off || state == can::ControllerState::stopped) {
            require(engine_.queued_messages() == 0);
        }
    }

    void answer(std::uint8_t value) {
        while (auto request = engine_.next_request(now_)) {
            require(request->parameters.size() <= max_message - giop::request_header_size);
            if (value % 4 == 3) {
                engine_.refuse(request->answer_to, {}, now_);
            } else {
                std::array<std::uint8_t, 64> message{};
                engine_.answer(request->answer_to, static_cast<giop::ReplyStatus>(value % 4),
                               MutableBytes{message}.first(6 + value % 58U), now_);
            }
            engine_.buffers().release(std::move(request->parameters));
        }
    }

    void check() const {
        require(calls_.size() <= max_calls);
        require(engine_.queued_messages() <= 8);
    }

    core::Engine engine_{options()};
    TimePoint now_{1s};
    std::deque<Call> calls_;
    std::deque<can::TransmitHandle> in_controller_;
    std::deque<can::TransmitHandle> aborted_;
    std::uint64_t last_frame_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Owner owner;
    Bytes input{data, size};
    while (input.size() >= 3) {
        const std::uint8_t action = input[0];
        if (action >= 0x80) {
            owner.act(action & 0x7F, input[1]);
            input = input.subspan(2);
            continue;
        }
        const auto id = static_cast<std::uint32_t>(read_be16(&input[1]) & 0x7FF);
        const std::size_t length = std::min<std::size_t>(action % 16 % 9, input.size() - 3);
        owner.receive(id, input.subspan(3, length));
        input = input.subspan(3 + length);
    }
    owner.finish();
    return 0;
}
