#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "orb/base/ids.hpp"
#include "orb/base/system_error.hpp"
#include "orb/base/time.hpp"
#include "orb/caniop/transmit_queue.hpp"
#include "orb/core/buffer_pool.hpp"
#include "orb/giop/message.hpp"

namespace canorb::core {

/// Names one two-way call of one ORB; never used twice.
enum class CallHandle : std::uint64_t {};

/// The end of a call that was answered: NO_EXCEPTION or USER_EXCEPTION, and the Reply's body.
struct CallAnswer {
    giop::ReplyStatus status = giop::ReplyStatus::no_exception;
    Buffer body;
};

using CallResult = std::variant<CallAnswer, SystemError>;

/// The two-way calls that wait for their end, and those ended whose caller has not yet looked.
///
/// Invariants:
///  * request ids of calls on the bus are unique among those that wait;
///  * a call ends once: what comes later finds it no more;
///  * behind the first `used_` places all are free, so that few calls are few to look at.
class OutstandingCalls {
  public:
    explicit OutstandingCalls(std::size_t capacity) : calls_(capacity) {}

    struct Call {
        CallHandle handle{};
        enum class State : std::uint8_t { free, waiting, ended } state = State::free;
        RequestId request_id = 0;
        std::optional<NodeId> peer;  ///< nothing: an object of this ORB
        TimePoint deadline{};
        std::optional<caniop::MessageHandle> message;  ///< while the Request is in the queue
        bool begun = false;                            ///< local: handed to the servant
        CallResult result{};
    };

    /// Nothing when as many calls as allowed are outstanding.
    [[nodiscard]] Call* open(TimePoint deadline);
    bool has_request_id(RequestId id) const;

    Call* find(CallHandle handle);
    Call* find_waiting(CallHandle handle);
    Call* find_waiting(NodeId peer, RequestId id);
    Call* find_waiting(caniop::MessageHandle message);

    void end(Call& call, CallResult result);
    /// Forgets a call that could not even be begun.
    void discard(Call& call);
    /// Takes the result of an ended call and forgets it; nothing while it waits. A call that is
    /// unknown is INTERNAL.
    std::optional<CallResult> take(CallHandle handle);

    /// Calls `action(call)` for each call that waits.
    template <typename Action>
    void for_each_waiting(Action action) {
        for (Call& call : used()) {
            if (call.state == Call::State::waiting) action(call);
        }
    }

    /// The earliest deadline of those that wait; never: none.
    TimePoint next_deadline() const;

  private:
    std::span<Call> used() { return {calls_.data(), used_}; }
    std::span<const Call> used() const { return {calls_.data(), used_}; }

    std::vector<Call> calls_;
    std::size_t used_ = 0;
    std::uint64_t last_handle_ = 0;
};

}  // namespace canorb::core
