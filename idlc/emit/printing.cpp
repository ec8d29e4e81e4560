#include <string>
#include <vector>

#include "idlc/emit/text.hpp"
#include "idlc/emit/type_pieces.hpp"

namespace canorb::idlc::emit {

namespace {

constexpr std::string_view print_piece = R"(
template <canorb::OutputStream Stream>
Stream& operator<<(Stream& out, $parameter$) {
    return canorb::$call$;
}
)";

/// `begin`, the parts and `end`, as few lines as it goes.
std::string call(const std::string& begin, const std::vector<std::string>& parts,
                 const std::string& end) {
    constexpr std::size_t return_columns = 18;  // "    return canorb::"
    return begin + folded(parts, return_columns + begin.size(), "    ") + end;
}

template <typename Entry>
std::vector<std::string> named(const std::vector<Entry>& entries, const std::string& type) {
    std::vector<std::string> pairs;
    for (const Entry& entry : entries) {
        pairs.push_back('{' + type + "::" + identifier(entry.name) + ", \"" + entry.name + "\"}");
    }
    return pairs;
}

}  // namespace

std::string printing(const model::Definition& definition, const Names& names) {
    const std::string name = names.spell(definition, around_codec(definition));
    if (const auto* body = std::get_if<model::Enum>(&definition.body)) {
        return fill(print_piece, {{"parameter", name + " value"},
                                  {"call", call("print_enumerator(out, value, {",
                                                named(body->enumerators, name), "})")}});
    }
    if (const auto* body = std::get_if<model::Bitmask>(&definition.body)) {
        return fill(print_piece,
                    {{"parameter", name + " value"},
                     {"call", call("print_flags(out, value, {", named(body->flags, name), "})")}});
    }
    const bool has_members = std::holds_alternative<model::Struct>(definition.body) ||
                             std::holds_alternative<model::Exception>(definition.body);
    if (!has_members || !is_sendable(definition)) return {};
    std::vector<std::string> parts{"out"};
    for (const model::Member* member : all_members(definition)) {
        parts.push_back('"' + member->name + "\", value." + member_name(definition, *member));
    }
    return fill(print_piece,
                {{"parameter", "const " + name + (parts.size() == 1 ? "&" : "& value")},
                 {"call", call("print_members(", parts, ")")}});
}

}  // namespace canorb::idlc::emit
