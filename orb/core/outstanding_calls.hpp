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

/// The two-way calls that wait for their end, those ended whose caller has not yet looked, and
/// those cancelled whose Reply may still come.
///
/// Invariants:
///  * request ids of calls on the bus are unique among those that wait and those cancelled;
///  * a call ends once, or is cancelled: what comes later finds it no more;
///  * a cancelled call keeps its place, and with it its request id, until its Reply has come or its
///    deadline has passed; no caller sees it any more;
///  * a watched call that has ended is told once, in the order of the ends;
///  * behind the first `used_` places all are free, so that few calls are few to look at.
class OutstandingCalls {
  public:
    explicit OutstandingCalls(std::size_t capacity) : calls_(capacity) {}

    struct Call {
        CallHandle handle{};
        enum class State : std::uint8_t { free, waiting, ended, cancelled } state = State::free;
        RequestId request_id = 0;
        std::optional<NodeId> peer;  ///< nothing: an object of this ORB
        TimePoint deadline{};
        std::optional<caniop::MessageHandle> message;  ///< while the Request is in the queue
        bool begun = false;                            ///< local: handed to the servant
        bool watched = false;                          ///< next_watched() is to tell its end
        std::uint64_t end_number = 0;                  ///< counts the ends
        CallResult result{};
    };

    /// Nothing when as many calls as allowed are outstanding.
    [[nodiscard]] Call* open(TimePoint deadline);
    bool has_request_id(RequestId id) const;

    /// One that waits or has ended.
    Call* find(CallHandle handle);
    Call* find_waiting(CallHandle handle);
    Call* find_waiting(NodeId peer, RequestId id);
    Call* find_waiting(caniop::MessageHandle message);

    void end(Call& call, CallResult result);
    /// Forgets a call that could not even be begun, or that nobody will answer.
    void discard(Call& call);
    /// Nobody wants the answer to a call that waits, but it may come.
    void cancel(Call& call) { call.state = Call::State::cancelled; }
    /// The Reply to a cancelled call has come: the call is forgotten. False: there is no such call.
    bool drop_cancelled(NodeId peer, RequestId id);
    bool drop_cancelled(CallHandle handle);
    /// Forgets the cancelled calls whose deadline has come.
    void expire_cancelled(TimePoint now);

    /// The watched call that ended first and was not told yet.
    std::optional<CallHandle> next_watched();
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

    /// Whether somebody waits for the end of a call; nobody does of a cancelled one.
    bool any_waiting() const;
    /// The earliest deadline of those that wait or are cancelled; never: none.
    TimePoint next_deadline() const;

  private:
    template <typename Belongs>
    bool drop_cancelled_if(Belongs belongs);

    std::span<Call> used() { return {calls_.data(), used_}; }
    std::span<const Call> used() const { return {calls_.data(), used_}; }

    std::vector<Call> calls_;
    std::size_t used_ = 0;
    std::uint64_t last_handle_ = 0;
    std::uint64_t ends_ = 0;
};

}  // namespace canorb::core
