#pragma once

#include <cstdint>
#include <utility>

#include "orb/base/bytes.hpp"
#include "orb/base/ids.hpp"
#include "orb/base/interface_info.hpp"
#include "orb/base/minor_codes.hpp"
#include "orb/base/system_error.hpp"
#include "orb/ccdr/decoder.hpp"
#include "orb/ccdr/encoder.hpp"

namespace canorb::poa {

/// Octets that are CCDR already: reply(RawOctets{...}) sends them as they are.
struct RawOctets {
    Bytes octets;
};
inline void encode(ccdr::Encoder& out, const RawOctets& value) {
    out.octets(value.octets);
}

/// One Request on its way through a skeleton: the parameters to read, and the answer.
///
/// A skeleton calls read() once with all in and inout parameters, then one of reply(), raise() or
/// fail(). A call for which it does none of these answers BAD_OPERATION.
class ServerCall {
  public:
    enum class Outcome : std::uint8_t { none, no_exception, user_exception, system_exception };

    /// `parameters` and `reply_buffer` belong to the caller and outlive this object.
    ServerCall(OperationId operation, ccdr::Decoder parameters, MutableBytes reply_buffer)
        : operation_(operation), in_(parameters), reply_buffer_(reply_buffer), out_(reply_buffer) {}

    OperationId operation() const { return operation_; }

    /// Reads all in and inout parameters. False: they do not decode, or octets are left over; the
    /// answer MARSHAL is then in place and the skeleton returns.
    template <typename... T>
    [[nodiscard]] bool read(T&&... parameters) {
        was_read_ = true;
        (decode(in_, parameters), ...);
        if (in_.finished()) return true;
        fail(cause::bad_parameters);
        return false;
    }

    /// Says that the operation is declared `oneway`: whatever follows is not sent.
    void oneway() { oneway_ = true; }

    /// Answers with the return value, then the inout and out parameters.
    template <typename... T>
    void reply(const T&... results) {
        begin(Outcome::no_exception);
        (encode(out_, results), ...);
        end();
    }

    /// Answers with an exception that the operation declares.
    template <typename E>
    void raise(const E& exception) {
        begin(Outcome::user_exception);
        out_.string(E::repository_id);
        encode(out_, exception);
        end();
    }

    /// Answers with a system exception.
    void fail(const SystemError& error);

    bool is_oneway() const { return oneway_; }
    /// Whether anybody looked at the parameters, even where there are none.
    bool was_read() const { return was_read_; }
    Outcome outcome() const { return outcome_; }
    /// The reply's body; empty where outcome() is system_exception.
    Bytes body() const { return out_.octets(); }
    const SystemError& system_error() const { return error_; }

    /// The parameters as octets, for what reads them without generated code. They stay valid
    /// until the call is answered.
    Bytes remaining_parameters() {
        was_read_ = true;
        return in_.octets(in_.remaining());
    }

  private:
    void begin(Outcome outcome);
    void end();

    OperationId operation_;
    bool oneway_ = false;
    bool was_read_ = false;
    Outcome outcome_ = Outcome::none;
    ccdr::Decoder in_;
    MutableBytes reply_buffer_;
    ccdr::Encoder out_;
    SystemError error_{};
};

class Servant;

/// Calls a servant: answers the ORB's own operations (_is_a and its kin) itself, hands all others
/// to _dispatch(), and answers BAD_OPERATION for what nobody answered.
void dispatch(Servant& servant, ServerCall& call);

/// What an object adapter can call: every generated XServant, and raw servants.
///
/// The names begin with an underscore because IDL identifiers cannot: no operation collides.
class Servant {
  public:
    virtual ~Servant() = default;

    /// The most derived interface. The constant outlives the servant.
    virtual const InterfaceInfo& _interface_info() const = 0;

    /// Executes one call. An exception that leaves it becomes the answer: a system exception as
    /// itself, anything else as UNKNOWN.
    virtual void _dispatch(ServerCall& call) = 0;
};

}  // namespace canorb::poa
