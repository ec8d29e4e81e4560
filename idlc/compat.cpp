#include "idlc/compat.hpp"

#include <algorithm>
#include <variant>

#include "idlc/compat/comparison.hpp"
#include "idlc/structure.hpp"

namespace canorb::idlc::compat {

using model::Definition;
using model::Definitions;
using model::InheritedOperation;
using model::Interface;
using model::Operation;

namespace {

/// "IDL:Devices/Motor" of "IDL:Devices/Motor:1.0"; other formats have no version.
std::string without_version(const std::string& repository_id) {
    return repository_id.starts_with("IDL:") ? repository_id.substr(0, repository_id.rfind(':'))
                                             : repository_id;
}

/// All at any depth, but for what only declares something: its definition is there too.
void collect(const Definitions& from, std::vector<const Definition*>& into) {
    for (const Definition* each : from) {
        if (std::holds_alternative<model::Forward>(each->body)) continue;
        into.push_back(each);
        std::visit(
            [&](const auto& body) {
                if constexpr (requires { body.definitions; }) collect(body.definitions, into);
            },
            each->body);
    }
}

std::string place(const model::Provenance& provenance) {
    return provenance.file + ':' + std::to_string(provenance.line);
}

std::string_view name(Severity severity) {
    switch (severity) {
        case Severity::breaks:
            return "breaks";
        case Severity::careful:
            return "careful";
        case Severity::safe:
            break;
    }
    return "safe";
}

}  // namespace

std::span<const Rule> rules() {
    return all_rules;
}

Comparison::Comparison(const model::Model& old_version, const model::Model& new_version) {
    collect(old_version.definitions, old_);
    collect(new_version.definitions, new_);
    for (const Definition* each : new_) {
        if (!each->repository_id.empty()) {
            new_by_id_.emplace(without_version(each->repository_id), each);
        }
        new_by_name_.emplace(model::scoped_name(*each), each);
    }
    note_flows(old_);
    note_flows(new_);
}

void Comparison::add(RuleName rule, const model::Provenance* old_place,
                     const model::Provenance* new_place, std::string text) {
    Finding finding{rule.rule->name, rule.rule->severity, {}, {}, std::move(text)};
    if (old_place != nullptr) finding.old_place = *old_place;
    if (new_place != nullptr) finding.new_place = *new_place;
    findings_.push_back(std::move(finding));
    if (rule.rule->severity == Severity::breaks) broken_.insert(comparing_);
}

const Definition* Comparison::match(const Definition& old_one) const {
    const auto fits = [&](const Definition* candidate) {
        return candidate->body.index() == old_one.body.index();
    };
    const auto by_id = new_by_id_.find(without_version(old_one.repository_id));
    if (by_id != new_by_id_.end() && fits(by_id->second)) return by_id->second;
    const auto by_name = new_by_name_.find(model::scoped_name(old_one));
    if (by_name != new_by_name_.end() && fits(by_name->second)) return by_name->second;
    return nullptr;
}

Flow Comparison::flow(const Definition& old_one, const Definition& new_one) const {
    Flow all;
    for (const Definition* each : {&old_one, &new_one}) {
        const auto known = flows_.find(each);
        if (known == flows_.end()) continue;
        all.to_server = all.to_server || known->second.to_server;
        all.to_client = all.to_client || known->second.to_client;
    }
    return all;
}

void Comparison::note_flows(const Definitions& definitions) {
    for (const Definition* each : definitions) {
        const auto* interface = std::get_if<Interface>(&each->body);
        if (interface == nullptr) continue;
        for (const Operation& operation : interface->operations) {
            if (operation.result) note_flow(*operation.result, {.to_client = true});
            for (const model::Parameter& parameter : operation.parameters) {
                note_flow(parameter.type, {parameter.direction != model::Direction::out,
                                           parameter.direction != model::Direction::in});
            }
            for (const Definition* exception : operation.raises) {
                note_flow(*exception, {.to_client = true});
            }
        }
    }
}

void Comparison::note_flow(const Type& type, Flow flow) {
    const Type& known = model::resolved(type);
    if (known.key) note_flow(*known.key, flow);
    if (known.element) note_flow(*known.element, flow);
    if (known.kind == model::TypeKind::named) note_flow(*known.definition, flow);
}

void Comparison::note_flow(const Definition& definition, Flow flow) {
    Flow& known = flows_[&definition];
    const Flow both{known.to_server || flow.to_server, known.to_client || flow.to_client};
    if (both == known) return;
    known = both;
    if (const auto* structure = std::get_if<model::Struct>(&definition.body)) {
        for (const model::Member* member : all_members(*structure)) note_flow(member->type, both);
    } else if (const auto* exception = std::get_if<model::Exception>(&definition.body)) {
        for (const model::Member& member : exception->members) note_flow(member.type, both);
    } else if (const auto* choice = std::get_if<model::Union>(&definition.body)) {
        note_flow(choice->discriminator, both);
        for (const model::UnionCase& each : choice->cases) note_flow(each.member.type, both);
    }
}

std::vector<Finding> Comparison::run() {
    std::set<const Definition*> known;
    for (const Definition* old_one : old_) {
        const Definition* new_one = match(*old_one);
        if (new_one != nullptr && known.insert(new_one).second) {
            comparing_ = new_one;
            compare(*old_one, *new_one);
        } else if (std::holds_alternative<Interface>(old_one->body) &&
                   !is_local_interface(*old_one)) {
            comparing_ = nullptr;
            add("interface-removed", &old_one->provenance, nullptr,
                model::scoped_name(*old_one) +
                    " is gone: an old client that looks for one gets a nil reference from narrow, "
                    "and its messages to a group are skipped "
                    "(counter group_interface_mismatches)");
        }
    }
    for (const Definition* new_one : new_) {
        if (known.count(new_one) != 0 || !std::holds_alternative<Interface>(new_one->body) ||
            is_local_interface(*new_one)) {
            continue;
        }
        add("interface-added", nullptr, &new_one->provenance,
            model::scoped_name(*new_one) +
                " is new: no old node knows it, so none is asked for it; old members of a group "
                "skip its messages");
    }
    note_kept_ids();
    return std::move(findings_);
}

void Comparison::compare(const Definition& old_one, const Definition& new_one) {
    if (const auto* structure = std::get_if<model::Struct>(&old_one.body)) {
        type_id(old_one, new_one);
        members(old_one, new_one, all_members(*structure),
                all_members(std::get<model::Struct>(new_one.body)));
    } else if (const auto* exception = std::get_if<model::Exception>(&old_one.body)) {
        if (old_one.repository_id != new_one.repository_id) {
            add("repository-id-changed", old_one, new_one,
                old_one.repository_id + " is now " + new_one.repository_id +
                    ": an old client does not know the exception and throws UNKNOWN "
                    "(completed MAYBE)");
        }
        const auto pointers = [](const std::vector<model::Member>& from) {
            std::vector<const model::Member*> all;
            for (const model::Member& member : from) all.push_back(&member);
            return all;
        };
        members(old_one, new_one, pointers(exception->members),
                pointers(std::get<model::Exception>(new_one.body).members));
    } else if (std::holds_alternative<Interface>(old_one.body)) {
        interface(old_one, new_one);
    } else if (std::holds_alternative<model::Union>(old_one.body)) {
        type_id(old_one, new_one);
        choice(old_one, new_one);
    } else if (std::holds_alternative<model::Enum>(old_one.body)) {
        type_id(old_one, new_one);
        enumeration(old_one, new_one);
    } else if (std::holds_alternative<model::Bitmask>(old_one.body)) {
        type_id(old_one, new_one);
        bitmask(old_one, new_one);
    } else if (std::holds_alternative<model::Constant>(old_one.body)) {
        constant(old_one, new_one);
    }
}

namespace {

void reach(const model::Type& type, std::set<const Definition*>& seen);

void reach(const Definition& definition, std::set<const Definition*>& seen) {
    if (!seen.insert(&definition).second) return;
    if (const auto* structure = std::get_if<model::Struct>(&definition.body)) {
        for (const model::Member* member : all_members(*structure)) reach(member->type, seen);
    } else if (const auto* exception = std::get_if<model::Exception>(&definition.body)) {
        for (const model::Member& member : exception->members) reach(member.type, seen);
    } else if (const auto* choice = std::get_if<model::Union>(&definition.body)) {
        reach(choice->discriminator, seen);
        for (const model::UnionCase& each : choice->cases) reach(each.member.type, seen);
    }
}

void reach(const model::Type& type, std::set<const Definition*>& seen) {
    const model::Type& known = model::resolved(type);
    if (known.key) reach(*known.key, seen);
    if (known.element) reach(*known.element, seen);
    if (known.kind != model::TypeKind::named) return;
    // A reference only names an interface.
    if (std::holds_alternative<Interface>(known.definition->body)) return;
    reach(*known.definition, seen);
}

/// What an interface is made of: its bases, and the types of all its operations.
std::set<const Definition*> parts(const Definition& interface) {
    std::set<const Definition*> seen{&interface};
    std::vector<const Definition*> bases;
    collect_bases(interface, bases);
    seen.insert(bases.begin(), bases.end());
    for (const InheritedOperation& each : all_operations(interface)) {
        if (each.operation->result) reach(*each.operation->result, seen);
        for (const model::Parameter& parameter : each.operation->parameters) {
            reach(parameter.type, seen);
        }
        for (const Definition* exception : each.operation->raises) reach(*exception, seen);
    }
    return seen;
}

}  // namespace

void Comparison::note_kept_ids() {
    for (const Definition* old_one : old_) {
        const Definition* new_one = match(*old_one);
        if (new_one == nullptr || !std::holds_alternative<Interface>(old_one->body) ||
            is_local_interface(*new_one) || old_one->repository_id != new_one->repository_id) {
            continue;
        }
        const std::set<const Definition*> all = parts(*new_one);
        if (std::none_of(all.begin(), all.end(),
                         [&](const Definition* each) { return broken_.count(each) != 0; })) {
            continue;
        }
        add("repository-id-kept", *old_one, *new_one,
            model::scoped_name(*new_one) + " breaks old nodes and still is " +
                new_one->repository_id +
                ", so that nothing keeps the versions apart: give it a new version "
                "(#pragma version)");
    }
}

std::vector<Finding> compare(const model::Model& old_version, const model::Model& new_version) {
    return Comparison{old_version, new_version}.run();
}

std::string format(const std::vector<Finding>& findings) {
    std::string text;
    std::string counts;
    for (const Severity severity : {Severity::breaks, Severity::careful, Severity::safe}) {
        std::size_t count = 0;
        for (const Finding& finding : findings) {
            if (finding.severity != severity) continue;
            ++count;
            const auto& where = finding.new_place ? finding.new_place : finding.old_place;
            text += place(*where) + ": " + std::string{name(severity)} + ": " + finding.text +
                    " [" + std::string{finding.rule} + "]\n";
            if (finding.new_place && finding.old_place) {
                text += place(*finding.old_place) + ": note: in the old version\n";
            }
        }
        counts += (counts.empty() ? "" : ", ") + std::string{name(severity)} + ": " +
                  std::to_string(count);
    }
    if (findings.empty()) return "nothing differs on the wire\n";
    return text + counts + '\n';
}

bool any_breaks(const std::vector<Finding>& findings) {
    return std::any_of(findings.begin(), findings.end(),
                       [](const Finding& finding) { return finding.severity == Severity::breaks; });
}

}  // namespace canorb::idlc::compat
