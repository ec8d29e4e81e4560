#include "idlc/structure.hpp"

#include <algorithm>
#include <set>
#include <tuple>
#include <variant>
#include <vector>

namespace canorb::idlc {

using model::Definition;
using model::Type;
using model::TypeKind;

std::string_view keyword(TypeKind kind) {
    switch (kind) {
        case TypeKind::boolean:
            return "boolean";
        case TypeKind::character:
            return "char";
        case TypeKind::wide_character:
            return "wchar";
        case TypeKind::octet:
            return "octet";
        case TypeKind::int8:
            return "int8";
        case TypeKind::uint8:
            return "uint8";
        case TypeKind::int16:
            return "short";
        case TypeKind::uint16:
            return "unsigned short";
        case TypeKind::int32:
            return "long";
        case TypeKind::uint32:
            return "unsigned long";
        case TypeKind::int64:
            return "long long";
        case TypeKind::uint64:
            return "unsigned long long";
        case TypeKind::float32:
            return "float";
        case TypeKind::float64:
            return "double";
        case TypeKind::float128:
            return "long double";
        case TypeKind::fixed:
            return "fixed";
        case TypeKind::any:
            return "any";
        case TypeKind::object:
            return "Object";
        case TypeKind::type_code:
            return "TypeCode";
        case TypeKind::string:
            return "string";
        case TypeKind::wide_string:
            return "wstring";
        case TypeKind::sequence:
            return "sequence";
        case TypeKind::map:
            return "map";
        case TypeKind::array:
            return "array";
        case TypeKind::named:
            break;
    }
    return {};
}

std::string_view kind_of(const Definition& definition) {
    struct Kind {
        std::string_view operator()(const model::Module&) const { return "module"; }
        std::string_view operator()(const model::Constant&) const { return "const"; }
        std::string_view operator()(const model::Enum&) const { return "enum"; }
        std::string_view operator()(const model::Bitmask&) const { return "bitmask"; }
        std::string_view operator()(const model::Struct&) const { return "struct"; }
        std::string_view operator()(const model::Union&) const { return "union"; }
        std::string_view operator()(const model::Exception&) const { return "exception"; }
        std::string_view operator()(const model::Alias&) const { return "typedef"; }
        std::string_view operator()(const model::Unusable& type) const { return type.kind; }
        std::string_view operator()(const model::Forward&) const { return "forward"; }
        std::string_view operator()(const model::Interface&) const { return "interface"; }
    };
    return std::visit(Kind{}, definition.body);
}

std::string spell(const Type& type, std::string (*name)(const Definition&)) {
    const Type& known = model::resolved(type);
    if (known.kind == TypeKind::named) return name(*known.definition);
    std::string arguments;
    const auto add = [&](const std::string& argument) {
        arguments += arguments.empty() ? argument : ',' + argument;
    };
    if (known.key) add(spell(*known.key, name));
    if (known.element) add(spell(*known.element, name));
    if (known.kind == TypeKind::fixed) {
        add(std::to_string(known.digits));
        add(std::to_string(known.scale));
    }
    if (known.bound != 0) add(std::to_string(known.bound));
    std::string text{keyword(known.kind)};
    return arguments.empty() ? text : text + '<' + arguments + '>';
}

namespace {

struct LabelNumber {
    std::string operator()(std::int64_t value) const { return std::to_string(value); }
    std::string operator()(std::uint64_t value) const { return std::to_string(value); }
    std::string operator()(char value) const {
        return std::to_string(static_cast<unsigned char>(value));
    }
    std::string operator()(char16_t value) const {
        return std::to_string(static_cast<unsigned>(value));
    }
    std::string operator()(bool value) const { return value ? "1" : "0"; }
    std::string operator()(const model::EnumeratorValue& value) const {
        const auto& enumeration = std::get<model::Enum>(value.enumeration->body);
        return std::to_string(enumeration.enumerators.at(value.index).number);
    }
    /// No discriminator is of another type.
    template <typename T>
    std::string operator()(const T&) const {
        return {};
    }
};

std::string repository_id(const Definition& definition) {
    return definition.repository_id;
}

/// Collects what is to be described, in the order of first use: so a text has each type once, and
/// recursion ends.
class Writer {
  public:
    std::string interface(const Definition& definition);

  private:
    std::string type(const Type& type);
    std::string use(const Definition& definition);
    std::string operation(const model::InheritedOperation& entry);
    std::string members(const std::vector<const model::Member*>& members);

    std::string describe(const model::Enum& enumeration);
    std::string describe(const model::Bitmask& bitmask);
    std::string describe(const model::Struct& structure);
    std::string describe(const model::Union& choice);
    std::string describe(const model::Exception& exception);
    template <typename T>
    std::string describe(const T&) {
        return {};
    }

    std::vector<const Definition*> used_;
};

void collect_types(const Type& type, std::vector<const Definition*>& used) {
    const Type& known = model::resolved(type);
    if (known.key) collect_types(*known.key, used);
    if (known.element) collect_types(*known.element, used);
    if (known.kind != TypeKind::named) return;
    // What an interface is can be asked of the object: a reference only names it.
    if (std::holds_alternative<model::Interface>(known.definition->body)) return;
    if (std::find(used.begin(), used.end(), known.definition) == used.end()) {
        used.push_back(known.definition);
    }
}

std::string Writer::type(const Type& type) {
    collect_types(type, used_);
    return spell(type, repository_id);
}

std::string Writer::use(const Definition& definition) {
    if (std::find(used_.begin(), used_.end(), &definition) == used_.end()) {
        used_.push_back(&definition);
    }
    return definition.repository_id;
}

std::string Writer::operation(const model::InheritedOperation& entry) {
    const model::Operation& operation = *entry.operation;
    std::string text = "operation " + std::to_string(operation.id) + " of " +
                       entry.interface->repository_id + ": ";
    if (operation.oneway) text += "oneway ";
    text += operation.result ? type(*operation.result) : "void";
    text += ' ' + model::wire_name(operation) + '(';
    static constexpr std::string_view directions[] = {"in ", "out ", "inout "};
    std::string_view separator;
    for (const model::Parameter& parameter : operation.parameters) {
        text += separator;
        text += directions[static_cast<std::size_t>(parameter.direction)];
        text += type(parameter.type) + ' ' + parameter.name;
        separator = ", ";
    }
    text += ')';
    model::Definitions raises = operation.raises;
    std::sort(raises.begin(), raises.end(),
              [](auto* a, auto* b) { return a->repository_id < b->repository_id; });
    for (const Definition* exception : raises) text += " raises " + use(*exception);
    return text + '\n';
}

std::string Writer::members(const std::vector<const model::Member*>& members) {
    std::string text = " {";
    for (const model::Member* member : members) {
        text += ' ' + type(member->type) + ' ' + member->name + ';';
    }
    return text + " }\n";
}

std::string Writer::describe(const model::Enum& enumeration) {
    std::vector<std::pair<std::uint32_t, std::string>> enumerators;
    for (const model::Enumerator& enumerator : enumeration.enumerators) {
        enumerators.emplace_back(enumerator.number, enumerator.name);
    }
    std::sort(enumerators.begin(), enumerators.end());
    std::string text = " {";
    for (const auto& [number, name] : enumerators)
        text += ' ' + std::to_string(number) + ' ' + name;
    return text + " }\n";
}

std::string Writer::describe(const model::Bitmask& bitmask) {
    std::vector<std::pair<unsigned, std::string>> flags;
    for (const model::Flag& flag : bitmask.flags) flags.emplace_back(flag.position, flag.name);
    std::sort(flags.begin(), flags.end());
    std::string text = ' ' + std::to_string(bitmask.bit_bound) + " {";
    for (const auto& [position, name] : flags) text += ' ' + std::to_string(position) + ' ' + name;
    return text + " }\n";
}

std::string Writer::describe(const model::Struct& structure) {
    return members(all_members(structure));
}

std::string Writer::describe(const model::Union& choice) {
    std::string text = ' ' + type(choice.discriminator) + " {";
    for (const model::UnionCase& each : choice.cases) {
        for (const model::Value& label : each.labels) text += " case " + label_number(label);
        if (each.is_default) text += " default";
        text += ": " + type(each.member.type) + ' ' + each.member.name + ';';
    }
    return text + " }\n";
}

std::string Writer::describe(const model::Exception& exception) {
    std::vector<const model::Member*> all;
    for (const model::Member& member : exception.members) all.push_back(&member);
    return members(all);
}

void collect_bases(const model::Interface& interface, std::set<const Definition*>& bases) {
    for (const Definition* base : interface.bases) {
        if (!bases.insert(base).second) continue;
        collect_bases(std::get<model::Interface>(base->body), bases);
    }
}

std::string Writer::interface(const Definition& definition) {
    const auto& body = std::get<model::Interface>(definition.body);
    std::string text = body.kind == model::InterfaceKind::local ? "local interface " : "interface ";
    text += definition.repository_id + '\n';

    std::set<const Definition*> bases;
    collect_bases(body, bases);
    std::set<std::string> ids;
    for (const Definition* base : bases) ids.insert(base->repository_id);
    for (const std::string& id : ids) text += "inherits " + id + '\n';

    // It is not on the wire, and its operations have no ids.
    if (body.kind == model::InterfaceKind::local) return text;

    std::vector<model::InheritedOperation> operations = model::inherited_operations(body);
    for (const model::Operation& own : body.operations) operations.push_back({&definition, &own});
    std::sort(operations.begin(), operations.end(),
              [](const auto& a, const auto& b) { return a.operation->id < b.operation->id; });
    for (const model::InheritedOperation& each : operations) text += operation(each);

    // Describing one finds others.
    for (std::size_t i = 0; i < used_.size(); ++i) {
        const Definition& used = *used_[i];
        text += std::string{kind_of(used)} + ' ' + used.repository_id;
        text += std::visit([this](const auto& what) { return describe(what); }, used.body);
    }
    return text;
}

}  // namespace

std::string label_number(const model::Value& label) {
    return std::visit(LabelNumber{}, label);
}

std::string structure(const Definition& interface) {
    return Writer{}.interface(interface);
}

std::uint16_t group_key(const Definition& interface) {
    std::uint32_t crc = 0xFFFF;
    for (const char c : interface.repository_id) {
        crc ^= static_cast<std::uint32_t>(static_cast<std::uint8_t>(c)) << 8;
        for (int bit = 0; bit < 8; ++bit) {
            crc = ((crc << 1) ^ ((crc & 0x8000U) != 0 ? 0x1021U : 0U)) & 0xFFFFU;
        }
    }
    return crc == 0 ? std::uint16_t{1} : static_cast<std::uint16_t>(crc);
}

std::uint32_t crc32(std::string_view text) {
    std::uint32_t crc = 0xFFFFFFFF;
    for (const char c : text) {
        crc ^= static_cast<std::uint8_t>(c);
        for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
    }
    return crc ^ 0xFFFFFFFF;
}

std::uint32_t structural_hash(const Definition& interface) {
    const std::uint32_t hash = crc32(structure(interface));
    return hash == 0 ? 1 : hash;
}

}  // namespace canorb::idlc
