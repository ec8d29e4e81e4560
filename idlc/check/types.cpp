#include <algorithm>
#include <utility>

#include "idlc/check/checker.hpp"
#include "idlc/check/constants.hpp"

namespace canorb::idlc::check {

namespace {

/// What the largest message could not hold.
constexpr std::uint64_t most_array_elements = 65535;

model::TypeKind basic(ast::TypeKind kind) {
    switch (kind) {
        case ast::TypeKind::boolean:
            return model::TypeKind::boolean;
        case ast::TypeKind::character:
            return model::TypeKind::character;
        case ast::TypeKind::octet:
            return model::TypeKind::octet;
        case ast::TypeKind::int8:
            return model::TypeKind::int8;
        case ast::TypeKind::uint8:
            return model::TypeKind::uint8;
        case ast::TypeKind::int16:
            return model::TypeKind::int16;
        case ast::TypeKind::uint16:
            return model::TypeKind::uint16;
        case ast::TypeKind::int32:
            return model::TypeKind::int32;
        case ast::TypeKind::uint32:
            return model::TypeKind::uint32;
        case ast::TypeKind::int64:
            return model::TypeKind::int64;
        case ast::TypeKind::uint64:
            return model::TypeKind::uint64;
        case ast::TypeKind::float32:
            return model::TypeKind::float32;
        case ast::TypeKind::float64:
            return model::TypeKind::float64;
        case ast::TypeKind::object:
            return model::TypeKind::object;
        case ast::TypeKind::string:
            return model::TypeKind::string;
        case ast::TypeKind::sequence:
            return model::TypeKind::sequence;
        case ast::TypeKind::name:
            break;
    }
    return model::TypeKind::named;
}

/// How many elements a value of the type has if it is an array, of arrays perhaps.
std::uint64_t elements(const model::Type& type) {
    const model::Type& known = model::resolved(type);
    return known.kind == model::TypeKind::array ? known.bound * elements(*known.element) : 1;
}

bool is_constant_type(const model::Type& type) {
    switch (type.kind) {
        case model::TypeKind::object:
        case model::TypeKind::sequence:
        case model::TypeKind::array:
            return false;
        case model::TypeKind::named:
            return std::holds_alternative<model::Enum>(type.definition->body);
        default:
            return true;
    }
}

}  // namespace

std::optional<model::Type> Checker::type(const ast::Type& written, Scope& scope) {
    if (written.kind == ast::TypeKind::name) return named_type(written, scope);
    model::Type type;
    type.kind = basic(written.kind);
    if (written.bound) {
        const std::optional<std::uint32_t> bound = this->bound(*written.bound, scope);
        if (!bound) return std::nullopt;
        type.bound = *bound;
    }
    if (!written.element.empty()) {
        std::optional<model::Type> element = this->type(written.element.front(), scope);
        if (!element) return std::nullopt;
        type.element = std::make_shared<const model::Type>(*std::move(element));
    }
    return type;
}

std::optional<model::Type> Checker::named_type(const ast::Type& written, Scope& scope) {
    const Symbol* symbol = resolve(scope, written.name, "type", diagnostics_);
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
    const bool is_struct = std::holds_alternative<model::Struct>(symbol->definition->body);
    if (is_struct && incomplete_.count(symbol->definition) != 0) {
        diagnostics_.error(written.where, quote(symbol->name) +
                                              " contains itself: recursive types are not "
                                              "supported yet");
        return std::nullopt;
    }
    model::Type type;
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
        const std::uint64_t inner = elements(element);
        if (*bound > most_array_elements || *bound * inner > most_array_elements) {
            diagnostics_.error(size->where, "an array of more than " +
                                                std::to_string(most_array_elements) +
                                                " elements is larger than any message");
            return std::nullopt;
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
    type.kind = model::TypeKind::uint32;
    const std::optional<model::Value> value = this->value(expression, type, scope);
    if (!value) return std::nullopt;
    const auto number = static_cast<std::uint32_t>(std::get<std::uint64_t>(*value));
    if (number == 0) {
        diagnostics_.error(expression.where, "a bound or size is at least 1");
        return std::nullopt;
    }
    return number;
}

std::optional<model::Value> Checker::value(const ast::Expression& expression,
                                           const model::Type& type, Scope& scope) {
    if (!is_constant_type(type)) {
        diagnostics_.error(expression.where, "there are no constants of this type");
        return std::nullopt;
    }
    const auto find = [&](const ast::ScopedName& name) { return named_value(name, scope); };
    return evaluate(expression, type, find, diagnostics_);
}

std::optional<model::Value> Checker::named_value(const ast::ScopedName& name, Scope& scope) {
    const Symbol* symbol = resolve(scope, name, "constant", diagnostics_);
    if (symbol == nullptr) return std::nullopt;
    if (symbol->kind == Symbol::Kind::enumerator) {
        return model::EnumeratorValue{symbol->definition, symbol->enumerator};
    }
    if (symbol->kind == Symbol::Kind::constant && symbol->definition != nullptr) {
        const auto* constant = std::get_if<model::Constant>(&symbol->definition->body);
        // One without a value was reported where it is declared.
        if (constant == nullptr) return std::nullopt;
        return constant->value;
    }
    diagnostics_.error(name.where(), quote(symbol->name) + " is not a constant");
    diagnostics_.note(symbol->where, "declared here");
    return std::nullopt;
}

void Checker::require_complete(const model::Type& type, Location where,
                               const model::Definition& owner) {
    const model::Type& known = model::resolved(type);
    if (known.element != nullptr) return require_complete(*known.element, where, owner);
    if (known.kind != model::TypeKind::named || is_complete(*known.definition)) return;
    waits_.push_back({&owner, known.definition, where});
}

bool Checker::is_complete(const model::Definition& definition) const {
    if (incomplete_.count(&definition) != 0) return false;
    return std::all_of(waits_.begin(), waits_.end(), [&](const Wait& wait) {
        return wait.owner != &definition || is_complete(*wait.needed);
    });
}

void Checker::check_waits() {
    for (const Wait& wait : waits_) {
        // The generated header can turn round the order of what stands side by side, no more.
        const bool in_module = wait.owner->parent == nullptr ||
                               std::holds_alternative<model::Module>(wait.owner->parent->body);
        if (in_module && wait.owner->parent == wait.needed->parent &&
            wait.owner->provenance.file == wait.needed->provenance.file) {
            continue;
        }
        diagnostics_.error(wait.where, quote(wait.needed->name) + " must be defined before " +
                                           quote(wait.owner->name) +
                                           " contains it, or behind it in the same module");
    }
}

}  // namespace canorb::idlc::check
