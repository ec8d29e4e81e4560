#include "canorb/poa.hpp"

#include <algorithm>
#include <string>

#include "orb/runtime/orb_impl.hpp"

namespace canorb {

using runtime::OrbImpl;

namespace {

[[noreturn]] void throw_activation_error(poa::ActivationError error, ObjectId id) {
    switch (error) {
        case poa::ActivationError::object_already_active:
            throw ObjectAlreadyActive{};
        case poa::ActivationError::servant_already_active:
            throw ServantAlreadyActive{};
        case poa::ActivationError::index_out_of_range:
            throw_system_exception(cause::bad_argument,
                                   "object index " + std::to_string(id) + " is not 1 to 1023");
        case poa::ActivationError::not_from_this_poa:
            throw_system_exception(
                cause::bad_argument,
                "object index " + std::to_string(id) +
                    " was not given out by this POA, whose ids are the system's");
        case poa::ActivationError::wrong_policy:
            throw WrongPolicy{};
        case poa::ActivationError::exhausted:
            break;
    }
    throw_system_exception(cause::object_indices_used_up,
                           "all object indices from 1024 to 2047 have been given out");
}

}  // namespace

// ---- for both: Poa and PoaManager reach into the ORB, whose outer parts they are

namespace runtime {

PoaManager& OrbImpl::make_manager(poa::ManagerId id) {
    managers_.push_back(std::unique_ptr<PoaManager>{new PoaManager{*this, id}});
    return *managers_.back();
}

Poa& OrbImpl::make_poa(poa::PoaId id, PoaManager& manager) {
    poas_.push_back(std::unique_ptr<Poa>{new Poa{*this, id, manager}});
    return *poas_.back();
}

void OrbImpl::require_no_user_code(std::string_view what) const {
    if (!user_code_.is_here()) return;
    throw_system_exception(
        cause::would_wait_for_itself,
        std::string{what} + " in a servant or callback of the same Orb would wait for itself");
}

poa::ObjectAdapter& OrbImpl::adapter_with(poa::PoaId id) {
    require_open();
    if (!engine_.adapter().exists(id)) {
        throw_system_exception(cause::poa_destroyed, "POA '" + engine_.adapter().name(id) + "'");
    }
    return engine_.adapter();
}

Servant& OrbImpl::servant_of(poa::PoaId poa, ObjectIndex index) {
    const poa::ObjectAdapter& adapter = adapter_with(poa);
    Servant* servant = adapter.find(index);
    if (servant == nullptr || adapter.poa_of(index) != poa) throw ObjectNotActive{};
    return *servant;
}

ObjectRef OrbImpl::reference_to(ObjectIndex index, std::string_view repository_id) {
    require_node();
    return make_reference(
        core::Reference::to_object(ObjectKey{*engine_.node(), index}, std::string{repository_id}));
}

void OrbImpl::change_manager(poa::ManagerId id, PoaManagerState state, bool wait,
                             std::string_view what) {
    Lock lock{mutex_};
    require_open();
    if (wait) require_no_user_code(what);
    if (!engine_.set_manager_state(id, state)) throw AdapterInactive{};
    wake();  // what was held goes on
    if (!wait) return;
    wait_for_completion(lock, [this, id](const ServantCall& call) {
        return call.poa && engine_.adapter().manager(*call.poa) == id;
    });
}

}  // namespace runtime

// ---- managers

void PoaManager::activate() {
    orb_.change_manager(id_, PoaManagerState::active, false, "activate()");
}

void PoaManager::hold_requests(bool wait_for_completion) {
    orb_.change_manager(id_, PoaManagerState::holding, wait_for_completion, "hold_requests(true)");
}

void PoaManager::discard_requests(bool wait_for_completion) {
    orb_.change_manager(id_, PoaManagerState::discarding, wait_for_completion,
                        "discard_requests(true)");
}

void PoaManager::deactivate(bool wait_for_completion) {
    orb_.change_manager(id_, PoaManagerState::inactive, wait_for_completion, "deactivate(true)");
}

PoaManagerState PoaManager::get_state() const {
    const OrbImpl::Lock lock{orb_.mutex_};
    return orb_.engine_.adapter().state(id_);
}

// ---- the tree

Poa& Poa::create_POA(std::string_view name, PoaManager* manager, const PoaPolicies& policies) {
    const OrbImpl::Lock lock{orb_.mutex_};
    poa::ObjectAdapter& adapter = orb_.adapter_with(id_);
    if (manager != nullptr && &manager->orb_ != &orb_) {
        throw_system_exception(cause::bad_argument, "create_POA: the manager is another Orb's");
    }
    const auto shared = manager == nullptr ? std::nullopt : std::optional{manager->id_};
    const auto created = adapter.create(id_, name, shared, policies);
    if (!created) {
        switch (created.error()) {
            case poa::CreationError::already_exists:
                throw AdapterAlreadyExists{};
            case poa::CreationError::invalid_policy:
                throw InvalidPolicy{0,
                                    "PERSISTENT needs USER_ID: the system's ids are other "
                                    "objects after a restart"};
            case poa::CreationError::manager_inactive:
                throw AdapterInactive{};
        }
    }
    if (manager == nullptr) manager = &orb_.make_manager(adapter.manager(*created));
    return orb_.make_poa(*created, *manager);
}

Poa& Poa::find_POA(std::string_view name) {
    const OrbImpl::Lock lock{orb_.mutex_};
    const auto child = orb_.adapter_with(id_).find_child(id_, name);
    if (!child) throw AdapterNonExistent{};
    return *orb_.poas_[static_cast<std::size_t>(*child)];
}

void Poa::destroy(bool wait_for_completion) {
    OrbImpl::Lock lock{orb_.mutex_};
    const poa::ObjectAdapter& adapter = orb_.adapter_with(id_);
    if (wait_for_completion) orb_.require_no_user_code("destroy(true)");
    orb_.engine_.destroy_poa(id_);
    orb_.transmit(orb_.now());  // the filters
    orb_.wake();                // what was held is refused
    if (!wait_for_completion) return;
    orb_.wait_for_completion(lock, [&](const OrbImpl::ServantCall& call) {
        return call.poa && adapter.is_within(*call.poa, id_);
    });
}

const std::string& Poa::the_name() const {
    const OrbImpl::Lock lock{orb_.mutex_};
    return orb_.engine_.adapter().name(id_);
}

Poa* Poa::the_parent() const {
    const OrbImpl::Lock lock{orb_.mutex_};
    const auto parent = orb_.adapter_with(id_).parent(id_);
    return parent ? orb_.poas_[static_cast<std::size_t>(*parent)].get() : nullptr;
}

std::vector<Poa*> Poa::the_children() const {
    const OrbImpl::Lock lock{orb_.mutex_};
    std::vector<Poa*> children;
    for (const poa::PoaId child : orb_.adapter_with(id_).children(id_)) {
        children.push_back(orb_.poas_[static_cast<std::size_t>(child)].get());
    }
    return children;
}

PoaManager& Poa::the_POAManager() const {
    const OrbImpl::Lock lock{orb_.mutex_};
    static_cast<void>(orb_.adapter_with(id_));
    return manager_;
}

PoaPolicies Poa::policies() const {
    const OrbImpl::Lock lock{orb_.mutex_};
    return orb_.adapter_with(id_).policies(id_);
}

// ---- objects

ObjectRef Poa::activate_object(Servant& servant) {
    const OrbImpl::Lock lock{orb_.mutex_};
    poa::ObjectAdapter& adapter = orb_.adapter_with(id_);
    orb_.require_node();
    const auto index = adapter.activate(id_, servant);
    if (!index) throw_activation_error(index.error(), 0);
    return orb_.reference_to(*index, servant._interface_info().repository_id);
}

ObjectRef Poa::activate_object_with_id(ObjectId id, Servant& servant) {
    const OrbImpl::Lock lock{orb_.mutex_};
    poa::ObjectAdapter& adapter = orb_.adapter_with(id_);
    orb_.require_node();
    const auto index = adapter.activate_with_id(id_, id, servant);
    if (!index) throw_activation_error(index.error(), id);
    return orb_.reference_to(id, servant._interface_info().repository_id);
}

void Poa::deactivate_object(ObjectId id, bool wait_for_completion) {
    OrbImpl::Lock lock{orb_.mutex_};
    const Servant* servant = &orb_.servant_of(id_, id);
    if (wait_for_completion) orb_.require_no_user_code("deactivate_object(..., true)");
    static_cast<void>(orb_.engine_.deactivate(id));  // it is active
    orb_.transmit(orb_.now());                       // the filters
    orb_.wake();                                     // what was held is refused
    if (!wait_for_completion) return;
    orb_.wait_for_completion(lock, [&](const OrbImpl::ServantCall& call) {
        return call.object == id && call.servant == servant;
    });
}

ObjectRef Poa::create_reference(std::string_view repository_id) {
    const OrbImpl::Lock lock{orb_.mutex_};
    poa::ObjectAdapter& adapter = orb_.adapter_with(id_);
    orb_.require_node();
    const auto index = adapter.reserve(id_);
    if (!index) throw_activation_error(index.error(), 0);
    return orb_.reference_to(*index, repository_id);
}

ObjectRef Poa::create_reference_with_id(ObjectId id, std::string_view repository_id) {
    const OrbImpl::Lock lock{orb_.mutex_};
    if (const auto error = orb_.adapter_with(id_).check_index(id_, id)) {
        throw_activation_error(*error, id);
    }
    return orb_.reference_to(id, repository_id);
}

ObjectId Poa::servant_to_id(Servant& servant) {
    const OrbImpl::Lock lock{orb_.mutex_};
    poa::ObjectAdapter& adapter = orb_.adapter_with(id_);
    const PoaPolicies& policies = adapter.policies(id_);
    const bool unique = policies.id_uniqueness == IdUniquenessPolicy::unique_id;
    const bool implicit = policies.id_assignment == IdAssignmentPolicy::system_id;
    if (!unique && !implicit) throw WrongPolicy{};
    if (unique) {
        if (const auto index = adapter.index_of(id_, servant)) return *index;
    }
    if (!implicit) throw ServantNotActive{};
    const auto index = adapter.activate(id_, servant);
    if (!index) throw_activation_error(index.error(), 0);
    return *index;
}

ObjectRef Poa::servant_to_reference(Servant& servant) {
    return id_to_reference(servant_to_id(servant));
}

Servant& Poa::reference_to_servant(const ObjectRef& reference) const {
    return id_to_servant(reference_to_id(reference));
}

ObjectId Poa::reference_to_id(const ObjectRef& reference) const {
    const OrbImpl::Lock lock{orb_.mutex_};
    const poa::ObjectAdapter& adapter = orb_.adapter_with(id_);
    const auto index = reference.index();
    if (!index || reference.node() != orb_.engine_.node() || adapter.poa_of(*index) != id_) {
        throw WrongAdapter{};
    }
    return *index;
}

Servant& Poa::id_to_servant(ObjectId id) const {
    const OrbImpl::Lock lock{orb_.mutex_};
    return orb_.servant_of(id_, id);
}

ObjectRef Poa::id_to_reference(ObjectId id) const {
    const OrbImpl::Lock lock{orb_.mutex_};
    return orb_.reference_to(id, orb_.servant_of(id_, id)._interface_info().repository_id);
}

}  // namespace canorb
