// The whole receive path. Any frames, from anybody, at any time, and peers that send messages frame
// by frame, interleaved with each other, between an owner's calls, cancellations, answers, changes
// of its objects and controller events: the engine stays within its limits, accounts for each
// frame, ends each call once and by its deadline, and a call afterwards works. Where nobody but
// those peers has sent, no request is executed that was not sent, none twice, and an answer is that
// of its call.
//
// Input: records of an action (1 octet, from 0x80) and an octet for it; or of a frame: an octet
// whose low half gives the length (modulo 9), two for the identifier, and the payload.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <optional>
#include <set>
#include <utility>
#include <variant>
#include <vector>

#include "orb/core/engine.hpp"
#include "orb/giop/message.hpp"

namespace {

using namespace canorb;
using namespace std::chrono_literals;

constexpr InterfaceInfo bell{"IDL:Test/Bell:1.0"};
constexpr NodeId self{5};
constexpr NodeId peer{3};
constexpr GroupId group{7};
/// What peers call. Our own oneway and group calls have 2, our two-way calls to others from 0x80.
constexpr OperationId peers_operation = 9;
constexpr std::size_t max_message = 64;
constexpr std::size_t max_calls = 4;
constexpr std::size_t max_held = 3;

void require(bool holds) {
    if (!holds) std::abort();
}

core::EngineOptions options() {
    core::EngineOptions options;
    options.node = self;
    options.max_outstanding_calls = max_calls;
    options.max_incoming_requests = 4;
    options.max_held_requests = max_held;
    options.answer_lifetime = 50ms;
    options.receive.max_message = max_message;
    options.receive.max_reassemblies = 3;
    options.transmit.max_messages = 8;
    options.transmit.max_octets = 512;
    return options;
}

class Bell final : public poa::Servant {
  public:
    const InterfaceInfo& _interface_info() const override { return bell; }
    void _dispatch(poa::ServerCall&) override {}
};

/// A node that sends to us, one frame at a time.
struct Peer {
    NodeId node;
    std::uint16_t next_request_id = 1;
    caniop::Identifier to = caniop::Identifier::to_node(self, node);
    core::Buffer message{};
    std::size_t sent = 0;  ///< octets of it
    unsigned frames = 0;   ///< frames of it
    core::Buffer frame{};  ///< the last
    std::uint32_t frame_id = 0;
    std::set<RequestId> executed{};
};

class Owner {
  public:
    Owner() { require(engine_.adapter().activate_with_id(poa::root_poa, 1, servant_).ok()); }

    /// A frame that anybody may have sent.
    void receive_anything(std::uint32_t id, Bytes payload) {
        trusting_ = false;
        receive(id, payload);
    }

    void receive(std::uint32_t id, Bytes payload) {
        ++frames_given_;
        engine_.on_event(can::Received{can::Frame::standard(id, payload), now_}, now_);
    }

    void act(std::uint8_t action, std::uint8_t value) {
        switch (action % 18) {
            case 0:
                pass(1ms * value);
                break;
            case 1:
                call(ObjectKey{peer, 1}, static_cast<OperationId>(0x80 | ++calls_made_ % 128),
                     value);
                break;
            case 2:
                call(ObjectKey{self, 1}, 1, value);
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
                const GroupId joined{static_cast<std::uint8_t>(1 + value % 31)};
                if (value < 128) {
                    require(engine_.join(joined, {1, &bell}));
                } else {
                    engine_.leave(joined, 1);
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
                cancel(value);
                break;
            case 12:
                begin_request(peers_[value % peers_.size()], value);
                break;
            case 13:
                begin_reply(peers_[value % peers_.size()], value);
                break;
            case 14:
                send_frames(peers_[value % peers_.size()], value);
                break;
            case 15:  // as a controller repeats a frame
                repeat_frame(peers_[value % peers_.size()]);
                break;
            case 16:
                if (value % 2 == 0) {
                    (void)engine_.adapter().activate_with_id(poa::root_poa, 1, servant_).ok();
                } else {
                    (void)engine_.deactivate(1);
                }
                break;
            case 17:
                // Inactive would be for ever.
                require(engine_.set_manager_state(poa::root_manager,
                                                  value % 3 == 0   ? PoaManagerState::active
                                                  : value % 3 == 1 ? PoaManagerState::holding
                                                                   : PoaManagerState::discarding));
                break;
        }
        check();
    }

    void finish() {
        set_state(can::ControllerState::error_active);
        engine_.set_node(self);
        require(engine_.set_manager_state(poa::root_manager, PoaManagerState::active));
        for (int i = 0; i < 100; ++i) {
            hand_over();
            while (!in_controller_.empty()) finish_frame(can::TransmitOutcome::sent);
            answer(0);
            pass(50ms);
            check();
            if (calls_.empty() && engine_.is_idle() && engine_.next_deadline() == never) break;
        }
        require(calls_.empty());
        require(engine_.queued_messages() == 0);
        require(engine_.next_deadline() == never);
        require(engine_.is_idle() && !engine_.has_request());

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
        check();
    }

  private:
    struct Call {
        core::CallHandle handle;
        TimePoint deadline;
        OperationId operation;
        /// What its Request carries, once its first frame was handed over.
        std::optional<RequestId> request_id{};
    };

    /// The body of the only right answer of a peer to a Request.
    static core::Buffer body_for(RequestId id) {
        return {static_cast<std::uint8_t>(id >> 8), static_cast<std::uint8_t>(id), 0x5A};
    }

    static std::array<std::uint8_t, 64> request(std::uint8_t value) {
        std::array<std::uint8_t, 64> message{};
        message.fill(value);
        return message;
    }

    void call(ObjectKey target, OperationId operation, std::uint8_t value) {
        auto message = request(value);
        const TimePoint deadline = now_ + 1ms * (value % 100U);
        const auto made =
            engine_.call(target, operation, MutableBytes{message}.first(8 + value % 40U), deadline);
        if (made) calls_.push_back({*made, deadline, operation, std::nullopt});
    }

    /// One of the calls, or none.
    void cancel(std::uint8_t value) {
        if (value >= calls_.size()) return;
        const auto call = calls_.begin() + value;
        engine_.cancel(call->handle);
        require(!engine_.deadline_of(call->handle).has_value());
        calls_.erase(call);
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
                if (trusting_ && made.request_id) {
                    require(answer->body == body_for(*made.request_id));
                }
                engine_.buffers().release(std::move(answer->body));
            }
            // It ended once, and is forgotten.
            const auto again = engine_.take_result(made.handle);
            require(again && std::holds_alternative<SystemError>(*again) &&
                    std::get<SystemError>(*again).kind == SystemErrorKind::internal);
            return true;
        });
    }

    // ---- what peers send. A Request's parameters begin with the sender and its id, so that a
    // servant knows whose it is.

    void begin(Peer& from, caniop::Identifier to, core::Buffer message) {
        from.to = to;
        from.message = std::move(message);
        from.sent = 0;
        from.frames = 0;
    }

    void begin_request(Peer& from, std::uint8_t value) {
        const bool to_group = value >= 192;
        // From none, in one frame, to too many. A group's Request does not tell whose it is.
        const std::size_t more = value / 4 % 16;
        const std::size_t parameters = more == 0 && !to_group ? 0 : 3 + more * 4;
        core::Buffer message(giop::request_header_size + parameters);
        const RequestId id = from.next_request_id++;
        const std::uint16_t key = to_group ? std::uint16_t{0} : ObjectKey{self, 1}.value();
        giop::write_request_header(MutableBytes{message}.first<giop::request_header_size>(), id,
                                   key, peers_operation, parameters);
        if (parameters > 0) {
            message[giop::request_header_size] = from.node.value();
            write_be16(&message[giop::request_header_size + 1], id);
        }
        begin(from,
              to_group ? caniop::Identifier::to_group(group, from.node)
                       : caniop::Identifier::to_node(self, from.node),
              std::move(message));
    }

    void begin_reply(Peer& from, std::uint8_t value) {
        std::vector<RequestId> ids;
        for (const Call& made : calls_) {
            if (made.request_id) ids.push_back(*made.request_id);
        }
        if (ids.empty()) return;
        const RequestId id = ids[value / 4 % ids.size()];
        // Nobody but the one who was asked tells the right answer.
        core::Buffer body = from.node == peer ? body_for(id) : core::Buffer{0xBA, 0xD0};
        core::Buffer message(giop::reply_header_size);
        giop::write_reply_header(MutableBytes{message}.first<giop::reply_header_size>(), id,
                                 giop::ReplyStatus::no_exception, body.size());
        message.insert(message.end(), body.begin(), body.end());
        begin(from, caniop::Identifier::to_node(self, from.node), std::move(message));
    }

    void send_frames(Peer& from, std::uint8_t value) {
        for (int i = 0; i <= value / 64 && from.sent < from.message.size(); ++i) {
            from.frame.clear();
            const std::size_t room = from.frames == 0 ? 8 : 7;
            if (from.frames > 0) {
                from.frame.push_back(static_cast<std::uint8_t>(0x80 | from.frames % 128));
            }
            const std::size_t size = std::min(room, from.message.size() - from.sent);
            const Bytes octets = Bytes{from.message}.subspan(from.sent, size);
            from.frame.insert(from.frame.end(), octets.begin(), octets.end());
            from.sent += size;
            ++from.frames;
            from.frame_id = from.to.can_id();
            receive(from.frame_id, from.frame);
        }
    }

    void repeat_frame(const Peer& from) {
        if (!from.frame.empty()) receive(from.frame_id, from.frame);
    }

    /// A servant is called: with what a peer has sent, and only once.
    void note_execution(const core::IncomingRequest& request) {
        if (!trusting_ || request.operation != peers_operation) return;
        const auto* caller = std::get_if<core::RemoteCaller>(&request.answer_to);
        const Bytes parameters{request.parameters};
        require(parameters.size() >= 3 || (parameters.empty() && caller != nullptr));
        const std::uint8_t node = parameters.empty() ? caller->node.value() : parameters[0];
        const RequestId id = parameters.empty() ? caller->request_id : read_be16(&parameters[1]);
        const auto from =
            std::ranges::find_if(peers_, [&](const Peer& one) { return one.node.value() == node; });
        require(from != peers_.end());
        require(id < from->next_request_id);
        require(from->executed.insert(id).second);
        if (caller != nullptr) {
            require(!request.group && caller->node == from->node && caller->request_id == id);
        }
    }

    void hand_over() {
        while (const auto abort = engine_.next_abort()) aborted_.push_back(*abort);
        while (const auto frame = engine_.next_frame(now_)) {
            require(frame->length <= 8 && frame->id < 0x7E0);
            note_request(*frame);
            in_controller_.push_back(can::TransmitHandle{++last_frame_});
            engine_.handed_over(in_controller_.back());
        }
        require(in_controller_.size() <= 2 + aborted_.size());
    }

    /// The first frame of a Request has its id, and the operation, which tells whose it is.
    void note_request(const can::Frame& frame) {
        if (frame.data[0] != giop::type_and_flags(giop::MessageType::request)) return;
        for (Call& made : calls_) {
            if (made.operation < 0x80 || made.operation != frame.data[7]) continue;
            made.request_id = read_be16(&frame.data[giop::request_id_offset]);
        }
    }

    void finish_frame(can::TransmitOutcome outcome) {
        if (in_controller_.empty()) return;
        const can::TransmitHandle handle = in_controller_.front();
        in_controller_.pop_front();
        if (outcome == can::TransmitOutcome::sent) ++frames_sent_;
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
            if (request->group) {
                if (engine_.agent().is_member(*request->group, 1) && engine_.admit(*request, 1)) {
                    note_execution(*request);
                }
            } else if (engine_.adapter().find(request->object) == nullptr) {
                engine_.refuse(request->answer_to,
                               {SystemErrorKind::object_not_exist, Completion::no}, now_);
            } else if (value % 4 == 3) {
                note_execution(*request);
                engine_.refuse(request->answer_to, {}, now_);
            } else {
                note_execution(*request);
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
        const Counters& counters = engine_.counters();
        require(counters[Counter::frames_received] + counters[Counter::frames_not_caniop] +
                    counters[Counter::frames_of_other_groups] +
                    counters[Counter::frames_of_duplicate_node] +
                    counters[Counter::frames_for_other_nodes] ==
                frames_given_);
        require(counters[Counter::messages_received] <= counters[Counter::frames_received]);
        require(counters[Counter::frames_sent] == frames_sent_);
        require(counters[Counter::messages_sent] <= frames_sent_);
    }

    Bell servant_;
    core::Engine engine_{options()};
    TimePoint now_{1s};
    std::deque<Call> calls_;
    std::deque<can::TransmitHandle> in_controller_;
    std::deque<can::TransmitHandle> aborted_;
    std::uint64_t last_frame_ = 0;
    std::uint64_t frames_given_ = 0;
    std::uint64_t frames_sent_ = 0;
    unsigned calls_made_ = 0;
    std::array<Peer, 4> peers_{{{peer}, {NodeId{4}}, {NodeId{9}}, {NodeId{30}}}};
    bool trusting_ = true;  ///< nobody but peers_ has sent so far
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Owner owner;
    Bytes input{data, size};
    while (input.size() >= 2) {
        const std::uint8_t action = input[0];
        if (action >= 0x80) {
            owner.act(action & 0x7F, input[1]);
            input = input.subspan(2);
            continue;
        }
        if (input.size() < 3) break;
        const auto id = static_cast<std::uint32_t>(read_be16(&input[1]) & 0x7FF);
        const std::size_t length = std::min<std::size_t>(action % 16 % 9, input.size() - 3);
        owner.receive_anything(id, input.subspan(3, length));
        input = input.subspan(3 + length);
    }
    owner.finish();
    return 0;
}
