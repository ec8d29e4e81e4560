#include "idlc/model.hpp"

#include <algorithm>
#include <set>

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
        case TypeKind::wide_character:
            return 2;
        case TypeKind::int32:
        case TypeKind::uint32:
        case TypeKind::float32:
            return 4;
        case TypeKind::int64:
        case TypeKind::uint64:
        case TypeKind::float64:
            return 8;
        case TypeKind::float128:
            return 16;
        case TypeKind::named:
            if (std::holds_alternative<Enum>(known.definition->body)) return 4;
            if (const auto* mask = std::get_if<Bitmask>(&known.definition->body)) {
                return mask->bit_bound <= 8    ? 1
                       : mask->bit_bound <= 16 ? 2
                       : mask->bit_bound <= 32 ? 4
                                               : 8;
            }
            return 0;
        default:
            return 0;
    }
}

/// All that a value of a struct, exception or union can have in it.
std::vector<const Member*> parts_of(const Definition& definition) {
    std::vector<const Member*> parts = all_members(definition);
    if (const auto* choice = std::get_if<Union>(&definition.body)) {
        for (const UnionCase& one : choice->cases) parts.push_back(&one.member);
    }
    return parts;
}

/// Whether `predicate` holds of a struct, union or interface that a value of the type consists of,
/// or can consist of through sequences and maps.
template <typename Predicate>
bool any_part(const Type& type, std::set<const Definition*>& seen, const Predicate& predicate) {
    const Type& known = resolved(type);
    if (known.key != nullptr && any_part(*known.key, seen, predicate)) return true;
    if (known.element != nullptr) return any_part(*known.element, seen, predicate);
    if (known.kind != TypeKind::named || !seen.insert(known.definition).second) return false;
    if (predicate(*known.definition)) return true;
    const std::vector<const Member*> members = parts_of(*known.definition);
    return std::any_of(members.begin(), members.end(), [&](const Member* member) {
        return any_part(member->type, seen, predicate);
    });
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

bool is_local(const Type& type) {
    std::set<const Definition*> seen;
    return any_part(type, seen, [](const Definition& part) {
        const auto* interface = std::get_if<Interface>(&part.body);
        return interface != nullptr && interface->kind == InterfaceKind::local;
    });
}

bool is_recursive(const Definition& definition) {
    const std::vector<const Member*> members = parts_of(definition);
    return std::any_of(members.begin(), members.end(), [&](const Member* member) {
        std::set<const Definition*> seen;
        return any_part(member->type, seen,
                        [&](const Definition& part) { return &part == &definition; });
    });
}

bool takes_no_octets(const Type& type) {
    const Type& known = resolved(type);
    if (known.kind == TypeKind::array) return takes_no_octets(*known.element);
    if (known.kind != TypeKind::named || !std::holds_alternative<Struct>(known.definition->body)) {
        return false;
    }
    const std::vector<const Member*> members = parts_of(*known.definition);
    return std::all_of(members.begin(), members.end(),
                       [](const Member* member) { return takes_no_octets(member->type); });
}

std::uint16_t FixedValue::digits() const {
    const auto all =
        std::count_if(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
    const std::size_t first = text.starts_with('-') ? 1 : 0;
    const bool leading_zero = all > 1 && text[first] == '0';
    return static_cast<std::uint16_t>(all - (leading_zero ? 1 : 0));
}

std::uint16_t FixedValue::scale() const {
    const std::size_t point = text.find('.');
    return static_cast<std::uint16_t>(point == std::string::npos ? 0 : text.size() - point - 1);
}

std::vector<const Member*> all_members(const Struct& structure) {
    std::vector<const Member*> all;
    if (structure.base != nullptr) all = all_members(*structure.base);
    for (const Member& own : structure.members) all.push_back(&own);
    return all;
}

std::vector<const Member*> all_members(const Definition& definition) {
    if (const auto* body = std::get_if<Struct>(&definition.body)) return all_members(*body);
    std::vector<const Member*> all;
    if (const auto* exception = std::get_if<Exception>(&definition.body)) {
        for (const Member& member : exception->members) all.push_back(&member);
    }
    return all;
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
