#include "idlc/emit/names.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <type_traits>

#include "idlc/emit/text.hpp"

namespace canorb::idlc::emit {

namespace {

using model::TypeKind;

// C++'s keywords, the macros that standard headers define in lower case or that old compilers
// predefine, and the two namespaces that generated code relies on.
constexpr std::array reserved = {"alignas",       "alignof",     "and",
                                 "and_eq",        "asm",         "auto",
                                 "bitand",        "bitor",       "bool",
                                 "break",         "case",        "catch",
                                 "char",          "char16_t",    "char32_t",
                                 "char8_t",       "class",       "co_await",
                                 "co_return",     "co_yield",    "compl",
                                 "concept",       "const",       "const_cast",
                                 "consteval",     "constexpr",   "constinit",
                                 "continue",      "decltype",    "default",
                                 "delete",        "do",          "double",
                                 "dynamic_cast",  "else",        "enum",
                                 "explicit",      "export",      "extern",
                                 "false",         "float",       "for",
                                 "friend",        "goto",        "if",
                                 "inline",        "int",         "long",
                                 "mutable",       "namespace",   "new",
                                 "noexcept",      "not",         "not_eq",
                                 "nullptr",       "operator",    "or",
                                 "or_eq",         "private",     "protected",
                                 "public",        "register",    "reinterpret_cast",
                                 "requires",      "return",      "short",
                                 "signed",        "sizeof",      "static",
                                 "static_assert", "static_cast", "struct",
                                 "switch",        "template",    "this",
                                 "thread_local",  "throw",       "true",
                                 "try",           "typedef",     "typeid",
                                 "typename",      "union",       "unsigned",
                                 "using",         "virtual",     "void",
                                 "volatile",      "wchar_t",     "while",
                                 "xor",           "xor_eq",      "assert",
                                 "errno",         "linux",       "unix",
                                 "stdin",         "stdout",      "stderr",
                                 "EOF",           "NULL",        "std",
                                 "canorb"};

// What a stub inherits from ObjectRef and so finds before the names of its namespace.
constexpr std::array object_ref_members = {
    "ObjectRef", "is_nil", "is_group",         "node",  "index", "group", "type_id", "with_timeout",
    "with_sent", "narrow", "unchecked_narrow", "invoke"};

template <std::size_t N>
bool contains(const std::array<const char*, N>& words, std::string_view word) {
    return std::find(words.begin(), words.end(), word) != words.end();
}

std::string escape(std::string_view name) {
    return "_cxx_" + std::string{name};
}

bool is_interface(const model::Definition* definition) {
    return definition != nullptr && std::holds_alternative<model::Interface>(definition->body);
}

/// The interface and all that it inherits.
void collect_lineage(const model::Definition* interface,
                     std::vector<const model::Definition*>& lineage) {
    if (std::find(lineage.begin(), lineage.end(), interface) != lineage.end()) return;
    lineage.push_back(interface);
    for (const model::Definition* base : std::get<model::Interface>(interface->body).bases) {
        collect_lineage(base, lineage);
    }
}

std::string_view basic_type(TypeKind kind) {
    switch (kind) {
        case TypeKind::boolean:
            return "bool";
        case TypeKind::character:
            return "char";
        case TypeKind::wide_character:
            return "char16_t";
        case TypeKind::octet:
        case TypeKind::uint8:
            return "std::uint8_t";
        case TypeKind::int8:
            return "std::int8_t";
        case TypeKind::int16:
            return "std::int16_t";
        case TypeKind::uint16:
            return "std::uint16_t";
        case TypeKind::int32:
            return "std::int32_t";
        case TypeKind::uint32:
            return "std::uint32_t";
        case TypeKind::int64:
            return "std::int64_t";
        case TypeKind::uint64:
            return "std::uint64_t";
        case TypeKind::float32:
            return "float";
        case TypeKind::float64:
            return "double";
        case TypeKind::float128:
            return "long double";
        case TypeKind::any:
            return "canorb::Any";
        case TypeKind::object:
            return "canorb::ObjectRef";
        case TypeKind::type_code:
            return "canorb::TypeCode";
        case TypeKind::string:
            return "std::string";
        case TypeKind::wide_string:
            return "std::u16string";
        default:
            return "";
    }
}

/// One character inside of a literal that `quote` delimits.
std::string literal_character(char c, char quote) {
    // "??/" would look like a trigraph.
    if (c == quote || c == '\\' || (c == '?' && quote == '"')) return std::string{'\\', c};
    if (c >= ' ' && c <= '~') return std::string{c};
    // Three octal digits: a digit that follows is not taken for one of them.
    const auto octet = static_cast<unsigned char>(c);
    return std::string{'\\', static_cast<char>('0' + (octet >> 6)),
                       static_cast<char>('0' + ((octet >> 3) & 7)),
                       static_cast<char>('0' + (octet & 7))};
}

std::string quoted(std::string_view text) {
    std::string literal{'"'};
    for (const char c : text) literal += literal_character(c, '"');
    return literal + '"';
}

/// A literal of UTF-16 units; `quote` delimits it.
std::string wide_literal(std::u16string_view text, char quote) {
    constexpr std::string_view digits = "0123456789ABCDEF";
    std::string literal{'u', quote};
    for (const char16_t unit : text) {
        if (unit < 0x80) {
            literal += literal_character(static_cast<char>(unit), quote);
            continue;
        }
        // Not \u: it cannot say half of a pair. Octal: a digit that follows could be taken for one
        // of \x.
        const bool small = unit < 01000;
        literal += small ? "\\" : "\" u\"\\x";
        for (int shift = small ? 6 : 12; shift >= 0; shift -= small ? 3 : 4) {
            literal += digits[static_cast<std::size_t>((unit >> shift) & (small ? 7 : 15))];
        }
        if (!small) literal += "\" u\"";
    }
    return literal + quote;
}

std::string floating(long double value, TypeKind kind) {
    std::array<char, 64> buffer{};
    char* const last = buffer.data() + buffer.size();
    const auto [end, error] =
        kind == TypeKind::float32   ? std::to_chars(buffer.data(), last, static_cast<float>(value))
        : kind == TypeKind::float64 ? std::to_chars(buffer.data(), last, static_cast<double>(value))
                                    : std::to_chars(buffer.data(), last, value);
    std::string text{buffer.data(), end};
    if (text.find_first_of(".e") == std::string::npos) text += ".0";
    if (kind == TypeKind::float32) text += 'F';
    if (kind == TypeKind::float128) text += 'L';
    return text;
}

}  // namespace

std::string identifier(std::string_view idl_name) {
    return contains(reserved, idl_name) ? escape(idl_name) : std::string{idl_name};
}

Context beside(const model::Definition& definition) {
    const model::Definition* around = definition.parent;
    return {is_interface(around) ? Context::Kind::in_stub : Context::Kind::in_namespace, around};
}

Context in_namespace_of(const model::Definition& definition) {
    const model::Definition* around = definition.parent;
    while (around != nullptr && !std::holds_alternative<model::Module>(around->body)) {
        around = around->parent;
    }
    return {Context::Kind::in_namespace, around};
}

Context in_stub(const model::Definition& interface) {
    return {Context::Kind::in_stub, &interface};
}

Context in_servant(const model::Definition& interface) {
    return {Context::Kind::in_servant, &interface};
}

Names::Names(const model::Model& model) {
    for (const auto& definition : model.storage) {
        const std::string path = this->path(definition.get());
        declared_.insert(path);
        const auto* interface = std::get_if<model::Interface>(&definition->body);
        if (interface == nullptr) continue;
        for (const model::Operation& operation : interface->operations) {
            operations_.insert(path + "::" + identifier(operation.name));
        }
    }
    for (const auto& definition : model.storage) {
        if (is_interface(definition.get())) name_asynchronous(*definition);
    }
}

// As CORBA's asynchronous messaging does it. Names of bases count: nothing that is inherited is to
// be hidden.
void Names::name_asynchronous(const model::Definition& interface) {
    const auto& operations = std::get<model::Interface>(interface.body).operations;
    if (operations.empty() || asynchronous_.count(&operations.front()) != 0) return;
    std::vector<const model::Definition*> lineage;
    collect_lineage(&interface, lineage);
    for (const model::Definition* base : lineage) {
        if (base != &interface) name_asynchronous(*base);
    }
    const auto is_taken = [&](const std::string& name) {
        return std::any_of(lineage.begin(), lineage.end(), [&](const model::Definition* one) {
            const std::string member = path(one) + "::" + name;
            return own(*one) == name || operations_.count(member) != 0 ||
                   declared_.count(member) != 0;
        });
    };
    for (const model::Operation& operation : operations) {
        if (operation.oneway) continue;
        std::string name = operation.kind == model::OperationKind::get   ? "get_" + operation.name
                           : operation.kind == model::OperationKind::set ? "set_" + operation.name
                                                                         : operation.name;
        while (is_taken("sendp_" + name) || is_taken("sendc_" + name)) name = "ami_" + name;
        operations_.insert(path(&interface) + "::sendp_" + name);
        operations_.insert(path(&interface) + "::sendc_" + name);
        asynchronous_[&operation] = std::move(name);
    }
}

std::string Names::asynchronous(const model::Operation& operation) const {
    return asynchronous_.at(&operation);
}

std::string Names::own(const model::Definition& definition) const {
    const std::string& name = definition.name;
    const bool is_module = std::holds_alternative<model::Module>(definition.body);
    // IDL that belongs to the ORB itself is in its namespace.
    if (is_module && definition.parent == nullptr && name == "canorb") return name;
    // The codec's functions must not be hidden by a type.
    if (name == "encode" || name == "decode") return escape(name);
    return identifier(name);
}

std::string Names::path(const model::Definition* definition) const {
    if (definition == nullptr) return {};
    return path(definition->parent) + "::" + own(*definition);
}

std::string Names::lookup_in_interface(std::string_view name, const model::Definition& interface,
                                       bool stub) const {
    std::vector<const model::Definition*> lineage;
    collect_lineage(&interface, lineage);
    for (const model::Definition* one : lineage) {
        const std::string path = this->path(one);
        const std::string member = path + "::" + std::string{name};
        if (operations_.count(member) != 0) return "an operation";
        if (stub && declared_.count(member) != 0) return member;
        if (stub && own(*one) == name) return path;
        if (!stub && own(*one) + "Servant" == name) return "a servant";
    }
    const bool has_base =
        std::get<model::Interface>(interface.body).kind != model::InterfaceKind::local;
    if (stub && has_base && contains(object_ref_members, name)) return "a member of ObjectRef";
    if (!stub && name == "Servant") return "the base of all servants";
    return {};
}

std::string Names::lookup(std::string_view name, const Context& context) const {
    if (std::find(context.hidden.begin(), context.hidden.end(), name) != context.hidden.end()) {
        return "a parameter or member";
    }
    bool stub = context.kind != Context::Kind::in_servant;
    for (const model::Definition* around = context.around;; around = around->parent) {
        if (is_interface(around)) {
            std::string found = lookup_in_interface(name, *around, stub);
            if (!found.empty()) return found;
            stub = true;
            continue;
        }
        std::string member = path(around) + "::" + std::string{name};
        if (declared_.count(member) != 0) return member;
        if (around == nullptr) return {};
        // A struct's or union's own name is found within it.
        const bool is_class = !std::holds_alternative<model::Module>(around->body);
        if (is_class && own(*around) == name) return path(around);
    }
}

std::string Names::spell(const model::Definition& definition, const Context& context) const {
    std::string spelled;
    for (const model::Definition* at = &definition; at != nullptr; at = at->parent) {
        const std::string name = own(*at);
        spelled = spelled.empty() ? name : name + "::" + spelled;
        if (lookup(name, context) == path(at)) return spelled;
    }
    return "::" + spelled;
}

std::string Names::type(const model::Type& type, const Context& context) const {
    const std::string bound = std::to_string(type.bound);
    switch (type.kind) {
        case TypeKind::named: {
            const auto* interface = std::get_if<model::Interface>(&type.definition->body);
            const bool local =
                interface != nullptr && interface->kind == model::InterfaceKind::local;
            const std::string name = spell(*type.definition, context);
            return local ? "std::shared_ptr<" + name + '>' : name;
        }
        case TypeKind::array:
            return "std::array<" + this->type(*type.element, context) + ", " + bound + '>';
        case TypeKind::sequence:
            if (model::is_inline(type)) {
                return "canorb::BoundedVector<" + this->type(*type.element, context) + ", " +
                       bound + '>';
            }
            return "std::vector<" + this->type(*type.element, context) + '>';
        case TypeKind::map:
            return "std::map<" + this->type(*type.key, context) + ", " +
                   this->type(*type.element, context) + '>';
        case TypeKind::fixed:
            return "canorb::Fixed<" + std::to_string(type.digits) + ", " +
                   std::to_string(type.scale) + '>';
        case TypeKind::string:
            if (model::is_inline(type)) return "canorb::BoundedString<" + bound + '>';
            break;
        default:
            break;
    }
    return std::string{basic_type(type.kind)};
}

std::string Names::variable(const model::Type& type, std::string_view name,
                            const Context& context) const {
    const bool is_array = model::resolved(type).kind == TypeKind::array;
    return this->type(type, context) + ' ' + std::string{name} +
           (is_array || model::is_scalar(type) ? "{};" : ";");
}

std::string Names::parameter(const model::Parameter& parameter, const Context& context) const {
    std::string type = this->type(parameter.type, context);
    if (parameter.direction != model::Direction::in) {
        type += '&';
    } else if (!model::is_scalar(parameter.type)) {
        type = "const " + type + '&';
    }
    return type + ' ' + identifier(parameter.name);
}

std::string Names::value(const model::Value& value, const model::Type& type,
                         const Context& context) const {
    const model::Type& known = model::resolved(type);
    return std::visit(
        [&](const auto& one) -> std::string {
            using T = std::decay_t<decltype(one)>;
            if constexpr (std::is_same_v<T, bool>) {
                return one ? "true" : "false";
            } else if constexpr (std::is_same_v<T, char>) {
                return '\'' + literal_character(one, '\'') + '\'';
            } else if constexpr (std::is_same_v<T, char16_t>) {
                return one < 0x80 ? wide_literal({&one, 1}, '\'')
                                  : "char16_t{" + std::to_string(unsigned{one}) + '}';
            } else if constexpr (std::is_same_v<T, std::string>) {
                return quoted(one);
            } else if constexpr (std::is_same_v<T, std::u16string>) {
                return wide_literal(one, '"');
            } else if constexpr (std::is_same_v<T, long double>) {
                return floating(one, known.kind);
            } else if constexpr (std::is_same_v<T, model::FixedValue>) {
                return this->type(known, context) + "{\"" + one.text + "\"}";
            } else if constexpr (std::is_same_v<T, model::EnumeratorValue>) {
                const auto& body = std::get<model::Enum>(one.enumeration->body);
                return spell(*one.enumeration, context) +
                       "::" + identifier(body.enumerators[one.index].name);
            } else if constexpr (std::is_same_v<T, std::int64_t>) {
                // There is no literal for the lowest, only for one more.
                if (one == std::numeric_limits<std::int64_t>::min()) {
                    return std::to_string(one + 1) + " - 1";
                }
                return std::to_string(one);
            } else {
                const bool wide = one > std::numeric_limits<std::uint32_t>::max() / 2;
                const std::string number = std::to_string(one) + (wide ? "U" : "");
                if (known.kind != TypeKind::named) return number;
                return "static_cast<" + spell(*known.definition, context) + ">(" + number + ')';
            }
        },
        value);
}

namespace {

/// The bounds that the C++ type does not have, as template arguments; empty: it has them all.
std::string bounds_of(const model::Type& type) {
    std::vector<std::string> bounds;
    std::size_t needed = 0;
    const model::Type* at = &model::resolved(type);
    while (at != nullptr && !model::is_inline(*at)) {
        // An array has no bound of its own: its size is part of its type.
        if (at->kind == TypeKind::string || at->kind == TypeKind::wide_string ||
            at->kind == TypeKind::sequence || at->kind == TypeKind::map) {
            bounds.push_back(std::to_string(at->bound));
            if (at->bound != 0) needed = bounds.size();
        }
        // A key has a place of its own where its C++ type is std::string or std::u16string.
        if (at->key != nullptr && !model::is_inline(*at->key)) {
            const model::Type& key = model::resolved(*at->key);
            if (key.kind == TypeKind::string || key.kind == TypeKind::wide_string) {
                bounds.push_back(std::to_string(key.bound));
                if (key.bound != 0) needed = bounds.size();
            }
        }
        at = at->element != nullptr ? &model::resolved(*at->element) : nullptr;
    }
    bounds.resize(needed);
    return join(bounds, ", ");
}

}  // namespace

std::string coded(const model::Type& type, std::string_view value) {
    const std::string bounds = bounds_of(type);
    if (bounds.empty()) return std::string{value};
    return "canorb::ccdr::bounded<" + bounds + ">(" + std::string{value} + ')';
}

std::string coded_type(const model::Type& type, const std::string& spelled) {
    const std::string bounds = bounds_of(type);
    return bounds.empty() ? spelled : "canorb::ccdr::Bounded<" + spelled + ", " + bounds + '>';
}

std::string place(const model::Provenance& provenance) {
    const std::size_t slash = provenance.file.rfind('/');
    return provenance.file.substr(slash == std::string::npos ? 0 : slash + 1) + ':' +
           std::to_string(provenance.line);
}

std::string comment(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) text += line + '\n';
    return text;
}

}  // namespace canorb::idlc::emit
