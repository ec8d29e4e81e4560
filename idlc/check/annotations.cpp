#include <algorithm>
#include <utility>

#include "idlc/check/checker.hpp"

namespace canorb::idlc::check {

namespace {

struct Known {
    std::string_view name;
    std::string_view place;  ///< where it belongs
};

constexpr Known known_annotations[] = {
    {"first_operation", "the definition of an interface"},
    {"oneway", "an operation"},
    {"default", "a member of a struct, union or exception"},
    {"default_literal", "an enumerator"},
    {"value", "an enumerator"},
    {"bit_bound", "an enum or bitmask"},
    {"position", "a flag of a bitmask"},
};

/// Those of IDL 4.2 and DDS-XTypes that only describe: what is sent is the same with and without.
constexpr std::string_view describing_annotations[] = {
    "ami",
    "autoid",
    "data_representation",
    "final",
    "hashid",
    "id",
    "ignore_literal_names",
    "key",
    "max",
    "min",
    "must_understand",
    "nested",
    "range",
    "service",
    "topic",
    "try_construct",
    "unit",
    "verbatim",
};

}  // namespace

void Checker::check_annotations(const std::vector<ast::Annotation>& annotations,
                                std::initializer_list<std::string_view> acted_on, Scope& scope) {
    std::vector<std::string> seen;
    for (const ast::Annotation& annotation : annotations) {
        const std::string name = ast::to_string(annotation.name);
        const Location where = annotation.name.where();
        if (std::find(acted_on.begin(), acted_on.end(), name) != acted_on.end()) {
            if (std::find(seen.begin(), seen.end(), name) != seen.end()) {
                diagnostics_.error(where, '@' + name + " is written once");
            }
            seen.push_back(name);
            continue;
        }
        const auto* const known =
            std::find_if(std::begin(known_annotations), std::end(known_annotations),
                         [&](const Known& one) { return one.name == name; });
        if (known != std::end(known_annotations)) {
            std::string problem = '@' + name + " belongs before " + std::string{known->place};
            // Before a typedef it is good IDL, but C++'s aliases have no values of their own.
            if (name == "default") {
                diagnostics_.warning(where, problem + ": it is ignored");
            } else {
                diagnostics_.error(where, std::move(problem));
            }
            continue;
        }
        if (std::find(std::begin(describing_annotations), std::end(describing_annotations), name) !=
            std::end(describing_annotations)) {
            continue;
        }
        ast::ScopedName declared = annotation.name;
        declared.parts.back().text.insert(0, 1, '@');
        bool found = false;
        for (const Scope* at = &scope; at != nullptr && !found; at = at->parent()) {
            found = at->own(declared.parts.back().text) != nullptr;
        }
        if (found || (declared.parts.size() > 1 && is_declared(scope, declared))) continue;
        std::string text = "the annotation @" + name + " is ignored";
        for (const Known& one : known_annotations) {
            if (name.size() <= 2 * one.name.size() && distance(lower_case(name), one.name) <= 2) {
                text += "; did you mean @" + std::string{one.name} + '?';
                break;
            }
        }
        diagnostics_.warning(where, std::move(text));
    }
}

std::optional<model::Value> Checker::annotation_value(
    const std::vector<ast::Annotation>& annotations, std::string_view name, const model::Type& type,
    Scope& scope) {
    const auto found =
        std::find_if(annotations.begin(), annotations.end(),
                     [&](const ast::Annotation& one) { return ast::to_string(one.name) == name; });
    if (found == annotations.end()) return std::nullopt;
    const bool is_value =
        found->arguments.size() == 1 &&
        (!found->arguments.front().name || found->arguments.front().name->text == "value");
    if (!is_value) {
        diagnostics_.error(found->name.where(), '@' + std::string{name} +
                                                    " is written with one value: @" +
                                                    std::string{name} + "(...)");
        return std::nullopt;
    }
    return value(found->arguments.front().value, type, scope);
}

std::optional<unsigned> Checker::annotation_number(const std::vector<ast::Annotation>& annotations,
                                                   std::string_view name, unsigned lowest,
                                                   unsigned highest, Scope& scope) {
    model::Type type;
    type.kind = model::TypeKind::int64;
    const auto value = annotation_value(annotations, name, type, scope);
    if (!value) return std::nullopt;
    const std::int64_t number = std::get<std::int64_t>(*value);
    if (number >= std::int64_t{lowest} && number <= std::int64_t{highest})
        return static_cast<unsigned>(number);
    const auto found =
        std::find_if(annotations.begin(), annotations.end(),
                     [&](const ast::Annotation& one) { return ast::to_string(one.name) == name; });
    diagnostics_.error(found->arguments.front().value.where, '@' + std::string{name} + " is " +
                                                                 std::to_string(lowest) + " to " +
                                                                 std::to_string(highest) + " here");
    return std::nullopt;
}

bool Checker::annotation_flag(const std::vector<ast::Annotation>& annotations,
                              std::string_view name) {
    for (const ast::Annotation& annotation : annotations) {
        if (ast::to_string(annotation.name) != name) continue;
        if (annotation.arguments.empty()) return true;
        const ast::Expression& value = annotation.arguments.front().value;
        const auto* flag = std::get_if<bool>(&value.literal);
        if (annotation.arguments.size() == 1 && value.op == ast::Operator::literal &&
            flag != nullptr) {
            return *flag;
        }
        diagnostics_.error(annotation.name.where(),
                           '@' + std::string{name} +
                               " is written without a value, or with TRUE or "
                               "FALSE");
    }
    return false;
}

}  // namespace canorb::idlc::check
