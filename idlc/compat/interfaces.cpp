#include <algorithm>
#include <variant>

#include "idlc/compat/comparison.hpp"

namespace canorb::idlc::compat {

using model::Definition;
using model::Definitions;
using model::InheritedOperation;
using model::Interface;
using model::Operation;

std::vector<InheritedOperation> all_operations(const Definition& interface) {
    const auto& body = std::get<Interface>(interface.body);
    std::vector<InheritedOperation> all = model::inherited_operations(body);
    for (const Operation& own : body.operations) all.push_back({&interface, &own});
    std::sort(all.begin(), all.end(),
              [](const auto& a, const auto& b) { return a.operation->id < b.operation->id; });
    return all;
}

void collect_bases(const Definition& interface, std::vector<const Definition*>& into) {
    for (const Definition* base : std::get<Interface>(interface.body).bases) {
        if (std::find(into.begin(), into.end(), base) != into.end()) continue;
        into.push_back(base);
        collect_bases(*base, into);
    }
}

bool is_local_interface(const Definition& interface) {
    return std::get<Interface>(interface.body).kind == model::InterfaceKind::local;
}

namespace {

const InheritedOperation* with_id(const std::vector<InheritedOperation>& all, unsigned id) {
    const auto at = std::find_if(all.begin(), all.end(),
                                 [&](const auto& each) { return each.operation->id == id; });
    return at == all.end() ? nullptr : &*at;
}

const InheritedOperation* with_name(const std::vector<InheritedOperation>& all,
                                    const std::string& name) {
    const auto at = std::find_if(all.begin(), all.end(), [&](const auto& each) {
        return model::wire_name(*each.operation) == name;
    });
    return at == all.end() ? nullptr : &*at;
}

/// "Devices::Motor::stop (3)"
std::string describe(const InheritedOperation& entry) {
    return model::scoped_name(*entry.interface) + "::" + model::wire_name(*entry.operation) + " (" +
           std::to_string(entry.operation->id) + ')';
}

}  // namespace

void Comparison::interface(const Definition& old_one, const Definition& new_one) {
    const std::string name = model::scoped_name(old_one);
    if (is_local_interface(old_one) || is_local_interface(new_one)) {
        if (!is_local_interface(old_one)) {
            add("interface-kind-changed", old_one, new_one,
                name +
                    " is local now: no new node serves or calls it over the bus, so old "
                    "clients find none");
        } else if (!is_local_interface(new_one)) {
            add("interface-added", old_one, new_one,
                name + " is no longer local: no old node serves or calls it over the bus");
        }
        return;
    }
    if (old_one.repository_id != new_one.repository_id) {
        add("repository-id-changed", old_one, new_one,
            old_one.repository_id + " is now " + new_one.repository_id +
                ": narrow in an old client gives nil for a new object, and messages to a group "
                "are skipped where the versions differ (counter group_interface_mismatches)");
    }
    bases(old_one, new_one);
    operations(old_one, new_one);
}

void Comparison::bases(const Definition& old_one, const Definition& new_one) {
    std::vector<const Definition*> old_bases;
    std::vector<const Definition*> new_bases;
    collect_bases(old_one, old_bases);
    collect_bases(new_one, new_bases);
    for (const Definition* base : old_bases) {
        const Definition* still = match(*base);
        if (std::find(new_bases.begin(), new_bases.end(), still) != new_bases.end()) continue;
        add("base-removed", old_one, new_one,
            model::scoped_name(new_one) + " no longer inherits " + model::scoped_name(*base) +
                ": an old client that narrows a new object to it gets nil, and messages to a group "
                "that it names are skipped");
    }
    for (const Definition* base : new_bases) {
        if (std::any_of(old_bases.begin(), old_bases.end(),
                        [&](const Definition* each) { return matched(*each, *base); })) {
            continue;
        }
        add("base-added", old_one, new_one,
            model::scoped_name(new_one) + " inherits " + model::scoped_name(*base) +
                " now: an old object does not, so narrow to it in a new client gives nil");
    }
}

void Comparison::operations(const Definition& old_one, const Definition& new_one) {
    const auto old_all = all_operations(old_one);
    const auto new_all = all_operations(new_one);
    std::vector<const Definition*> new_bases;
    collect_bases(new_one, new_bases);
    for (const InheritedOperation& each : old_all) {
        // What becomes of an inherited operation is said of the base, where it still is one.
        const bool inherited = each.interface != &old_one;
        const Definition* still = match(*each.interface);
        const InheritedOperation* there = with_id(new_all, each.operation->id);
        if (inherited && (there == nullptr || there->interface == still) &&
            std::find(new_bases.begin(), new_bases.end(), still) != new_bases.end()) {
            continue;
        }
        operation(new_one, each, old_all, new_all);
    }
    for (const Operation& own : std::get<Interface>(new_one.body).operations) {
        const InheritedOperation added{&new_one, &own};
        if (with_id(old_all, own.id) != nullptr ||
            with_name(old_all, model::wire_name(own)) != nullptr) {
            continue;
        }
        if (own.oneway) {
            add("oneway-operation-added", &old_one.provenance, &own.provenance,
                describe(added) +
                    " is new: an old object ignores it, and its caller is not told "
                    "(counter unmatched_replies at the client)");
        } else {
            add("operation-added", &old_one.provenance, &own.provenance,
                describe(added) +
                    " is new: an old server answers BAD_OPERATION (completed NO); old clients do "
                    "not call it");
        }
    }
}

void Comparison::operation(const Definition& new_interface, const InheritedOperation& old_one,
                           const std::vector<InheritedOperation>& old_all,
                           const std::vector<InheritedOperation>& new_all) {
    const Operation& old_operation = *old_one.operation;
    const std::string name = model::wire_name(old_operation);
    const InheritedOperation* there = with_id(new_all, old_operation.id);
    const InheritedOperation* elsewhere = with_name(new_all, name);
    if (there == nullptr) {
        const std::string lost =
            old_operation.oneway
                ? "an old client's calls are lost (counter unmatched_replies there)"
                : "an old client that calls it gets BAD_OPERATION (completed NO)";
        if (elsewhere == nullptr) {
            add("operation-removed", &old_operation.provenance, &new_interface.provenance,
                describe(old_one) + " is gone: " + lost);
        } else {
            add("operation-id-changed", &old_operation.provenance,
                &elsewhere->operation->provenance,
                describe(old_one) + " has id " + std::to_string(elsewhere->operation->id) +
                    " now, and its old one is nobody's: " + lost);
        }
        return;
    }
    const Operation& new_operation = *there->operation;
    if (model::wire_name(new_operation) == name) {
        if (!matched(*old_one.interface, *there->interface) && model::groupable(old_operation)) {
            add("operation-moved", &old_operation.provenance, &new_operation.provenance,
                describe(old_one) + " is declared in " + model::scoped_name(*there->interface) +
                    " now, which is what new messages to a group name: old members skip them "
                    "(counter group_interface_mismatches)");
        }
        signature(old_one, *there);
        return;
    }
    const std::size_t before = findings_.size();
    if (elsewhere == nullptr && with_name(old_all, model::wire_name(new_operation)) == nullptr) {
        const std::set<const Definition*> broken = broken_;
        signature(old_one, *there);
        if (findings_.size() == before) {
            add("operation-renamed", &old_operation.provenance, &new_operation.provenance,
                describe(old_one) + " is now " + model::wire_name(new_operation) +
                    ": names are not sent, so an old client's calls run it");
            return;
        }
        // They have nothing in common but the number.
        findings_.resize(before);
        broken_ = broken;
    }
    std::string text = describe(old_one) + ": that id is now " + model::wire_name(new_operation) +
                       "'s, so an old client's call runs that instead, where its parameters decode";
    if (elsewhere != nullptr) {
        text += "; " + name + " has id " + std::to_string(elsewhere->operation->id) + " now";
    }
    add("operation-id-reused", &old_operation.provenance, &new_operation.provenance, text);
}

void Comparison::signature(const InheritedOperation& old_one, const InheritedOperation& new_one) {
    const Operation& old_operation = *old_one.operation;
    const Operation& new_operation = *new_one.operation;
    const model::Provenance* old_place = &old_operation.provenance;
    const model::Provenance* new_place = &new_operation.provenance;
    if (old_operation.oneway != new_operation.oneway) {
        add("oneway-changed", old_place, new_place,
            new_operation.oneway
                ? describe(old_one) +
                      " is oneway now: an old client waits for an answer that a new server does "
                      "not send, and throws TIMEOUT (completed MAYBE)"
                : describe(old_one) +
                      " is no longer oneway: a new client waits for an answer that an old server "
                      "does not send, and throws TIMEOUT (completed MAYBE)");
    }
    if (model::groupable(old_operation) && !model::groupable(new_operation)) {
        add("no-longer-groupable", old_place, new_place,
            describe(old_one) +
                " cannot be sent to a group any more: new clients get BAD_OPERATION, so old "
                "members miss the call; that of an old client is still executed, unanswered");
    }
    if (old_operation.result && new_operation.result) {
        type(*old_operation.result, *new_operation.result,
             {"the result of " + describe(old_one),
              *old_place,
              *new_place,
              {.to_client = true},
              "result-changed"});
    } else if (old_operation.result || new_operation.result) {
        add("result-changed", old_place, new_place,
            describe(old_one) +
                (new_operation.result
                     ? " has a result now: an old client finds octets left over in the answer, a "
                       "new one misses some in an old server's"
                     : " has no result any more: an old client misses octets in the answer, a new "
                       "one finds some left over in an old server's") +
                ", and throws MARSHAL (completed YES)");
    }
    parameters(old_one, new_one);
    exceptions(old_one, new_one);
}

void Comparison::parameters(const InheritedOperation& old_one, const InheritedOperation& new_one) {
    const auto& old_parameters = old_one.operation->parameters;
    const auto& new_parameters = new_one.operation->parameters;
    const model::Provenance& old_place = old_one.operation->provenance;
    const model::Provenance& new_place = new_one.operation->provenance;
    const auto names = [](const std::vector<model::Parameter>& from) {
        std::vector<std::string> all;
        for (const model::Parameter& each : from) all.push_back(each.name);
        return all;
    };
    const auto flow_of = [](const model::Parameter& parameter) {
        return Flow{parameter.direction != model::Direction::out,
                    parameter.direction != model::Direction::in};
    };
    const auto both_ways = [&](std::string_view what, const model::Parameter& parameter,
                               bool added) {
        const Flow flow = flow_of(parameter);
        return "parameter '" + parameter.name + "' of " + describe(old_one) + std::string{what} +
               (added ? "octets are left over where an old node receives, and missing where a new "
                        "one does: "
                      : "octets are missing where an old node receives, and left over where a new "
                        "one does: ") +
               refuses("a", flow);
    };
    const Alignment alignment = align(names(old_parameters), names(new_parameters));
    if (alignment.reordered) {
        add("parameters-reordered", &old_place, &new_place,
            "the parameters of " + describe(old_one) +
                " are in another order: names are not sent, so each is taken for the other");
        return;
    }
    for (const auto& [i, j] : alignment.both) {
        const model::Parameter& old_parameter = old_parameters[i];
        const model::Parameter& new_parameter = new_parameters[j];
        const std::string name = "parameter '" + old_parameter.name + "' of " + describe(old_one);
        static constexpr std::string_view directions[] = {"in", "out", "inout"};
        if (old_parameter.direction != new_parameter.direction) {
            add("parameter-direction-changed", &old_place, &new_place,
                name + " is '" +
                    std::string{directions[static_cast<std::size_t>(new_parameter.direction)]} +
                    "', was '" +
                    std::string{directions[static_cast<std::size_t>(old_parameter.direction)]} +
                    "': octets are missing in one of Request and Reply, or left over: MARSHAL");
            continue;
        }
        const std::size_t before = findings_.size();
        type(old_parameter.type, new_parameter.type,
             {name, old_place, new_place, flow_of(old_parameter), "parameter-type-changed"});
        if (findings_.size() == before && old_parameter.name != new_parameter.name) {
            add("parameter-renamed", &old_place, &new_place,
                name + " is called '" + new_parameter.name +
                    "' now: names are not sent, so it is taken for the same");
        }
    }
    for (const std::size_t i : alignment.removed) {
        add("parameter-removed", &old_place, &new_place,
            both_ways(" is gone: ", old_parameters[i], false));
    }
    for (const std::size_t j : alignment.added) {
        add("parameter-added", &old_place, &new_place,
            both_ways(" is new: ", new_parameters[j], true));
    }
}

void Comparison::exceptions(const InheritedOperation& old_one, const InheritedOperation& new_one) {
    const Definitions& old_raises = old_one.operation->raises;
    const Definitions& new_raises = new_one.operation->raises;
    const model::Provenance* old_place = &old_one.operation->provenance;
    const model::Provenance* new_place = &new_one.operation->provenance;
    for (const Definition* each : new_raises) {
        if (std::any_of(old_raises.begin(), old_raises.end(),
                        [&](const Definition* old_each) { return matched(*old_each, *each); })) {
            continue;
        }
        add("exception-added", old_place, new_place,
            describe(old_one) + " can raise " + model::scoped_name(*each) +
                " now: an old client throws UNKNOWN (completed MAYBE) instead");
    }
    for (const Definition* each : old_raises) {
        const Definition* still = match(*each);
        if (std::find(new_raises.begin(), new_raises.end(), still) != new_raises.end()) continue;
        add("exception-removed", old_place, new_place,
            describe(old_one) + " does not raise " + model::scoped_name(*each) +
                " any more: where an old server does, a new client throws UNKNOWN "
                "(completed MAYBE)");
    }
}

}  // namespace canorb::idlc::compat
