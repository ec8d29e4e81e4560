#include "idlc/emit/json.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <variant>
#include <vector>

#include "idlc/structure.hpp"

namespace canorb::idlc::emit {

namespace {

using Json = nlohmann::ordered_json;
using model::Definition;
using model::Definitions;
using model::Type;
using model::TypeKind;

/// Of the format, doc/idl-json.md: raised when a reader of the one before would misread it.
constexpr int format_version = 1;

Json type(const Type& what) {
    if (what.kind == TypeKind::named) {
        return {{"kind", kind_of(*what.definition)},
                {"name", model::scoped_name(*what.definition)}};
    }
    Json json{{"kind", keyword(what.kind)}};
    if (what.key) json["key"] = type(*what.key);
    if (what.element) json["element"] = type(*what.element);
    if (what.kind == TypeKind::fixed) {
        json["digits"] = what.digits;
        json["scale"] = what.scale;
    }
    if (what.kind == TypeKind::array) {
        json["length"] = what.bound;
    } else if (what.bound != 0) {
        json["bound"] = what.bound;
    }
    return json;
}

/// Lone surrogates become U+FFFD.
std::string utf8(const std::u16string& units) {
    std::string text;
    const auto trailing = [&text](std::uint32_t code, int octets) {
        for (int i = octets - 1; i >= 0; --i) {
            text += static_cast<char>(0x80U | ((code >> (6 * i)) & 0x3FU));
        }
    };
    for (std::size_t i = 0; i < units.size(); ++i) {
        std::uint32_t code = units[i];
        if (code >= 0xD800 && code <= 0xDFFF) {
            const bool pair = code <= 0xDBFF && i + 1 < units.size() && units[i + 1] >= 0xDC00 &&
                              units[i + 1] <= 0xDFFF;
            code = pair ? 0x10000U + ((code - 0xD800U) << 10) + (units[++i] - 0xDC00U) : 0xFFFDU;
        }
        if (code < 0x80) {
            text += static_cast<char>(code);
        } else if (code < 0x800) {
            text += static_cast<char>(0xC0U | (code >> 6));
            trailing(code, 1);
        } else if (code < 0x10000) {
            text += static_cast<char>(0xE0U | (code >> 12));
            trailing(code, 2);
        } else {
            text += static_cast<char>(0xF0U | (code >> 18));
            trailing(code, 3);
        }
    }
    return text;
}

struct ValueJson {
    TypeKind kind;

    Json operator()(std::int64_t value) const { return value; }
    Json operator()(std::uint64_t value) const { return value; }
    Json operator()(bool value) const { return value; }
    Json operator()(char value) const { return static_cast<unsigned char>(value); }
    Json operator()(char16_t value) const { return static_cast<unsigned>(value); }
    Json operator()(const std::string& value) const { return value; }
    Json operator()(const std::u16string& value) const { return utf8(value); }
    Json operator()(const model::FixedValue& value) const { return value.text; }
    Json operator()(const model::EnumeratorValue& value) const {
        const auto& enumeration = std::get<model::Enum>(value.enumeration->body);
        return enumeration.enumerators.at(value.index).name;
    }
    Json operator()(long double value) const {
        if (kind != TypeKind::float128) return static_cast<double>(value);
        // More digits than a number of JSON keeps.
        std::array<char, 64> text{};
        std::snprintf(text.data(), text.size(), "%.36Lg", value);
        return std::string{text.data()};
    }
};

Json value(const Type& of, const model::Value& what) {
    return std::visit(ValueJson{model::resolved(of).kind}, what);
}

Json label(const model::Value& what) {
    if (const auto* number = std::get_if<std::int64_t>(&what)) return *number;
    if (const auto* number = std::get_if<std::uint64_t>(&what)) return *number;
    return std::stoul(label_number(what));
}

void add_comment(Json& json, const std::vector<std::string>& lines) {
    if (!lines.empty()) json["comment"] = lines;
}

void add_place(Json& json, const model::Provenance& provenance) {
    json["file"] = provenance.file;
    json["line"] = provenance.line;
}

Json member(const model::Member& what) {
    Json json{{"name", what.name}, {"type", type(what.type)}};
    if (what.default_value) json["default"] = value(what.type, *what.default_value);
    add_comment(json, what.comment);
    return json;
}

Json names(const Definitions& definitions) {
    Json json = Json::array();
    for (const Definition* each : definitions) json.push_back(model::scoped_name(*each));
    return json;
}

/// What one definition adds to what all have.
struct Body {
    Json& json;

    void operator()(const model::Enum& enumeration) const {
        Json& list = json["enumerators"] = Json::array();
        for (const model::Enumerator& each : enumeration.enumerators) {
            Json enumerator{{"name", each.name}, {"number", each.number}};
            add_comment(enumerator, each.comment);
            list.push_back(std::move(enumerator));
        }
        json["default"] = enumeration.enumerators.at(enumeration.default_index).name;
    }
    void operator()(const model::Bitmask& bitmask) const {
        json["bit_bound"] = bitmask.bit_bound;
        Json& list = json["flags"] = Json::array();
        for (const model::Flag& each : bitmask.flags) {
            Json flag{{"name", each.name}, {"position", each.position}};
            add_comment(flag, each.comment);
            list.push_back(std::move(flag));
        }
    }
    void operator()(const model::Struct& structure) const {
        if (structure.base != nullptr) json["base"] = model::scoped_name(*structure.base);
        Json& list = json["members"] = Json::array();
        for (const model::Member* each : all_members(structure)) list.push_back(member(*each));
    }
    void operator()(const model::Exception& exception) const {
        Json& list = json["members"] = Json::array();
        for (const model::Member& each : exception.members) list.push_back(member(each));
    }
    void operator()(const model::Union& choice) const {
        json["discriminator"] = type(choice.discriminator);
        Json& list = json["members"] = Json::array();
        for (const model::UnionCase& each : choice.cases) {
            Json one = member(each.member);
            Json& labels = one["labels"] = Json::array();
            for (const model::Value& number : each.labels) labels.push_back(label(number));
            one["is_default"] = each.is_default;
            list.push_back(std::move(one));
        }
    }
    void operator()(const model::Alias& alias) const { json["type"] = type(alias.type); }
    void operator()(const model::Constant& constant) const {
        json["type"] = type(constant.type);
        json["value"] = value(constant.type, constant.value);
    }
    void operator()(const model::Unusable&) const {}
    void operator()(const model::Module&) const {}
    void operator()(const model::Forward&) const {}
    void operator()(const model::Interface&) const {}
};

Json operation(const model::InheritedOperation& entry) {
    static constexpr std::string_view kinds[] = {"operation", "get", "set"};
    static constexpr std::string_view directions[] = {"in", "out", "inout"};
    const model::Operation& what = *entry.operation;
    const auto& interface = std::get<model::Interface>(entry.interface->body);
    const bool has_id = interface.kind != model::InterfaceKind::local;
    Json json{{"id", has_id ? Json(what.id) : Json{}},
              {"name", model::wire_name(what)},
              {"kind", kinds[static_cast<std::size_t>(what.kind)]},
              {"declared_in", model::scoped_name(*entry.interface)},
              {"oneway", what.oneway},
              {"groupable", model::groupable(what)},
              {"result", what.result ? type(*what.result) : Json{}}};
    Json& parameters = json["parameters"] = Json::array();
    for (const model::Parameter& each : what.parameters) {
        parameters.push_back({{"name", each.name},
                              {"direction", directions[static_cast<std::size_t>(each.direction)]},
                              {"type", type(each.type)}});
    }
    json["raises"] = names(what.raises);
    add_comment(json, what.comment);
    add_place(json, what.provenance);
    return json;
}

Json interface(const Definition& definition, bool defined) {
    static constexpr std::string_view kinds[] = {"plain", "local", "abstract"};
    const auto& body = std::get<model::Interface>(definition.body);
    Json json{{"name", model::scoped_name(definition)},
              {"repository_id", definition.repository_id},
              {"kind", kinds[static_cast<std::size_t>(body.kind)]},
              {"defined", defined},
              {"structural_hash", defined ? structural_hash(definition) : 0},
              {"group_key", group_key(definition)},
              {"bases", names(body.bases)}};
    std::vector<model::InheritedOperation> all = model::inherited_operations(body);
    for (const model::Operation& own : body.operations) all.push_back({&definition, &own});
    if (body.kind != model::InterfaceKind::local) {
        std::sort(all.begin(), all.end(),
                  [](const auto& a, const auto& b) { return a.operation->id < b.operation->id; });
    }
    Json& operations = json["operations"] = Json::array();
    for (const model::InheritedOperation& each : all) operations.push_back(operation(each));
    return json;
}

class Document {
  public:
    explicit Document(const model::Model& model) {
        json_["format"] = "canorb-idl";
        json_["format_version"] = format_version;
        json_["main_file"] = model.main_file;
        for (const char* list : {"interfaces", "types", "exceptions", "constants"}) {
            json_[list] = Json::array();
        }
        collect(model.definitions);
        add(model.definitions);
    }

    std::string text() const {
        constexpr int indentation = 2;
        return json_.dump(indentation, ' ', false, Json::error_handler_t::replace) + '\n';
    }

  private:
    /// At any depth.
    void collect(const Definitions& definitions) {
        for (const Definition* each : definitions) {
            if (std::holds_alternative<model::Forward>(each->body)) continue;
            defined_.insert(each);
            std::visit(
                [this](const auto& body) {
                    if constexpr (requires { body.definitions; }) collect(body.definitions);
                },
                each->body);
        }
    }

    void add(const Definitions& definitions) {
        for (const Definition* each : definitions) add(*each);
    }

    void add(const Definition& definition) {
        if (const auto* module = std::get_if<model::Module>(&definition.body)) {
            return add(module->definitions);
        }
        if (const auto* forward = std::get_if<model::Forward>(&definition.body)) {
            // What is defined behind it comes in its own place.
            if (defined_.count(forward->definition) == 0) add(*forward->definition);
            return;
        }
        if (!seen_.insert(&definition).second) return;
        // What stands inside of a type is needed to read it.
        std::visit(
            [this](const auto& body) {
                if constexpr (requires { body.definitions; }) add(body.definitions);
            },
            definition.body);
        Json json;
        if (std::holds_alternative<model::Interface>(definition.body)) {
            json = interface(definition, defined_.count(&definition) != 0);
        } else {
            json["name"] = model::scoped_name(definition);
            json["repository_id"] = definition.repository_id;
            if (!std::holds_alternative<model::Constant>(definition.body) &&
                !std::holds_alternative<model::Exception>(definition.body)) {
                json["kind"] = kind_of(definition);
            }
            std::visit(Body{json}, definition.body);
        }
        add_comment(json, definition.comment);
        add_place(json, definition.provenance);
        json["in_main_file"] = definition.in_main_file;
        json_[list_of(definition)].push_back(std::move(json));
    }

    static const char* list_of(const Definition& definition) {
        if (std::holds_alternative<model::Interface>(definition.body)) return "interfaces";
        if (std::holds_alternative<model::Exception>(definition.body)) return "exceptions";
        if (std::holds_alternative<model::Constant>(definition.body)) return "constants";
        return "types";
    }

    Json json_;
    std::set<const Definition*> defined_;
    std::set<const Definition*> seen_;
};

}  // namespace

std::string json(const model::Model& model) {
    return Document{model}.text();
}

}  // namespace canorb::idlc::emit
