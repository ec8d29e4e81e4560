#pragma once

/// References to objects and to groups of objects. Client code is the same for both.
///
///     auto motor = orb.string_to_object("corbaloc:caniop:3/1").narrow<Devices::Motor>();
///     motor.start();
///     motor.with_timeout(20ms).speed(1);
///     auto all = orb.string_to_object("corbaloc:caniop:group/5").narrow<Devices::Motor>();
///     all.stop();                                              // one multicast, every member

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "canorb/types.hpp"

namespace canorb {

namespace core {
struct Reference;
}
namespace runtime {
class OrbImpl;
}

/// Called from the ORB's event loop when the controller has confirmed the last frame of a call.
/// It is not called when the call's message was withdrawn or failed.
using SentCallback = std::function<void()>;

/// How a call without generated code ended.
struct InvokeResult {
    /// The repository id of the user exception that the operation raised; empty: it raised none.
    std::string exception_id{};
    /// In CCDR: the result, then inout and out parameters; of a user exception its members. Empty
    /// for a group and for a oneway operation.
    std::vector<std::uint8_t> body{};
};

/// A reference to an object, or to a group, or to nothing (nil). A value: copying it is cheap, and
/// copies may be used from several threads. Generated stub classes derive from it.
///
/// It may outlive its Orb; a call through it then throws BAD_INV_ORDER.
class ObjectRef {
  public:
    /// Nil: calls through it throw INV_OBJREF.
    ObjectRef();
    ObjectRef(const ObjectRef&) = default;
    ObjectRef& operator=(const ObjectRef&) = default;
    ~ObjectRef() = default;

    bool is_nil() const;
    bool is_group() const;

    /// The node, where it refers to an object.
    std::optional<NodeId> node() const;
    /// The object's index, where it refers to an object.
    std::optional<ObjectIndex> index() const;
    /// The group, where it refers to one.
    std::optional<GroupId> group() const;
    /// The repository id it carries: of the most derived interface when it was made, or empty
    /// where nobody knew (corbaloc).
    std::string_view type_id() const;

    /// A copy whose two-way calls end after `timeout` from the call, with TIMEOUT, and whose
    /// oneway and group calls are withdrawn then if they were still queued.
    ObjectRef with_timeout(Duration timeout) const;
    /// A copy that calls `callback` whenever a call through it is on the bus, whole.
    ObjectRef with_sent(SentCallback callback) const;

    /// The typed stub, or a nil one where this is not a T. An object whose type is not known to
    /// match is asked (_is_a), which can throw what any call throws; a group's type_id is trusted,
    /// and an empty one matches.
    template <typename Stub>
    Stub narrow() const {
        return is_a_for_narrow(Stub::_interface) ? Stub{*this} : Stub{};
    }
    /// The typed stub, nothing asked. A wrong guess shows as BAD_OPERATION or MARSHAL.
    template <typename Stub>
    Stub unchecked_narrow() const {
        return Stub{*this};
    }

    /// Asks the object whether it is, or inherits, the interface. Not for groups (BAD_OPERATION).
    bool _is_a(std::string_view repository_id) const;
    /// Asks whether the object is gone. False for one that answers anything at all but
    /// OBJECT_NOT_EXIST.
    bool _non_existent() const;
    /// Asks the object for the repository id of its most derived interface.
    std::string _interface_id() const;

    /// A call without generated code: `parameters` are the in and inout parameters in CCDR; the
    /// result is the Reply's body in CCDR, empty for a group. A user exception is thrown as
    /// UNKNOWN.
    std::vector<std::uint8_t> invoke(OperationId operation, Bytes parameters) const;
    /// The same for who knows the operation as generated code does: a oneway one returns once its
    /// message is queued, a group checks the interface that declares it, and one that cannot be
    /// sent to a group is BAD_OPERATION there. A user exception is a result; system exceptions are
    /// thrown.
    InvokeResult invoke(const OperationInfo& operation, Bytes parameters) const;

    /// Same object or group; types, timeouts and callbacks do not count.
    friend bool operator==(const ObjectRef& a, const ObjectRef& b);

  protected:
    friend class ClientCall;
    friend class runtime::OrbImpl;
    friend void encode(ccdr::Encoder& out, const ObjectRef& value);
    friend void decode(ccdr::Decoder& in, ObjectRef& value);

    ObjectRef(std::shared_ptr<runtime::OrbImpl> orb, std::shared_ptr<const core::Reference> to);

    bool is_a_for_narrow(const InterfaceInfo& wanted) const;

  private:
    std::shared_ptr<runtime::OrbImpl> orb_;
    std::shared_ptr<const core::Reference> to_;
    Duration timeout_{0};  ///< 0: the ORB's default
    SentCallback sent_;
};

/// As doc/wire/giop.md, "Object references". A decoded reference belongs to the ORB of the call.
void encode(ccdr::Encoder& out, const ObjectRef& value);
void decode(ccdr::Decoder& in, ObjectRef& value);

/// Of the interface that all others inherit. A stub has its own.
constexpr std::string_view type_code_of(const ObjectRef*) {
    return {"\x0E\x1DIDL:omg.org/CORBA/Object:1.0\0\x01\0", 33};
}

/// "nil", "group 5" or "node 3 object 1", with the repository id behind where it is known.
template <OutputStream Stream>
Stream& operator<<(Stream& out, const ObjectRef& value) {
    if (value.is_nil()) {
        out << "nil";
        return out;
    }
    if (value.is_group()) {
        out << "group " << int{value.group()->value()};
    } else {
        out << "node " << int{value.node()->value()} << " object " << *value.index();
    }
    if (!value.type_id().empty()) out << ' ' << value.type_id();
    return out;
}

}  // namespace canorb
