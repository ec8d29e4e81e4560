#include <algorithm>
#include <limits>
#include <utility>

#include "idlc/check/checker.hpp"
#include "idlc/check/constants.hpp"

namespace canorb::idlc::check {

namespace {

/// What the largest message could not hold.
constexpr std::uint64_t most_array_elements = 65535;

model::TypeKind basic(ast::TypeKind kind) {
    using From = ast::TypeKind;
    using To = model::TypeKind;
    switch (kind) {
        case From::boolean:
            return To::boolean;
        case From::character:
            return To::character;
        case From::wide_character:
            return To::wide_character;
        case From::octet:
            return To::octet;
        case From::int8:
            return To::int8;
        case From::uint8:
            return To::uint8;
        case From::int16:
            return To::int16;
        case From::uint16:
            return To::uint16;
        case From::int32:
            return To::int32;
        case From::uint32:
            return To::uint32;
        case From::int64:
            return To::int64;
        case From::uint64:
            return To::uint64;
        case From::float32:
            return To::float32;
        case From::float64:
            return To::float64;
        case From::float128:
            return To::float128;
        case From::fixed:
            return To::fixed;
        case From::any:
            return To::any;
        case From::object:
            return To::object;
        case From::string:
            return To::string;
        case From::wide_string:
            return To::wide_string;
        case From::sequence:
            return To::sequence;
        case From::map:
            return To::map;
        case From::name:
            break;
    }
    return To::named;
}

bool is_within_corba(const Scope& scope) {
    for (const Scope* at = &scope; at != nullptr; at = at->parent()) {
        if (at->kind() == Scope::Kind::module && at->name() == "CORBA") return true;
    }
    return false;
}

/// What a name stands for that nobody declared: IDL 4's integers, and what CORBA declares itself.
std::optional<model::TypeKind> predefined(const ast::ScopedName& name, const Scope& scope) {
    constexpr std::pair<std::string_view, model::TypeKind> types[] = {
        {"int8", model::TypeKind::int8},
        {"uint8", model::TypeKind::uint8},
        {"int16", model::TypeKind::int16},
        {"uint16", model::TypeKind::uint16},
        {"int32", model::TypeKind::int32},
        {"uint32", model::TypeKind::uint32},
        {"int64", model::TypeKind::int64},
        {"uint64", model::TypeKind::uint64},
        {"CORBA::TypeCode", model::TypeKind::type_code},
        {"CORBA::Object", model::TypeKind::object},
    };
    const std::string written = ast::to_string(name);
    for (const auto& [known, kind] : types) {
        if (written == known || written == "::" + std::string{known}) return kind;
    }
    if (written == "TypeCode" && is_within_corba(scope)) return model::TypeKind::type_code;
    return std::nullopt;
}

/// How many elements a value of the type has if it is an array, of arrays perhaps.
std::uint64_t elements(const model::Type& type) {
    const model::Type& known = model::resolved(type);
    if (known.kind != model::TypeKind::array) return 1;
    return known.bound * std::min(elements(*known.element), most_array_elements + 1);
}

bool is_constant_type(const model::Type& type) {
    switch (type.kind) {
        case model::TypeKind::any:
        case model::TypeKind::object:
        case model::TypeKind::type_code:
        case model::TypeKind::sequence:
        case model::TypeKind::map:
        case model::TypeKind::array:
            return false;
        case model::TypeKind::named:
            return std::holds_alternative<model::Enum>(type.definition->body) ||
                   std::holds_alternative<model::Bitmask>(type.definition->body);
        default:
            return true;
    }
}

}  // namespace

const Symbol* Checker::find(Scope& scope, const ast::ScopedName& name, std::string_view what) {
    if (!name.global && is_declared(scope, name)) scope.use(name.parts.front());
    return resolve(scope, name, what, diagnostics_);
}

std::optional<model::Type> Checker::type(const ast::Type& written, Scope& scope) {
    if (written.kind == ast::TypeKind::name) return named_type(written, scope);
    model::Type type;
    type.kind = basic(written.kind);
    if (!arguments(written, type, scope)) return std::nullopt;
    return type;
}

bool Checker::arguments(const ast::Type& written, model::Type& type, Scope& scope) {
    if (written.kind == ast::TypeKind::fixed) {
        if (!written.bound || !written.scale) return true;  // of a constant
        const auto digits = this->digits(*written.bound, scope);
        const auto scale = this->digits(*written.scale, scope);
        if (!digits || !scale) return false;
        type.digits = *digits;
        type.scale = *scale;
        if (type.digits != 0 && type.scale <= type.digits) return true;
        diagnostics_.error(written.bound->where,
                           "a fixed has 1 to 31 digits, and at most all of them behind the point");
        return false;
    }
    if (written.bound) {
        const std::optional<std::uint32_t> bound = this->bound(*written.bound, scope);
        if (!bound) return false;
        type.bound = *bound;
    }
    std::vector<std::shared_ptr<const model::Type>> elements;
    for (const ast::Type& element : written.elements) {
        std::optional<model::Type> checked = this->type(element, scope);
        if (!checked) return false;
        elements.push_back(std::make_shared<const model::Type>(*std::move(checked)));
    }
    if (!elements.empty()) type.element = elements.back();
    if (elements.size() < 2) return true;
    type.key = elements.front();
    if (is_key(*type.key)) return true;
    diagnostics_.error(written.elements.front().where,
                       "the keys of a map are integers, octets, characters, booleans, strings, "
                       "enums, bitmasks or fixed");
    return false;
}

bool Checker::is_key(const model::Type& type) const {
    const model::Type& known = model::resolved(type);
    switch (known.kind) {
        case model::TypeKind::float32:
        case model::TypeKind::float64:
        case model::TypeKind::float128:
            return false;
        default:
            return is_constant_type(known);
    }
}

std::optional<model::Type> Checker::named_type(const ast::Type& written, Scope& scope) {
    model::Type type;
    if (const auto kind = predefined(written.name, scope)) {
        // A module CORBA of a file is without what the compiler knows itself.
        const bool qualified = written.name.parts.size() > 1;
        const Symbol* around = qualified && is_declared(scope, written.name)
                                   ? find(scope, {written.name.global, {written.name.parts[0]}}, "")
                                   : nullptr;
        const bool declared = qualified
                                  ? around != nullptr && around->scope != nullptr &&
                                        around->scope->own(written.name.parts[1].text) != nullptr
                                  : is_declared(scope, written.name);
        if (!declared) {
            type.kind = *kind;
            return type;
        }
    }
    const Symbol* symbol = find(scope, written.name, "type");
    if (symbol == nullptr) return std::nullopt;
    if (symbol->kind != Symbol::Kind::type || symbol->definition == nullptr) {
        diagnostics_.error(written.where,
                           quote(symbol->name) +
                               (symbol->kind == Symbol::Kind::exception
                                    ? " is an exception: it can be raised, but is no type of values"
                                    : " is not a type"));
        diagnostics_.note(symbol->where, "declared here");
        return std::nullopt;
    }
    if (const auto* unusable = std::get_if<model::Unusable>(&symbol->definition->body)) {
        diagnostics_.error(written.where, quote(symbol->name) + " is " +
                                              std::string{unusable->kind} +
                                              ": such types can be declared, but not used (see "
                                              "doc/idl-support.md)");
        diagnostics_.note(symbol->where, "declared here");
        return std::nullopt;
    }
    type.kind = model::TypeKind::named;
    type.definition = symbol->definition;
    return type;
}

std::optional<model::Type> Checker::array(model::Type element,
                                          const std::vector<ast::Expression>& dimensions,
                                          Scope& scope) {
    // The last dimension is the innermost array.
    for (auto size = dimensions.rbegin(); size != dimensions.rend(); ++size) {
        const std::optional<std::uint32_t> bound = this->bound(*size, scope);
        if (!bound) return std::nullopt;
        // The product of few large sizes can be larger than any integer.
        const std::uint64_t inner = std::min(elements(element), most_array_elements + 1);
        if (*bound * inner > most_array_elements) {
            add_obstacle(size->where, "an array of more than " +
                                          std::to_string(most_array_elements) +
                                          " elements is larger than any message");
        }
        model::Type type;
        type.kind = model::TypeKind::array;
        type.bound = *bound;
        type.element = std::make_shared<const model::Type>(std::move(element));
        element = std::move(type);
    }
    return element;
}

std::optional<std::uint32_t> Checker::bound(const ast::Expression& expression, Scope& scope) {
    model::Type type;
    type.kind = model::TypeKind::int64;
    const std::optional<model::Value> value = this->value(expression, type, scope);
    if (!value) return std::nullopt;
    const auto number = std::get<std::int64_t>(*value);
    if (number < 1 || number > std::numeric_limits<std::uint32_t>::max()) {
        diagnostics_.error(expression.where, number < 1 ? "a bound or size is at least 1"
                                                        : "a bound or size has 32 bits at most");
        return std::nullopt;
    }
    return static_cast<std::uint32_t>(number);
}

std::optional<std::uint16_t> Checker::digits(const ast::Expression& expression, Scope& scope) {
    constexpr std::uint64_t most_digits = 31;
    model::Type type;
    type.kind = model::TypeKind::uint32;
    const std::optional<model::Value> value = this->value(expression, type, scope);
    if (!value) return std::nullopt;
    const std::uint64_t number = std::get<std::uint64_t>(*value);
    if (number > most_digits) {
        diagnostics_.error(expression.where, "a fixed has at most 31 digits");
        return std::nullopt;
    }
    return static_cast<std::uint16_t>(number);
}

std::optional<model::Value> Checker::value(const ast::Expression& expression,
                                           const model::Type& type, Scope& scope) {
    const model::Type& known = model::resolved(type);
    if (!is_constant_type(known)) {
        diagnostics_.error(expression.where, "there are no constants of this type");
        return std::nullopt;
    }
    const auto find = [&](const ast::ScopedName& name) { return named_value(name, scope); };
    return evaluate(expression, known, find, diagnostics_);
}

std::optional<model::Value> Checker::named_value(const ast::ScopedName& name, Scope& scope) {
    const Symbol* symbol = find(scope, name, "constant");
    if (symbol == nullptr) return std::nullopt;
    if (symbol->kind == Symbol::Kind::enumerator && symbol->definition != nullptr) {
        if (const auto* mask = std::get_if<model::Bitmask>(&symbol->definition->body)) {
            return std::uint64_t{1} << mask->flags[symbol->enumerator].position;
        }
        return model::EnumeratorValue{symbol->definition, symbol->enumerator};
    }
    if (symbol->kind == Symbol::Kind::constant && symbol->definition != nullptr) {
        const auto* constant = std::get_if<model::Constant>(&symbol->definition->body);
        // One without a value was reported where it is declared.
        if (constant == nullptr) return std::nullopt;
        return constant->value;
    }
    if (symbol->kind == Symbol::Kind::constant) return std::nullopt;
    diagnostics_.error(name.where(), quote(symbol->name) + " is not a constant");
    diagnostics_.note(symbol->where, "declared here");
    return std::nullopt;
}

bool Checker::require_complete(const model::Type& type, Location where) {
    const model::Type* at = &model::resolved(type);
    bool behind_sequence = false;
    while (at->element != nullptr) {
        behind_sequence = behind_sequence || at->kind != model::TypeKind::array;
        at = &model::resolved(*at->element);
    }
    if (at->kind != model::TypeKind::named || incomplete_.count(at->definition) == 0 ||
        std::holds_alternative<model::Interface>(at->definition->body)) {
        return true;
    }
    const bool is_open = open_.count(at->definition) != 0;
    // Through a sequence a type may contain itself.
    if (is_open && behind_sequence) return true;
    diagnostics_.error(where, quote(at->definition->name) +
                                  (is_open ? " cannot contain itself, but a sequence of itself"
                                           : " must be defined before it is used"));
    return false;
}

}  // namespace canorb::idlc::check
