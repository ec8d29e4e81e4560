#include "orb/poa/object_adapter.hpp"

#include <algorithm>

namespace canorb::poa {

ObjectAdapter::ObjectAdapter()
    : managers_{PoaManagerState::active}, entries_(last_object_index + std::size_t{1}) {
    poas_.push_back({.name = "RootPOA"});
}

// ---- the tree

Result<PoaId, CreationError> ObjectAdapter::create(PoaId parent, std::string_view name,
                                                   std::optional<ManagerId> manager,
                                                   const PoaPolicies& policies) {
    if (find_child(parent, name)) return Failure{CreationError::already_exists};
    // The ORB counts its ids from 1024 in every run: the same id would be another object.
    if (policies.lifespan == LifespanPolicy::persistent &&
        policies.id_assignment == IdAssignmentPolicy::system_id) {
        return Failure{CreationError::invalid_policy};
    }
    if (!manager) {
        manager = static_cast<ManagerId>(managers_.size());
        managers_.push_back(PoaManagerState::holding);
    } else if (state(*manager) == PoaManagerState::inactive) {
        return Failure{CreationError::manager_inactive};
    }
    poas_.push_back(
        {.name = std::string{name}, .parent = parent, .manager = *manager, .policies = policies});
    return static_cast<PoaId>(poas_.size() - 1);
}

void ObjectAdapter::destroy(PoaId poa) {
    for (std::size_t i = 0; i < poas_.size(); ++i) {
        if (is_within(static_cast<PoaId>(i), poa)) poas_[i].exists = false;
    }
}

bool ObjectAdapter::is_within(PoaId poa, PoaId ancestor) const {
    // Children have greater ids than their parents, so this ends.
    while (poa > ancestor) poa = record(poa).parent;
    return poa == ancestor;
}

std::optional<PoaId> ObjectAdapter::find_child(PoaId parent, std::string_view name) const {
    for (const PoaId child : children(parent)) {
        if (record(child).name == name) return child;
    }
    return std::nullopt;
}

std::vector<PoaId> ObjectAdapter::children(PoaId parent) const {
    std::vector<PoaId> found;
    for (std::size_t i = 1; i < poas_.size(); ++i) {
        if (poas_[i].exists && poas_[i].parent == parent) found.push_back(static_cast<PoaId>(i));
    }
    return found;
}

std::optional<PoaId> ObjectAdapter::parent(PoaId poa) const {
    if (poa == root_poa) return std::nullopt;
    return record(poa).parent;
}

// ---- managers

bool ObjectAdapter::set_state(ManagerId manager, PoaManagerState state) {
    PoaManagerState& current = managers_[static_cast<std::size_t>(manager)];
    if (current == PoaManagerState::inactive) return false;
    current = state;
    return true;
}

// ---- objects

bool ObjectAdapter::is_taken(PoaId poa, const Servant& servant) const {
    return policies(poa).id_uniqueness == IdUniquenessPolicy::unique_id && index_of(poa, servant);
}

Result<ObjectIndex, ActivationError> ObjectAdapter::put(PoaId poa, ObjectIndex index,
                                                        Servant& servant) {
    entries_[index] = {&servant, poa};
    return index;
}

Result<ObjectIndex, ActivationError> ObjectAdapter::reserve(PoaId poa) {
    if (policies(poa).id_assignment == IdAssignmentPolicy::user_id) {
        return Failure{ActivationError::wrong_policy};
    }
    if (next_system_index_ > last_object_index) return Failure{ActivationError::exhausted};
    entries_[next_system_index_].poa = poa;
    return next_system_index_++;
}

Result<ObjectIndex, ActivationError> ObjectAdapter::activate(PoaId poa, Servant& servant) {
    if (is_taken(poa, servant)) return Failure{ActivationError::servant_already_active};
    const auto index = reserve(poa);
    if (!index) return index;
    return put(poa, *index, servant);
}

std::optional<ActivationError> ObjectAdapter::check_index(PoaId poa, ObjectIndex index) const {
    if (index >= first_user_index && index <= last_user_index) {
        const bool takes =
            poa == root_poa || policies(poa).id_assignment == IdAssignmentPolicy::user_id;
        if (takes) return std::nullopt;
        return ActivationError::not_from_this_poa;
    }
    if (policies(poa).id_assignment == IdAssignmentPolicy::user_id) {
        return ActivationError::index_out_of_range;
    }
    if (poa_of(index) == poa) return std::nullopt;
    return poa == root_poa ? ActivationError::index_out_of_range
                           : ActivationError::not_from_this_poa;
}

Result<ObjectIndex, ActivationError> ObjectAdapter::activate_with_id(PoaId poa, ObjectIndex index,
                                                                     Servant& servant) {
    if (const auto error = check_index(poa, index)) return Failure{*error};
    if (find(index) != nullptr) return Failure{ActivationError::object_already_active};
    if (is_taken(poa, servant)) return Failure{ActivationError::servant_already_active};
    return put(poa, index, servant);
}

bool ObjectAdapter::deactivate(ObjectIndex index) {
    if (find(index) == nullptr) return false;
    entries_[index].servant = nullptr;
    return true;
}

Servant* ObjectAdapter::find(ObjectIndex index) const {
    return index <= last_object_index ? entries_[index].servant : nullptr;
}

std::optional<PoaId> ObjectAdapter::poa_of(ObjectIndex index) const {
    return index <= last_object_index ? entries_[index].poa : std::nullopt;
}

std::optional<ObjectIndex> ObjectAdapter::index_of(PoaId poa, const Servant& servant) const {
    const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
        return entry.servant == &servant && entry.poa == poa;
    });
    if (found == entries_.end()) return std::nullopt;
    return static_cast<ObjectIndex>(found - entries_.begin());
}

Admission ObjectAdapter::admission(ObjectIndex index) const {
    if (find(index) == nullptr) return Admission::not_active;
    const auto poa = poa_of(index);
    if (!poa) return Admission::dispatch;
    switch (state(manager(*poa))) {
        case PoaManagerState::holding:
            return Admission::hold;
        case PoaManagerState::active:
            return Admission::dispatch;
        case PoaManagerState::discarding:
            return Admission::discard;
        case PoaManagerState::inactive:
            break;
    }
    return Admission::inactive;
}

std::optional<ObjectIndex> ObjectAdapter::next_active(ObjectIndex first) const {
    for (ObjectIndex index = first; index <= last_object_index; ++index) {
        if (find(index) != nullptr) return index;
    }
    return std::nullopt;
}

}  // namespace canorb::poa
