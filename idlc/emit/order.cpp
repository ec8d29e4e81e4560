#include "idlc/emit/order.hpp"

#include <algorithm>
#include <set>

namespace canorb::idlc::emit {

namespace {

using Set = std::set<const model::Definition*>;

/// Whether what the type contains, not only refers to, is there.
bool is_ready(const model::Type& type, const Set& missing) {
    const model::Type& known = model::resolved(type);
    if (known.element != nullptr) return is_ready(*known.element, missing);
    return known.kind != model::TypeKind::named || missing.count(known.definition) == 0;
}

bool is_ready(const model::Definition& definition, const Set& missing) {
    const std::vector<model::Member>* members = nullptr;
    if (const auto* body = std::get_if<model::Struct>(&definition.body)) members = &body->members;
    if (const auto* body = std::get_if<model::Exception>(&definition.body)) {
        members = &body->members;
    }
    return members == nullptr ||
           std::all_of(members->begin(), members->end(),
                       [&](const model::Member& member) { return is_ready(member.type, missing); });
}

}  // namespace

std::vector<Step> cpp_order(const std::vector<const model::Definition*>& definitions) {
    Set missing{definitions.begin(), definitions.end()};
    std::vector<const model::Definition*> waiting;
    std::vector<Step> steps;
    const auto define = [&](const model::Definition* definition) {
        steps.push_back({definition});
        missing.erase(definition);
    };
    for (const model::Definition* definition : definitions) {
        if (!is_ready(*definition, missing)) {
            steps.push_back({definition, true});
            waiting.push_back(definition);
            continue;
        }
        define(definition);
        // One that comes may be what the next waits for: they wait in their order.
        for (auto next = waiting.begin(); next != waiting.end();) {
            if (is_ready(**next, missing)) {
                define(*next);
                next = waiting.erase(next);
            } else {
                ++next;
            }
        }
    }
    for (const model::Definition* definition : waiting) define(definition);
    return steps;
}

}  // namespace canorb::idlc::emit
