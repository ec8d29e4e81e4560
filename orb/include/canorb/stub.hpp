#pragma once

/// What generated stubs are made of. Applications include <canorb/orb.hpp> and their generated
/// headers instead.

#include <string_view>
#include <vector>

#include "canorb/object_ref.hpp"

namespace canorb {

/// One call, from the client's side: write the parameters, invoke, read the results.
///
///     canorb::ClientCall call{*this, Motor_speed};
///     call.write(channel);
///     call.invoke();
///     float result{};
///     call.read(result);
///     return result;
///
/// On a group, and for a oneway operation, invoke() returns once the message is queued, and read()
/// with no arguments does nothing.
class ClientCall {
  public:
    /// Throws INV_OBJREF for a nil target, BAD_OPERATION for a group and an operation that cannot
    /// be sent to one.
    ClientCall(const ObjectRef& target, const OperationInfo& operation);
    ~ClientCall();
    ClientCall(const ClientCall&) = delete;
    ClientCall& operator=(const ClientCall&) = delete;

    /// All in and inout parameters, in declaration order. Throws BAD_PARAM for a value that
    /// cannot be sent, IMP_LIMIT when the message is too long.
    template <typename... T>
    void write(const T&... parameters) {
        (encode(out_, parameters), ...);
        check_written();
    }

    /// Performs the call. Throws the exceptions E that the operation declares, and every system
    /// exception.
    template <typename... E>
    void invoke() {
        if (perform()) return;
        static_cast<void>((raise_if<E>() || ...));
        raise_unknown_user_exception();
    }

    /// The return value, then inout and out parameters. Throws MARSHAL when they do not decode or
    /// octets are left over.
    template <typename... T>
    void read(T&&... results) {
        if (!has_reply_) return;
        (decode(in_, results), ...);
        check_read();
    }

  private:
    friend class ObjectRef;

    /// True: a normal end. False: a user exception waits in in_, its id in exception_id_.
    bool perform();
    void check_written() const;
    void check_read() const;
    [[noreturn]] void raise_unknown_user_exception() const;

    template <typename E>
    bool raise_if() {
        if (exception_id_ != E::repository_id) return false;
        E exception;
        decode(in_, exception);
        check_read();
        throw exception;
    }

    const ObjectRef& target_;
    const OperationInfo& operation_;
    std::vector<std::uint8_t> request_;
    std::vector<std::uint8_t> reply_;
    ccdr::Encoder out_;
    ccdr::Decoder in_;
    bool has_reply_ = false;
    std::string_view exception_id_;
};

}  // namespace canorb
