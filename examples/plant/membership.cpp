#include "membership.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace plant {

Membership::Membership(canorb::Orb& orb, canorb::ObjectRef object, Log log)
    : orb_(orb), object_(std::move(object)), log_(std::move(log)) {}

void Membership::join(canorb::GroupId group) {
    if (orb_.object_is_member(object_, group))
        throw std::invalid_argument(fmt::format("is in group {} already", group.value()));
    orb_.object_join(object_, group);
    groups_.insert(std::ranges::lower_bound(groups_, group), group);
    log_(fmt::format("joined group {}: {}", group.value(), orb_.group_to_string(group)));
}

void Membership::leave(canorb::GroupId group) {
    if (!orb_.object_is_member(object_, group))
        throw std::invalid_argument(fmt::format("is not in group {}", group.value()));
    orb_.object_leave(object_, group);
    std::erase(groups_, group);
    log_(fmt::format("left group {}", group.value()));
}

PanelLine Membership::line() const {
    if (groups_.empty()) return {Mark::bad, "in no group"};
    std::string text = "in group";
    for (const canorb::GroupId group : groups_) text += fmt::format(" {}", group.value());
    return {Mark::none, text};
}

}  // namespace plant
