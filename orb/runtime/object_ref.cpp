#include "canorb/object_ref.hpp"

#include "canorb/stub.hpp"
#include "orb/core/reference.hpp"
#include "orb/runtime/orb_impl.hpp"

namespace canorb {
namespace {

const std::shared_ptr<const core::Reference>& nil() {
    static const auto reference = std::make_shared<const core::Reference>();
    return reference;
}

constexpr InterfaceInfo object_interface{corba_object_id};
constexpr OperationInfo is_a_info{&object_interface, is_a_operation, "_is_a"};
constexpr OperationInfo non_existent_info{&object_interface, non_existent_operation,
                                          "_non_existent"};
constexpr OperationInfo interface_info{&object_interface, interface_operation, "_interface"};

}  // namespace

std::shared_ptr<const ccdr::DecodeContext> runtime::ReferenceOwner::shared() const {
    return {orb.shared_from_this(), this};
}

ObjectRef::ObjectRef() : to_(nil()) {}

ObjectRef::ObjectRef(std::shared_ptr<runtime::OrbImpl> orb,
                     std::shared_ptr<const core::Reference> to)
    : orb_(std::move(orb)), to_(std::move(to)) {}

bool ObjectRef::is_nil() const {
    return to_->kind == core::Reference::Kind::nil;
}

bool ObjectRef::is_group() const {
    return to_->kind == core::Reference::Kind::group;
}

std::optional<NodeId> ObjectRef::node() const {
    if (to_->kind != core::Reference::Kind::object) return std::nullopt;
    return to_->key.node();
}

std::optional<ObjectIndex> ObjectRef::index() const {
    if (to_->kind != core::Reference::Kind::object) return std::nullopt;
    return to_->key.index();
}

std::optional<GroupId> ObjectRef::group() const {
    if (!is_group()) return std::nullopt;
    return to_->group;
}

std::string_view ObjectRef::type_id() const {
    return to_->type_id;
}

ObjectRef ObjectRef::with_timeout(Duration timeout) const {
    if (timeout <= Duration::zero())
        throw_system_exception(cause::bad_argument, "a timeout must be greater than 0");
    ObjectRef copy{*this};
    copy.timeout_ = timeout;
    return copy;
}

ObjectRef ObjectRef::with_sent(SentCallback callback) const {
    ObjectRef copy{*this};
    copy.sent_ = std::move(callback);
    return copy;
}

bool ObjectRef::is_a_for_narrow(const InterfaceInfo& wanted) const {
    if (is_nil()) return false;
    if (type_id() == wanted.repository_id) return true;
    return is_group() ? type_id().empty() : _is_a(wanted.repository_id);
}

bool ObjectRef::_is_a(std::string_view repository_id) const {
    ClientCall call{*this, is_a_info};
    call.write(repository_id);
    call.invoke();
    bool result{};
    call.read(result);
    return result;
}

bool ObjectRef::_non_existent() const {
    ClientCall call{*this, non_existent_info};
    call.write();
    try {
        call.invoke();
    } catch (const OBJECT_NOT_EXIST&) {
        return true;
    }
    bool result{};
    call.read(result);
    return result;
}

std::string ObjectRef::_interface_id() const {
    ClientCall call{*this, interface_info};
    call.write();
    call.invoke();
    std::string result;
    call.read(result);
    return result;
}

std::vector<std::uint8_t> ObjectRef::invoke(OperationId operation, Bytes parameters) const {
    const InterfaceInfo any{type_id()};
    const OperationInfo info{&any, operation, "invoke", false, true};
    ClientCall call{*this, info};
    call.write(poa::RawOctets{parameters});
    call.invoke();
    const Bytes body = call.reply_.octets();
    return {body.begin(), body.end()};
}

InvokeResult ObjectRef::invoke(const OperationInfo& operation, Bytes parameters) const {
    ClientCall call{*this, operation};
    call.write(poa::RawOctets{parameters});
    call.perform();
    InvokeResult result;
    result.exception_id = call.reply_.exception_id();
    if (result.exception_id.empty()) call.reply_.raise();  // one whose id is empty: UNKNOWN
    const Bytes body = call.reply_.octets();
    result.body.assign(body.begin(), body.end());
    return result;
}

bool operator==(const ObjectRef& a, const ObjectRef& b) {
    return a.to_->same_target(*b.to_);
}

void encode(ccdr::Encoder& out, const ObjectRef& value) {
    core::encode(out, *value.to_);
    if (value.orb_) out.belongs_to(value.orb_->decode_context());
}

void decode(ccdr::Decoder& in, ObjectRef& value) {
    core::Reference reference;
    core::decode(in, reference);
    if (!in.ok()) return;
    value = ObjectRef{};
    if (reference.kind == core::Reference::Kind::nil && reference.type_id.empty()) return;
    value.to_ = std::make_shared<const core::Reference>(std::move(reference));
    if (const auto* owner = static_cast<const runtime::ReferenceOwner*>(in.context())) {
        value.orb_ = owner->orb.shared_from_this();
    }
}

}  // namespace canorb
