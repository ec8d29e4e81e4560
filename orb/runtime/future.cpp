#include "canorb/future.hpp"

#include <utility>

#include "orb/base/minor_codes.hpp"
#include "orb/runtime/orb_impl.hpp"

namespace canorb {

PendingReply::PendingReply(PendingReply&& other) noexcept
    : orb_(std::exchange(other.orb_, nullptr)),
      to_(std::exchange(other.to_, nullptr)),
      operation_(other.operation_),
      call_(other.call_) {}

PendingReply& PendingReply::operator=(PendingReply&& other) noexcept {
    PendingReply old{std::move(*this)};  // cancels what this was of
    orb_ = std::exchange(other.orb_, nullptr);
    to_ = std::exchange(other.to_, nullptr);
    operation_ = other.operation_;
    call_ = other.call_;
    return *this;
}

void PendingReply::require_valid() const {
    if (!valid()) throw_system_exception(cause::future_without_call);
}

bool PendingReply::ready() const {
    require_valid();
    return call_ == core::CallHandle{} || orb_->has_ended(call_);
}

bool PendingReply::wait_for(Duration duration) const {
    require_valid();
    const auto orb = orb_;  // code that runs meanwhile may cancel the call
    return call_ == core::CallHandle{} || orb->wait_for_end(call_, duration);
}

void PendingReply::cancel() {
    const auto orb = std::exchange(orb_, nullptr);
    to_ = nullptr;
    if (orb && call_ != core::CallHandle{}) orb->cancel_call(call_);
}

void PendingReply::fetch(CallReply& reply) {
    const auto orb = orb_;
    const core::CallHandle call = call_;
    // It is of the call while it waits, so that cancel() ends the wait; then of none, whatever
    // came, unless user code has made it one of another call.
    struct Forget {
        PendingReply& pending;
        core::CallHandle call;
        ~Forget() {
            if (pending.call_ == call) pending.orb_ = nullptr;
        }
    } const forget{*this, call};
    if (call != core::CallHandle{}) reply.accept(orb->finish_call(call));
}

PendingCall PendingReply::when_ended(std::function<void()> callback) const {
    require_valid();
    const auto orb = orb_;  // another thread may run the callback, which is what holds this
    return {orb, orb->when_ended(call_, std::move(callback))};
}

void PendingCall::cancel() const {
    if (const auto orb = orb_.lock()) orb->cancel_callback(callback_);
}

}  // namespace canorb
