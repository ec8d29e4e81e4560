#pragma once

/// What Futures and stubs are made of: a call begun, and its Reply. Applications use
/// <canorb/future.hpp> instead.

#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>
#include <variant>
#include <vector>

#include "canorb/types.hpp"

namespace canorb {

namespace core {
enum class CallHandle : std::uint64_t;
struct CallAnswer;
struct Reference;
using CallResult = std::variant<CallAnswer, SystemError>;
}  // namespace core
namespace runtime {
class OrbImpl;
enum class CallbackId : std::uint64_t;
}  // namespace runtime

/// A Reply as stubs read it: raise(), then read().
class CallReply {
  public:
    /// None so far, and none at all for a oneway or group call: raise() and read() do nothing. The
    /// arguments outlive it.
    CallReply(runtime::OrbImpl* orb, const core::Reference& to, const OperationInfo& operation)
        : orb_(orb), to_(to), operation_(operation), in_(Bytes{}) {}
    ~CallReply();
    CallReply(const CallReply&) = delete;
    CallReply& operator=(const CallReply&) = delete;

    /// Throws a system exception, and MARSHAL for a user exception without an id.
    void accept(core::CallResult result);

    /// Where it is a user exception: throws it as one of E, or as UNKNOWN.
    template <typename... E>
    void raise() {
        if (!is_user_exception_) return;
        static_cast<void>((raise_if<E>() || ...));
        raise_unknown();
    }

    /// The return value, then inout and out parameters. Throws MARSHAL when they do not decode or
    /// octets are left over.
    template <typename... T>
    void read(T&&... results) {
        if (!has_reply_) return;
        (decode(in_, results), ...);
        check_read();
    }

    /// The repository id of a user exception; empty where it is none.
    std::string_view exception_id() const { return exception_id_; }
    /// The return value and all parameters, or a user exception's members, as octets.
    Bytes octets() { return in_.octets(in_.remaining()); }

  private:
    void check_read() const;
    [[noreturn]] void raise_unknown() const;

    template <typename E>
    bool raise_if() {
        if (exception_id_ != E::repository_id) return false;
        E exception;
        decode(in_, exception);
        check_read();
        throw exception;
    }

    runtime::OrbImpl* orb_;
    const core::Reference& to_;
    const OperationInfo& operation_;
    std::vector<std::uint8_t> body_;
    ccdr::Decoder in_;
    bool has_reply_ = false;
    bool is_user_exception_ = false;
    std::string_view exception_id_;
};

/// A call with a callback: a handle to cancel it. A value; copies are of the same call. Any thread.
class PendingCall {
  public:
    /// Of no call.
    PendingCall() = default;
    PendingCall(std::weak_ptr<runtime::OrbImpl> orb, runtime::CallbackId callback)
        : orb_(std::move(orb)), callback_(callback) {}

    /// The callback will not be called, and the call is cancelled as by Future::cancel(). Where
    /// another thread runs the event loop, the callback may have begun, and runs on. No effect when
    /// it has been called.
    void cancel() const;

  private:
    std::weak_ptr<runtime::OrbImpl> orb_;
    runtime::CallbackId callback_{};
};

/// A call begun whose end is still to be fetched: what Futures of all types have in common. Like
/// those it is for one thread at a time.
class PendingReply {
  public:
    /// Of no call.
    PendingReply() = default;
    /// `call` 0: to a group, nothing will come. `operation` outlives it.
    PendingReply(std::shared_ptr<runtime::OrbImpl> orb, std::shared_ptr<const core::Reference> to,
                 const OperationInfo& operation, core::CallHandle call)
        : orb_(std::move(orb)), to_(std::move(to)), operation_(&operation), call_(call) {}
    PendingReply(PendingReply&& other) noexcept;
    PendingReply& operator=(PendingReply&& other) noexcept;
    PendingReply(const PendingReply&) = delete;
    PendingReply& operator=(const PendingReply&) = delete;
    ~PendingReply() { cancel(); }

    bool valid() const { return orb_ != nullptr; }
    bool ready() const;
    bool wait_for(Duration duration) const;
    void cancel();

    /// Waits for the end and gives `read(reply)`; it is of no call from then on.
    template <typename R>
    R get(R (*read)(CallReply&)) {
        require_valid();
        // Kept here: code that runs meanwhile may cancel the call.
        const auto orb = orb_;
        const auto to = to_;
        CallReply reply{orb.get(), *to, *operation_};
        fetch(reply);
        return read(reply);
    }

    /// The event loop is to run `callback`, once, when the call has ended. Throws BAD_INV_ORDER.
    PendingCall when_ended(std::function<void()> callback) const;

  private:
    void require_valid() const;
    void fetch(CallReply& reply);

    std::shared_ptr<runtime::OrbImpl> orb_;
    std::shared_ptr<const core::Reference> to_;
    const OperationInfo* operation_ = nullptr;
    core::CallHandle call_{};
};

}  // namespace canorb
