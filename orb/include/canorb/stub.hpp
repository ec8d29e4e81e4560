#pragma once

/// What generated stubs are made of. Applications include <canorb/orb.hpp> and their generated
/// headers instead.

#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

#include "canorb/future.hpp"
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
        perform();
        reply_.raise<E...>();
    }

    /// Begins the call, and leaves its end to somebody else. Throws what is known at once.
    PendingReply send();

    /// The return value, then inout and out parameters. Throws MARSHAL when they do not decode or
    /// octets are left over.
    template <typename... T>
    void read(T&&... results) {
        reply_.read(std::forward<T>(results)...);
    }

  private:
    friend class ObjectRef;

    void perform();
    MutableBytes message();
    /// To a group, or oneway: true, and it is queued.
    bool send_unanswered();
    void fail(const SystemError& error) const;
    void check_written() const;

    const ObjectRef& target_;
    const OperationInfo& operation_;
    std::vector<std::uint8_t> request_;
    ccdr::Encoder out_;
    CallReply reply_;
};

/// The exceptions that an operation declares.
template <typename... E>
struct Raises {};

/// What a call gives besides exceptions: its return value, then inout and out parameters. Each of
/// `Coded` is the type of one, or ccdr::Bounded of it where the codec needs its bounds. One is
/// given as it is, several as a std::tuple.
template <typename... Coded>
struct Returns;

template <typename Coded>
struct ReturnedValue {
    using Type = Coded;
    static Type& coded(Type& value) { return value; }
};
template <typename T, std::size_t... Bounds>
struct ReturnedValue<ccdr::Bounded<T, Bounds...>> {
    using Type = T;
    static ccdr::Bounded<T, Bounds...> coded(T& value) { return {value}; }
};

template <>
struct Returns<> {
    using Type = void;
    static void read(CallReply& reply) { reply.read(); }
};
template <typename Coded>
struct Returns<Coded> {
    using Type = typename ReturnedValue<Coded>::Type;
    static Type read(CallReply& reply) {
        Type result{};
        reply.read(ReturnedValue<Coded>::coded(result));
        return result;
    }
};
template <typename... Coded>
    requires(sizeof...(Coded) > 1)
struct Returns<Coded...> {
    using Type = std::tuple<typename ReturnedValue<Coded>::Type...>;
    static Type read(CallReply& reply) {
        Type results{};
        std::apply([&](auto&... result) { reply.read(ReturnedValue<Coded>::coded(result)...); },
                   results);
        return results;
    }
};

/// How a Future reads its Reply.
template <typename Returned, typename Raised>
struct ReplyReader;
template <typename Returned, typename... E>
struct ReplyReader<Returned, Raises<E...>> {
    static typename Returned::Type read(CallReply& reply) {
        reply.raise<E...>();
        return Returned::read(reply);
    }
};

/// Begins a call with these in and inout parameters: the whole of a stub's sendp_ function.
template <typename Returned, typename Raised = Raises<>, typename... T>
Future<typename Returned::Type> send_request(const ObjectRef& target,
                                             const OperationInfo& operation,
                                             const T&... parameters) {
    ClientCall call{target, operation};
    call.write(parameters...);
    return Future<typename Returned::Type>{call.send(), ReplyReader<Returned, Raised>::read};
}

}  // namespace canorb
