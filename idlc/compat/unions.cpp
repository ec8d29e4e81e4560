#include <algorithm>
#include <variant>

#include "idlc/compat/comparison.hpp"
#include "idlc/structure.hpp"

namespace canorb::idlc::compat {

using model::Definition;
using model::Member;
using model::Type;
using model::TypeKind;

namespace {

const model::Enum* enum_of(const Type& discriminator) {
    const Type& known = model::resolved(discriminator);
    return known.kind == TypeKind::named ? std::get_if<model::Enum>(&known.definition->body)
                                         : nullptr;
}

const model::Enumerator* named(const model::Enum& enumeration, const std::string& name) {
    const auto at = std::find_if(enumeration.enumerators.begin(), enumeration.enumerators.end(),
                                 [&](const auto& each) { return each.name == name; });
    return at == enumeration.enumerators.end() ? nullptr : &*at;
}

/// "RUNNING", "'a'", "TRUE", or the number that the label is on the wire.
std::string label_text(const model::Value& label) {
    if (const auto* truth = std::get_if<bool>(&label)) return *truth ? "TRUE" : "FALSE";
    if (const auto* character = std::get_if<char>(&label)) {
        if (*character > ' ' && *character <= '~') return std::string{'\'', *character, '\''};
    }
    const auto* enumerator = std::get_if<model::EnumeratorValue>(&label);
    if (enumerator == nullptr) return label_number(label);
    return std::get<model::Enum>(enumerator->enumeration->body)
        .enumerators.at(enumerator->index)
        .name;
}

/// The same as the other version calls it, where an enumerator has another name there.
std::string label_in(const model::Union& other, const model::Value& label) {
    const std::string name = label_text(label);
    const model::Enum* theirs = enum_of(other.discriminator);
    const auto* enumerator = std::get_if<model::EnumeratorValue>(&label);
    if (theirs == nullptr || enumerator == nullptr || named(*theirs, name) != nullptr) return name;
    const auto& ours = std::get<model::Enum>(enumerator->enumeration->body);
    for (const model::Enumerator& each : theirs->enumerators) {
        if (each.number == ours.enumerators.at(enumerator->index).number &&
            named(ours, each.name) == nullptr) {
            return each.name;
        }
    }
    return name;
}

const model::UnionCase* with_label(const model::Union& choice, const std::string& label) {
    for (const model::UnionCase& each : choice.cases) {
        for (const model::Value& value : each.labels) {
            if (label_text(value) == label) return &each;
        }
    }
    return nullptr;
}

const model::UnionCase* default_case(const model::Union& choice) {
    const auto at = std::find_if(choice.cases.begin(), choice.cases.end(),
                                 [](const auto& each) { return each.is_default; });
    return at == choice.cases.end() ? nullptr : &*at;
}

bool has_member(const model::Union& choice, const std::string& name) {
    return std::any_of(choice.cases.begin(), choice.cases.end(),
                       [&](const auto& each) { return each.member.name == name; });
}

/// Whether the discriminator can have the value: a number always, an enumerator where it is one.
bool can_be(const model::Union& choice, const std::string& label) {
    const model::Enum* enumeration = enum_of(choice.discriminator);
    return enumeration == nullptr || named(*enumeration, label) != nullptr;
}

std::string selects(const model::UnionCase* selected) {
    return selected == nullptr ? "nothing" : selected->member.name;
}

}  // namespace

void Comparison::choice(const Definition& old_one, const Definition& new_one) {
    const auto& from = std::get<model::Union>(old_one.body);
    const auto& to = std::get<model::Union>(new_one.body);
    const std::string name = model::scoped_name(old_one);
    const Flow flow = this->flow(old_one, new_one);
    const std::size_t before = findings_.size();
    type(from.discriminator, to.discriminator,
         {"the discriminator of " + name, old_one.provenance, new_one.provenance, flow,
          "discriminator-changed"});
    if (findings_.size() != before && findings_.back().rule == "discriminator-changed") return;

    // Each pair of members that a value of the discriminator selects, once.
    std::set<std::pair<const model::UnionCase*, const model::UnionCase*>> compared;
    const auto selection = [&](const std::string& what, RuleName rule,
                               const model::UnionCase* old_case, const model::UnionCase* new_case) {
        if (old_case == nullptr && new_case == nullptr) return;
        if (old_case != nullptr && new_case != nullptr) {
            const std::string& old_name = old_case->member.name;
            const std::string& new_name = new_case->member.name;
            if (old_name == new_name ||
                (!has_member(to, old_name) && !has_member(from, new_name))) {
                if (compared.emplace(old_case, new_case).second) {
                    member(old_one, new_one, old_case->member, new_case->member);
                }
                return;
            }
        }
        add(rule, old_one, new_one,
            what + " of " + name + " selects " + selects(new_case) + ", did select " +
                selects(old_case) +
                ": the octets of one are read as the other, to wrong values or to MARSHAL");
    };
    for (const model::UnionCase& old_case : from.cases) {
        for (const model::Value& value : old_case.labels) {
            const std::string label = label_in(to, value);
            const model::UnionCase* now = with_label(to, label);
            if (now != nullptr) {
                selection("label " + label, "union-label-moved", &old_case, now);
            } else if (can_be(to, label)) {
                selection("label " + label, "union-label-removed", &old_case, default_case(to));
            }
        }
    }
    for (const model::UnionCase& new_case : to.cases) {
        for (const model::Value& value : new_case.labels) {
            const std::string label = label_in(from, value);
            if (with_label(from, label) != nullptr) continue;
            if (can_be(from, label)) {
                selection("label " + label, "union-label-added", default_case(from), &new_case);
            } else {
                add("union-case-appended", old_one, new_one,
                    "label " + label + " of " + name +
                        " is new, as its enumerator is: " + refuses("an old", flow));
            }
        }
    }
    if (default_case(from) != nullptr && default_case(to) != nullptr) {
        selection("the default", "union-label-moved", default_case(from), default_case(to));
    } else {
        selection("the default",
                  default_case(to) != nullptr ? RuleName{"union-default-added"}
                                              : RuleName{"union-default-removed"},
                  default_case(from), default_case(to));
    }
}

void Comparison::member(const Definition& old_one, const Definition& new_one, const Member& from,
                        const Member& to) {
    const std::string name = model::scoped_name(old_one) + "::" + from.name;
    const std::size_t before = findings_.size();
    type(from.type, to.type,
         {name, old_one.provenance, new_one.provenance, flow(old_one, new_one),
          "member-type-changed"});
    if (findings_.size() == before && from.name != to.name) {
        add("member-renamed", old_one, new_one,
            name + " is called " + to.name +
                " now: names are not sent, so it is taken for the same");
    }
}

void Comparison::constant(const Definition& old_one, const Definition& new_one) {
    const auto& from = std::get<model::Constant>(old_one.body);
    const auto& to = std::get<model::Constant>(new_one.body);
    // Enumerators are compared where their enum is.
    if (std::holds_alternative<model::EnumeratorValue>(from.value)
            ? std::holds_alternative<model::EnumeratorValue>(to.value) &&
                  label_text(from.value) == label_text(to.value)
            : from.value == to.value) {
        return;
    }
    const auto text = [](const model::Value& value) {
        const auto* characters = std::get_if<std::string>(&value);
        return characters == nullptr ? label_text(value) : '"' + *characters + '"';
    };
    const std::string now = text(to.value);
    add("constant-changed", old_one, new_one,
        model::scoped_name(old_one) +
            (now.empty() ? " has another value" : " was " + text(from.value) + ", is " + now) +
            ": constants are not sent, so old nodes go on with theirs");
}

}  // namespace canorb::idlc::compat
