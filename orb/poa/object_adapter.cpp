#include "orb/poa/object_adapter.hpp"

#include <algorithm>

namespace canorb::poa {

ObjectAdapter::ObjectAdapter() : servants_(last_object_index + std::size_t{1}, nullptr) {}

bool ObjectAdapter::is_active(const Servant& servant) const {
    return std::find(servants_.begin(), servants_.end(), &servant) != servants_.end();
}

Result<ObjectIndex, ActivationError> ObjectAdapter::activate(Servant& servant) {
    if (is_active(servant)) return Failure{ActivationError::servant_already_active};
    if (next_system_index_ > last_object_index) return Failure{ActivationError::exhausted};
    servants_[next_system_index_] = &servant;
    return next_system_index_++;
}

Result<ObjectIndex, ActivationError> ObjectAdapter::activate_with_id(ObjectIndex index,
                                                                     Servant& servant) {
    if (index < first_user_index || index > last_user_index) {
        return Failure{ActivationError::index_out_of_range};
    }
    if (servants_[index] != nullptr) return Failure{ActivationError::object_already_active};
    if (is_active(servant)) return Failure{ActivationError::servant_already_active};
    servants_[index] = &servant;
    return index;
}

bool ObjectAdapter::deactivate(ObjectIndex index) {
    if (find(index) == nullptr) return false;
    servants_[index] = nullptr;
    return true;
}

Servant* ObjectAdapter::find(ObjectIndex index) const {
    return index <= last_object_index ? servants_[index] : nullptr;
}

}  // namespace canorb::poa
