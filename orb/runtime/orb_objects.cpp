// OrbImpl: this node's objects and groups, and references.

#include <string>

#include "orb/runtime/orb_impl.hpp"

namespace canorb::runtime {
namespace {

GroupId checked(GroupId group) {
    if (!group.is_valid()) {
        throw_system_exception(cause::bad_argument,
                               "group " + std::to_string(group.value()) + " is not 1 to 31");
    }
    return group;
}

}  // namespace

std::optional<NodeId> OrbImpl::node() const {
    const Lock lock{mutex_};
    return engine_.node();
}

void OrbImpl::set_node(int node) {
    const auto id = NodeId::from(node);
    if (!id)
        throw_system_exception(cause::bad_argument,
                               "node " + std::to_string(node) + " is not 0 to 30");
    const Lock lock{mutex_};
    require_open();
    engine_.set_node(id);
    transmit(now());
}

ObjectRef OrbImpl::make_reference(core::Reference reference) {
    return ObjectRef{shared_from_this(),
                     std::make_shared<const core::Reference>(std::move(reference))};
}

void OrbImpl::set_management_object(std::unique_ptr<Servant> servant) {
    const Lock lock{mutex_};
    management_object_ = std::move(servant);
    engine_.adapter().activate_management_object(*management_object_);
}

ObjectRef OrbImpl::string_to_object(std::string_view text) {
    auto reference = core::parse_reference(text);
    if (!reference) {
        const core::ReferenceError& error = reference.error();
        throw_system_exception(error.error,
                               "'" + std::string{text} + "': " + std::string{error.why});
    }
    return make_reference(std::move(*reference));
}

std::string OrbImpl::object_to_string(const ObjectRef& reference) const {
    return core::to_string(*reference.to_);
}

ObjectRef OrbImpl::group_reference(GroupId group) {
    checked(group);
    const Lock lock{mutex_};
    const InterfaceInfo* common = engine_.agent().common_interface(group);
    return make_reference(core::Reference::to_group(
        group, common == nullptr ? std::string{} : std::string{common->repository_id}));
}

ObjectIndex OrbImpl::local_index(const ObjectRef& object) const {
    const auto index = object.index();
    if (!index || object.node() != engine_.node()) {
        throw_system_exception(cause::not_active_here,
                               "only an object of this node can be a member of a group here");
    }
    return *index;
}

void OrbImpl::join(const ObjectRef& object, GroupId group) {
    checked(group);
    const Lock lock{mutex_};
    require_open();
    const ObjectIndex index = local_index(object);
    if (index == management_object_index) {
        throw_system_exception(cause::never_a_member,
                               "the node's management object is a member of no group");
    }
    const Servant* servant = engine_.adapter().find(index);
    if (servant == nullptr) {
        throw_system_exception(cause::not_active_here, "object " + std::to_string(index) +
                                                           " is not active: activate it first");
    }
    if (!engine_.join(group, {index, &servant->_interface_info()})) {
        throw_system_exception(cause::no_common_interface,
                               std::string{servant->_interface_info().repository_id} +
                                   " has no interface in common with the members of group " +
                                   std::to_string(group.value()));
    }
    transmit(now());
}

void OrbImpl::leave(const ObjectRef& object, GroupId group) {
    checked(group);
    const Lock lock{mutex_};
    require_open();
    engine_.leave(group, local_index(object));
    transmit(now());
}

bool OrbImpl::is_member(const ObjectRef& object, GroupId group) const {
    checked(group);
    const Lock lock{mutex_};
    return engine_.agent().is_member(group, local_index(object));
}

std::vector<ObjectRef> OrbImpl::members(GroupId group) {
    checked(group);
    const Lock lock{mutex_};
    std::vector<ObjectRef> references;
    for (const mca::Member& member : engine_.agent().members(group)) {
        references.push_back(make_reference(
            core::Reference::to_object(ObjectKey{*engine_.node(), member.index},
                                       std::string{member.interface->repository_id})));
    }
    return references;
}

}  // namespace canorb::runtime
