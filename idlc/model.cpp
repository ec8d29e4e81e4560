#include "idlc/model.hpp"

#include <algorithm>

namespace canorb::idlc::model {

const Type& resolved(const Type& type) {
    const Type* at = &type;
    while (at->kind == TypeKind::named) {
        const auto* alias = std::get_if<Alias>(&at->definition->body);
        if (alias == nullptr) break;
        at = &alias->type;
    }
    return *at;
}

namespace {

constexpr std::uint64_t most_inline_octets = 256;

/// The octets of a scalar in memory; 0 where the type is none.
std::uint64_t scalar_octets(const Type& type) {
    const Type& known = resolved(type);
    switch (known.kind) {
        case TypeKind::boolean:
        case TypeKind::character:
        case TypeKind::octet:
        case TypeKind::int8:
        case TypeKind::uint8:
            return 1;
        case TypeKind::int16:
        case TypeKind::uint16:
            return 2;
        case TypeKind::int32:
        case TypeKind::uint32:
        case TypeKind::float32:
            return 4;
        case TypeKind::int64:
        case TypeKind::uint64:
        case TypeKind::float64:
            return 8;
        case TypeKind::named:
            return std::holds_alternative<Enum>(known.definition->body) ? 4 : 0;
        default:
            return 0;
    }
}

}  // namespace

bool is_scalar(const Type& type) {
    return scalar_octets(type) != 0;
}

bool is_inline(const Type& type) {
    const Type& known = resolved(type);
    if (known.bound == 0) return false;
    if (known.kind == TypeKind::string) return known.bound + std::uint64_t{1} <= most_inline_octets;
    if (known.kind != TypeKind::sequence) return false;
    const std::uint64_t element = scalar_octets(*known.element);
    return element != 0 && known.bound * element <= most_inline_octets;
}

std::string wire_name(const Operation& operation) {
    switch (operation.kind) {
        case OperationKind::get:
            return "_get_" + operation.name;
        case OperationKind::set:
            return "_set_" + operation.name;
        case OperationKind::operation:
            break;
    }
    return operation.name;
}

bool groupable(const Operation& operation) {
    return !operation.result && operation.raises.empty() &&
           std::all_of(
               operation.parameters.begin(), operation.parameters.end(),
               [](const Parameter& parameter) { return parameter.direction == Direction::in; });
}

std::string scoped_name(const Definition& definition) {
    if (definition.parent == nullptr) return definition.name;
    return scoped_name(*definition.parent) + "::" + definition.name;
}

namespace {

void collect_inherited(const Interface& interface, std::vector<const Definition*>& seen,
                       std::vector<InheritedOperation>& into) {
    for (const Definition* base : interface.bases) {
        if (std::find(seen.begin(), seen.end(), base) != seen.end()) continue;
        seen.push_back(base);
        const auto& body = std::get<Interface>(base->body);
        collect_inherited(body, seen, into);
        for (const Operation& operation : body.operations) into.push_back({base, &operation});
    }
}

void append_table(const std::vector<const Definition*>& definitions, std::string& text) {
    for (const Definition* definition : definitions) {
        if (const auto* module = std::get_if<Module>(&definition->body)) {
            append_table(module->definitions, text);
        }
        const auto* interface = std::get_if<Interface>(&definition->body);
        if (interface == nullptr || !definition->in_main_file) continue;
        std::vector<InheritedOperation> all = inherited_operations(*interface);
        for (const Operation& own : interface->operations) all.push_back({definition, &own});
        std::sort(all.begin(), all.end(),
                  [](const auto& a, const auto& b) { return a.operation->id < b.operation->id; });
        text += definition->repository_id + '\n';
        for (const InheritedOperation& entry : all) {
            std::string id = std::to_string(entry.operation->id);
            text += std::string(5 - id.size(), ' ') + id + "  " + wire_name(*entry.operation);
            if (entry.interface != definition) {
                text += "  (from " + scoped_name(*entry.interface) + ')';
            }
            text += '\n';
        }
    }
}

}  // namespace

std::vector<InheritedOperation> inherited_operations(const Interface& interface) {
    std::vector<const Definition*> seen;
    std::vector<InheritedOperation> operations;
    collect_inherited(interface, seen, operations);
    return operations;
}

std::string operation_table(const Model& model) {
    std::string text;
    append_table(model.definitions, text);
    return text;
}

}  // namespace canorb::idlc::model
