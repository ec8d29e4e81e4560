#include <algorithm>
#include <variant>

#include "idlc/compat/comparison.hpp"
#include "idlc/structure.hpp"

namespace canorb::idlc::compat {

using model::Definition;
using model::Member;
using model::Type;
using model::TypeKind;

Alignment align(const std::vector<std::string>& old_names,
                const std::vector<std::string>& new_names) {
    const auto has = [](const std::vector<std::string>& names, const std::string& name) {
        return std::find(names.begin(), names.end(), name) != names.end();
    };
    Alignment result;
    std::size_t i = 0;
    std::size_t j = 0;
    while (i < old_names.size() && j < new_names.size()) {
        const bool kept = has(new_names, old_names[i]);
        const bool known = has(old_names, new_names[j]);
        if (old_names[i] == new_names[j] || (!kept && !known)) {
            result.both.emplace_back(i++, j++);
        } else if (kept && known) {
            result.reordered = true;
            return result;
        } else if (kept) {
            result.added.push_back(j++);
        } else {
            result.removed.push_back(i++);
        }
    }
    for (; i < old_names.size(); ++i) result.removed.push_back(i);
    for (; j < new_names.size(); ++j) result.added.push_back(j);
    return result;
}

std::string refuses(std::string_view age, Flow flow) {
    const std::string who = age == "a" ? "the " : std::string{age} + ' ';
    if (flow.to_server && !flow.to_client) return who + "server answers MARSHAL (completed NO)";
    if (flow.to_client && !flow.to_server) return who + "client throws MARSHAL (completed YES)";
    return who + "receiver refuses it: MARSHAL";
}

namespace {

std::string spelled(const Type& type) {
    return spell(type, model::scoped_name);
}

bool is_reference(const Type& type) {
    return type.kind == TypeKind::object ||
           (type.kind == TypeKind::named &&
            std::holds_alternative<model::Interface>(type.definition->body));
}

/// Of two kinds that have one encoding for the values that both have: -1 the second is narrower, 1
/// it is wider, 0 they are no such pair.
int width_change(TypeKind from, TypeKind to) {
    const auto is = [&](TypeKind a, TypeKind b) { return from == a && to == b; };
    if (is(TypeKind::int16, TypeKind::int32) || is(TypeKind::uint16, TypeKind::uint32)) return 1;
    if (is(TypeKind::int32, TypeKind::int16) || is(TypeKind::uint32, TypeKind::uint16)) return -1;
    return 0;
}

/// Kinds that are two words for one thing on the wire and in C++.
bool same_kind(TypeKind a, TypeKind b) {
    const auto is_octet = [](TypeKind kind) {
        return kind == TypeKind::octet || kind == TypeKind::uint8;
    };
    return a == b || (is_octet(a) && is_octet(b));
}

}  // namespace

void Comparison::type(const Type& old_type, const Type& new_type, const Site& site) {
    const Type& from = model::resolved(old_type);
    const Type& to = model::resolved(new_type);
    const std::string change = site.name + " is " + spelled(to) + ", was " + spelled(from) + ": ";
    const auto changed = [&] {
        add(site.changed, site,
            change + "the octets of one are read as the other, to wrong values or to MARSHAL");
    };
    if (const int width = width_change(from.kind, to.kind); width != 0) {
        const bool wider = width > 0;
        add(wider ? RuleName{"integer-widened"} : RuleName{"integer-narrowed"}, site,
            change + "values that both have are sent alike; for others " +
                refuses(wider ? "an old" : "a new", site.flow));
        return;
    }
    if (is_reference(from) && is_reference(to)) {
        if (from.kind == to.kind &&
            (from.kind == TypeKind::object || matched(*from.definition, *to.definition))) {
            return;
        }
        add("reference-type-changed", site,
            change +
                "references are not checked when they arrive, so calls can reach an object "
                "that has other operations under their ids");
        return;
    }
    if (!same_kind(from.kind, to.kind)) return changed();
    switch (from.kind) {
        case TypeKind::named:
            if (matched(*from.definition, *to.definition)) return;
            if (!same_octets(from, to)) return changed();
            add("type-replaced", site,
                change + "both have the same octets, so one is taken for the other");
            return;
        case TypeKind::fixed:
            if (from.digits != to.digits || from.scale != to.scale) changed();
            return;
        case TypeKind::array:
            if (from.bound != to.bound) return changed();
            break;
        case TypeKind::string:
        case TypeKind::wide_string:
        case TypeKind::sequence:
        case TypeKind::map:
            if (from.bound != to.bound) {
                const bool raised = to.bound == 0 || (from.bound != 0 && to.bound > from.bound);
                const std::uint32_t bound = raised ? from.bound : to.bound;
                add(raised ? RuleName{"bound-raised"} : RuleName{"bound-lowered"}, site,
                    change + "above " + std::to_string(bound) + ' ' +
                        refuses(raised ? "an old" : "a new", site.flow));
            }
            break;
        default:
            return;
    }
    const auto part = [&](const char* of) {
        Site inner = site;
        inner.name = of + site.name;
        return inner;
    };
    if (from.key && to.key) type(*from.key, *to.key, part("a key of "));
    if (from.element && to.element) type(*from.element, *to.element, part("an element of "));
}

bool Comparison::same_octets(const Type& old_type, const Type& new_type) {
    const Type& from = model::resolved(old_type);
    const Type& to = model::resolved(new_type);
    if (is_reference(from) && is_reference(to)) return true;
    if (!same_kind(from.kind, to.kind) || from.bound != to.bound || from.digits != to.digits ||
        from.scale != to.scale) {
        return false;
    }
    if (from.kind == TypeKind::named) return same_octets(*from.definition, *to.definition);
    return (!from.key || same_octets(*from.key, *to.key)) &&
           (!from.element || same_octets(*from.element, *to.element));
}

bool Comparison::same_octets(const Definition& old_one, const Definition& new_one) {
    if (old_one.body.index() != new_one.body.index()) return false;
    if (!assumed_same_.emplace(&old_one, &new_one).second) return true;
    const auto same_members = [this](const std::vector<const Member*>& from,
                                     const std::vector<const Member*>& to) {
        return std::equal(from.begin(), from.end(), to.begin(), to.end(),
                          [this](auto* a, auto* b) { return same_octets(a->type, b->type); });
    };
    const auto same_cases = [this](const model::UnionCase& a, const model::UnionCase& b) {
        return a.is_default == b.is_default && same_octets(a.member.type, b.member.type) &&
               std::equal(a.labels.begin(), a.labels.end(), b.labels.begin(), b.labels.end(),
                          [](const model::Value& x, const model::Value& y) {
                              return label_number(x) == label_number(y);
                          });
    };
    bool same = false;
    if (const auto* structure = std::get_if<model::Struct>(&old_one.body)) {
        same = same_members(all_members(*structure),
                            all_members(std::get<model::Struct>(new_one.body)));
    } else if (const auto* choice = std::get_if<model::Union>(&old_one.body)) {
        const auto& other = std::get<model::Union>(new_one.body);
        same = same_octets(choice->discriminator, other.discriminator) &&
               std::equal(choice->cases.begin(), choice->cases.end(), other.cases.begin(),
                          other.cases.end(), same_cases);
    } else if (const auto* enumeration = std::get_if<model::Enum>(&old_one.body)) {
        const auto& other = std::get<model::Enum>(new_one.body);
        same = std::equal(enumeration->enumerators.begin(), enumeration->enumerators.end(),
                          other.enumerators.begin(), other.enumerators.end(),
                          [](const auto& a, const auto& b) { return a.number == b.number; });
    } else if (const auto* bitmask = std::get_if<model::Bitmask>(&old_one.body)) {
        same = bitmask->bit_bound == std::get<model::Bitmask>(new_one.body).bit_bound;
    }
    // What was assumed of the pair holds if the whole is the same; else it must not be kept.
    if (!same) assumed_same_.clear();
    return same;
}

void Comparison::type_id(const Definition& old_one, const Definition& new_one) {
    if (old_one.repository_id == new_one.repository_id) return;
    add("type-id-changed", old_one, new_one,
        old_one.repository_id + " is now " + new_one.repository_id +
            ": only an any tells the type that it carries, and in one an old node takes it for "
            "another type");
}

void Comparison::enumeration(const Definition& old_one, const Definition& new_one) {
    using Enumerators = std::vector<model::Enumerator>;
    const Enumerators& from = std::get<model::Enum>(old_one.body).enumerators;
    const Enumerators& to = std::get<model::Enum>(new_one.body).enumerators;
    const auto with_name = [](const Enumerators& all, const std::string& name) {
        const auto at = std::find_if(all.begin(), all.end(),
                                     [&](const auto& each) { return each.name == name; });
        return at == all.end() ? nullptr : &*at;
    };
    const auto with_number = [](const Enumerators& all, std::uint32_t number) {
        const auto at = std::find_if(all.begin(), all.end(),
                                     [&](const auto& each) { return each.number == number; });
        return at == all.end() ? nullptr : &*at;
    };
    const std::string scope = model::scoped_name(old_one) + "::";
    const auto describe = [&](const model::Enumerator& each) {
        return scope + each.name + " (" + std::to_string(each.number) + ')';
    };
    const std::string refused = refuses("an old", flow(old_one, new_one));
    bool shifted = false;
    for (const model::Enumerator& each : to) {
        if (with_name(from, each.name) != nullptr) continue;
        const model::Enumerator* before = with_number(from, each.number);
        if (before == nullptr) {
            add("enumerator-appended", old_one, new_one,
                describe(each) + " is new: where it is sent, " + refused);
        } else if (with_name(to, before->name) == nullptr) {
            add("enumerator-renamed", old_one, new_one,
                describe(*before) + " is called " + each.name +
                    " now: names are not sent, so it is taken for the same");
        } else {
            shifted = true;
            add("enumerator-inserted", old_one, new_one,
                describe(each) + " has the number that " + before->name +
                    " had: old and new nodes take one for the other, and so for those behind it");
        }
    }
    for (const model::Enumerator& each : from) {
        if (with_name(to, each.name) != nullptr) continue;
        const model::Enumerator* after = with_number(to, each.number);
        if (after == nullptr) {
            add("enumerator-removed", old_one, new_one,
                describe(each) + " is gone: where an old node sends it, " +
                    refuses("a new", flow(old_one, new_one)));
        } else if (with_name(from, after->name) != nullptr) {
            shifted = true;
            add("enumerator-removed", old_one, new_one,
                describe(each) + " is gone and its number is " + after->name +
                    "'s now: old and new nodes take one for the other, and so for those behind it");
        }
    }
    if (shifted) return;
    for (const model::Enumerator& each : from) {
        const model::Enumerator* after = with_name(to, each.name);
        if (after == nullptr || after->number == each.number) continue;
        add("enumerators-reordered", old_one, new_one,
            describe(each) + " is " + std::to_string(after->number) +
                " now: old and new nodes take it for another, or refuse it");
        return;
    }
}

void Comparison::bitmask(const Definition& old_one, const Definition& new_one) {
    const auto& from = std::get<model::Bitmask>(old_one.body);
    const auto& to = std::get<model::Bitmask>(new_one.body);
    const std::string name = model::scoped_name(old_one);
    const auto with_name = [](const model::Bitmask& mask, const std::string& wanted) {
        return std::find_if(mask.flags.begin(), mask.flags.end(),
                            [&](const auto& flag) { return flag.name == wanted; });
    };
    const auto at = [](const model::Bitmask& mask, unsigned position) {
        return std::find_if(mask.flags.begin(), mask.flags.end(),
                            [&](const auto& flag) { return flag.position == position; });
    };
    // An octet, an integer of as many octets as it needs, and eight octets.
    const auto encoding = [](unsigned bits) { return bits <= 8 ? 1 : bits <= 32 ? 4 : 8; };
    if (from.bit_bound != to.bit_bound) {
        const std::string change = name + " has " + std::to_string(to.bit_bound) + " bits, had " +
                                   std::to_string(from.bit_bound) + ": ";
        if (encoding(from.bit_bound) != encoding(to.bit_bound)) {
            add("bit-bound-changed", old_one, new_one,
                change +
                    "it is encoded in another way, so the octets of one are read as the "
                    "other, to wrong values or to MARSHAL");
        } else {
            const bool raised = to.bit_bound > from.bit_bound;
            add(raised ? RuleName{"bound-raised"} : RuleName{"bound-lowered"}, old_one, new_one,
                change + "where one of the others is set, " +
                    refuses(raised ? "an old" : "a new", flow(old_one, new_one)));
        }
    }
    for (const model::Flag& flag : from.flags) {
        const auto still = with_name(to, flag.name);
        const auto there = at(to, flag.position);
        const std::string what =
            name + "::" + flag.name + " (bit " + std::to_string(flag.position) + ')';
        if (still != to.flags.end()) {
            if (still->position != flag.position) {
                add("flag-moved", old_one, new_one,
                    what + " is bit " + std::to_string(still->position) +
                        " now: old and new nodes take it for another");
            }
        } else if (there != to.flags.end() && with_name(from, there->name) == from.flags.end()) {
            add("flag-renamed", old_one, new_one,
                what + " is called " + there->name +
                    " now: names are not sent, so it is taken for the same");
        } else {
            add("flag-removed", old_one, new_one,
                what + " is gone: a new node that receives it keeps it, and makes nothing of it");
        }
    }
    for (const model::Flag& flag : to.flags) {
        if (with_name(from, flag.name) != from.flags.end() ||
            at(from, flag.position) != from.flags.end()) {
            continue;
        }
        add("flag-added", old_one, new_one,
            name + "::" + flag.name + " (bit " + std::to_string(flag.position) +
                ") is new: an old node that receives it keeps it, and makes nothing of it");
    }
}

void Comparison::members(const Definition& old_one, const Definition& new_one,
                         const std::vector<const Member*>& old_members,
                         const std::vector<const Member*>& new_members) {
    const auto names = [](const std::vector<const Member*>& from) {
        std::vector<std::string> all;
        for (const Member* each : from) all.push_back(each->name);
        return all;
    };
    const std::string scope = model::scoped_name(old_one) + "::";
    const Flow flow = this->flow(old_one, new_one);
    const Alignment alignment = align(names(old_members), names(new_members));
    if (alignment.reordered) {
        add("members-reordered", old_one, new_one,
            "the members of " + model::scoped_name(old_one) +
                " are in another order: names are not sent, so each is taken for the other");
        return;
    }
    for (const auto& [i, j] : alignment.both) {
        member(old_one, new_one, *old_members[i], *new_members[j]);
    }
    for (const std::size_t i : alignment.removed) {
        add("member-removed", old_one, new_one,
            scope + old_members[i]->name +
                " is gone: what follows is read in its place, and at the end octets are missing or "
                "left over: " +
                refuses("a", flow));
    }
    for (const std::size_t j : alignment.added) {
        const bool last = j >= old_members.size() && alignment.removed.empty();
        add(last ? RuleName{"member-appended"} : RuleName{"member-inserted"}, old_one, new_one,
            scope + new_members[j]->name +
                " is new: an old node takes it for what follows, a new one misses it, and at the "
                "end octets are left over or missing: " +
                refuses("a", flow));
    }
}

}  // namespace canorb::idlc::compat
