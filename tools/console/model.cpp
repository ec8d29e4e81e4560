#include "tools/console/model.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <utility>

namespace canorb::console {
namespace {

using Json = nlohmann::json;

constexpr int known_format_version = 1;

constexpr std::pair<std::string_view, Kind> basic_types[] = {
    {"boolean", Kind::boolean},      {"char", Kind::character},
    {"wchar", Kind::wide_character}, {"octet", Kind::uint8},
    {"uint8", Kind::uint8},          {"int8", Kind::int8},
    {"short", Kind::int16},          {"unsigned short", Kind::uint16},
    {"long", Kind::int32},           {"unsigned long", Kind::uint32},
    {"long long", Kind::int64},      {"unsigned long long", Kind::uint64},
    {"float", Kind::float32},        {"double", Kind::float64},
    {"long double", Kind::float128}, {"string", Kind::string},
    {"wstring", Kind::wide_string},  {"any", Kind::any},
    {"TypeCode", Kind::type_code},   {"Object", Kind::object},
};

std::optional<Type> basic_type(std::string_view keywords) {
    const auto* const found =
        std::find_if(std::begin(basic_types), std::end(basic_types),
                     [&](const auto& each) { return each.first == keywords; });
    if (found == std::end(basic_types)) return std::nullopt;
    Type type{.kind = found->second, .name = std::string{keywords}};
    if (type.kind == Kind::object) type.interface_id = corba_object_id;
    return type;
}

std::string bounded(std::string text, std::uint32_t bound) {
    return bound == 0 ? text : text + ", " + std::to_string(bound);
}

/// What an entry says but for where it stands and what is said of it.
Json meaning(Json entry) {
    if (entry.is_object()) {
        for (const char* field : {"comment", "file", "line", "in_main_file"}) entry.erase(field);
    }
    for (auto& each : entry) {
        if (each.is_structured()) each = meaning(std::move(each));
    }
    return entry;
}

bool contains(const Type& type, const Definition& wanted, bool directly,
              std::set<const Definition*>& seen) {
    switch (type.kind) {
        case Kind::sequence:
            return !directly && contains(*type.element, wanted, directly, seen);
        case Kind::map:
            return !directly && (contains(*type.key, wanted, directly, seen) ||
                                 contains(*type.element, wanted, directly, seen));
        case Kind::array:
            return contains(*type.element, wanted, directly, seen);
        case Kind::structure:
        case Kind::choice:
            if (type.definition == &wanted) return true;
            if (!seen.insert(type.definition).second) return false;
            return std::any_of(
                type.definition->members.begin(), type.definition->members.end(),
                [&](const Member& each) { return contains(each.type, wanted, directly, seen); });
        default:
            return false;
    }
}

/// Whether a value of it may contain another one; `directly`: must.
bool contains_itself(const Definition& definition, bool directly) {
    std::set<const Definition*> seen;
    return std::any_of(
        definition.members.begin(), definition.members.end(),
        [&](const Member& each) { return contains(each.type, definition, directly, seen); });
}

/// doc/idl-support.md. Each is written as a text that is no JSON.
bool can_be_key(Kind kind) {
    switch (kind) {
        case Kind::sequence:
        case Kind::map:
        case Kind::array:
        case Kind::structure:
        case Kind::choice:
        case Kind::any:
        case Kind::type_code:
        case Kind::object:
        case Kind::native:
            return false;
        default:
            return true;
    }
}

bool is_discriminator(Kind kind) {
    switch (kind) {
        case Kind::boolean:
        case Kind::character:
        case Kind::wide_character:
        case Kind::uint8:
        case Kind::int8:
        case Kind::int16:
        case Kind::uint16:
        case Kind::int32:
        case Kind::uint32:
        case Kind::int64:
        case Kind::uint64:
        case Kind::enumeration:
            return true;
        default:
            return false;
    }
}

}  // namespace

/// Reads one document into a Model. It throws std::exception for what is none.
class Model::Reader {
  public:
    explicit Reader(Model& model) : model_(model) {}

    void read(const Json& document) {
        for (const char* list : {"interfaces", "types", "exceptions"}) {
            for (const Json& entry : document.at(list)) note(list, entry);
        }
        // Whatever has a name may be used before its own entry.
        for (const auto& [name, entry] : new_interfaces_) {
            Interface& interface = model_.interfaces_[name];
            interface.name = name;
            interface.repository_id = entry->at("repository_id");
        }
        for (const auto& [name, entry] : new_types_) declare(name, *entry);
        for (const auto& [name, entry] : new_types_) resolve_typedef(name, 0);
        for (const auto& [name, entry] : new_types_) define(name, *entry);
        for (const auto& [name, entry] : new_types_) check(name);
        for (const auto& [name, entry] : new_exceptions_) {
            Definition& exception = model_.exceptions_[name];
            exception.name = name;
            exception.repository_id = entry->at("repository_id");
            exception.members = members(entry->at("members"));
        }
        for (const auto& [name, entry] : new_interfaces_) define_interface(name, *entry);
    }

  private:
    using Entries = std::map<std::string, const Json*>;

    void note(std::string_view list, const Json& entry) {
        const std::string name = entry.at("name");
        std::string text = meaning(entry).dump();
        const auto [known, added] = model_.documents_.emplace(name, text);
        if (!added) {
            // An interface that one document only declares, another one may define.
            const bool was_declared = list == "interfaces" && model_.interfaces_.count(name) != 0 &&
                                      !model_.interfaces_.at(name).defined;
            const bool is_declared = list == "interfaces" && !entry.at("defined").get<bool>();
            if (is_declared) return;
            if (!was_declared) {
                if (known->second == text) return;
                throw std::invalid_argument(name + " is declared in another way than before");
            }
            known->second = std::move(text);
        }
        Entries& entries = list == "interfaces" ? new_interfaces_
                           : list == "types"    ? new_types_
                                                : new_exceptions_;
        entries.emplace(name, &entry);
    }

    void declare(const std::string& name, const Json& entry) {
        const std::string kind = entry.at("kind");
        if (kind == "typedef") return;
        static const std::map<std::string, Kind> kinds{{"enum", Kind::enumeration},
                                                       {"bitmask", Kind::bitmask},
                                                       {"struct", Kind::structure},
                                                       {"union", Kind::choice},
                                                       {"native", Kind::native}};
        auto definition = std::make_unique<Definition>();
        definition->name = name;
        definition->repository_id = entry.at("repository_id");
        Type& type = model_.types_[name];
        type.kind = kinds.at(kind);
        type.name = name;
        type.definition = definition.get();
        model_.definitions_[name] = std::move(definition);
    }

    const Type& resolve_typedef(const std::string& name, int depth) {
        if (const auto known = model_.types_.find(name); known != model_.types_.end())
            return known->second;
        constexpr int deepest = 1000;
        const auto entry = new_types_.find(name);
        if (entry == new_types_.end()) throw std::invalid_argument("there is no type " + name);
        if (depth > deepest) throw std::invalid_argument(name + " is a typedef of itself");
        Type type = read_type(entry->second->at("type"), depth + 1);
        type.name = name;
        return model_.types_[name] = std::move(type);
    }

    std::shared_ptr<const Type> read_part(const Json& json, int depth) {
        return std::make_shared<const Type>(read_type(json, depth));
    }

    Type read_type(const Json& json, int depth = 0) {
        constexpr int deepest = 2000;
        if (depth > deepest) throw std::invalid_argument("a type has too many levels");
        const std::string kind = json.at("kind");
        if (kind == "interface") {
            const std::string name = json.at("name");
            const auto found = model_.interfaces_.find(name);
            if (found == model_.interfaces_.end())
                throw std::invalid_argument("there is no interface " + name);
            return {
                .kind = Kind::object, .name = name, .interface_id = found->second.repository_id};
        }
        if (json.contains("name")) return resolve_typedef(json.at("name"), depth);
        const std::uint32_t bound = json.value("bound", std::uint32_t{0});
        if (kind == "sequence") {
            Type type{.kind = Kind::sequence, .bound = bound};
            type.element = read_part(json.at("element"), depth + 1);
            type.name = "sequence<" + bounded(type.element->name, bound) + '>';
            return type;
        }
        if (kind == "map") {
            Type type{.kind = Kind::map, .bound = bound};
            type.key = read_part(json.at("key"), depth + 1);
            type.element = read_part(json.at("element"), depth + 1);
            if (!can_be_key(type.key->kind))
                throw std::invalid_argument(type.key->name + " as a map's key");
            type.name = "map<" + type.key->name + ", " + bounded(type.element->name, bound) + '>';
            return type;
        }
        if (kind == "array") {
            Type type{.kind = Kind::array, .bound = json.at("length")};
            type.element = read_part(json.at("element"), depth + 1);
            if (type.bound == 0) throw std::invalid_argument("an array without elements");
            type.name = type.element->name + '[' + std::to_string(type.bound) + ']';
            return type;
        }
        if (kind == "fixed") {
            Type type{.kind = Kind::fixed, .digits = json.at("digits"), .scale = json.at("scale")};
            constexpr std::uint32_t most_digits = 31;
            if (type.digits < 1 || type.digits > most_digits || type.scale > type.digits)
                throw std::invalid_argument("a fixed that there is not");
            type.name =
                "fixed<" + std::to_string(type.digits) + ", " + std::to_string(type.scale) + '>';
            return type;
        }
        auto type = basic_type(kind);
        if (!type) throw std::invalid_argument("there is no type '" + kind + "'");
        if (bound != 0) {
            type->bound = bound;
            type->name += '<' + std::to_string(bound) + '>';
        }
        return *type;
    }

    std::vector<Member> members(const Json& list) {
        std::vector<Member> result;
        for (const Json& each : list) {
            Member member{.name = each.at("name"), .type = read_type(each.at("type"))};
            if (const auto labels = each.find("labels"); labels != each.end()) {
                for (const Json& label : *labels) {
                    member.labels.push_back(
                        label.is_number_unsigned()
                            ? static_cast<std::int64_t>(label.get<std::uint64_t>())
                            : label.get<std::int64_t>());
                }
                member.is_default = each.at("is_default");
            }
            result.push_back(std::move(member));
        }
        return result;
    }

    void define(const std::string& name, const Json& entry) {
        const auto found = model_.definitions_.find(name);
        if (found == model_.definitions_.end()) return;  // a typedef
        Definition& definition = *found->second;
        switch (model_.types_.at(name).kind) {
            case Kind::enumeration:
                for (const Json& each : entry.at("enumerators"))
                    definition.enumerators.push_back({each.at("name"), each.at("number")});
                if (definition.enumerators.empty())
                    throw std::invalid_argument(name + " has no enumerator");
                break;
            case Kind::bitmask:
                definition.bit_bound = entry.at("bit_bound");
                if (definition.bit_bound < 1 || definition.bit_bound > 64)
                    throw std::invalid_argument(name + " is not of 1 to 64 bits");
                for (const Json& each : entry.at("flags")) {
                    definition.flags.push_back({each.at("name"), each.at("position")});
                    if (definition.flags.back().position >= definition.bit_bound)
                        throw std::invalid_argument(name + " has a flag beyond its bits");
                }
                break;
            case Kind::choice:
                definition.discriminator = read_type(entry.at("discriminator"));
                if (!is_discriminator(definition.discriminator.kind))
                    throw std::invalid_argument(name + " has a discriminator that none can be");
                [[fallthrough]];
            case Kind::structure:
                definition.members = members(entry.at("members"));
                break;
            default:
                break;
        }
    }

    void check(const std::string& name) {
        const auto found = model_.definitions_.find(name);
        if (found == model_.definitions_.end()) return;
        if (contains_itself(*found->second, true))
            throw std::invalid_argument(name + " has itself as a member");
        found->second->is_recursive = contains_itself(*found->second, false);
    }

    void define_interface(const std::string& name, const Json& entry) {
        Interface& interface = model_.interfaces_.at(name);
        interface.is_local = entry.at("kind") == "local";
        interface.defined = entry.at("defined");
        if (interface.is_local) return;
        for (const Json& each : entry.at("operations")) {
            Operation operation{.id = each.at("id"),
                                .name = each.at("name"),
                                .declared_in = each.at("declared_in"),
                                .declared_in_id = {},
                                .oneway = each.at("oneway"),
                                .groupable = each.at("groupable"),
                                .result = {},
                                .parameters = {},
                                .raises = each.at("raises").get<std::vector<std::string>>()};
            const auto declares = model_.interfaces_.find(operation.declared_in);
            if (declares == model_.interfaces_.end())
                throw std::invalid_argument("there is no interface " + operation.declared_in);
            operation.declared_in_id = declares->second.repository_id;
            if (!each.at("result").is_null()) operation.result = read_type(each.at("result"));
            for (const Json& parameter : each.at("parameters")) {
                static const std::map<std::string, Direction> directions{
                    {"in", Direction::in}, {"out", Direction::out}, {"inout", Direction::inout}};
                operation.parameters.push_back({parameter.at("name"),
                                                directions.at(parameter.at("direction")),
                                                read_type(parameter.at("type"))});
            }
            interface.operations.push_back(std::move(operation));
        }
    }

    Model& model_;
    Entries new_interfaces_;
    Entries new_types_;
    Entries new_exceptions_;
};

std::optional<std::string> Model::add(std::string_view json, const std::string& source) {
    const Json document = Json::parse(json, nullptr, false);
    if (!document.is_object() || document.value("format", Json{}) != "canorb-idl")
        return source + " is not what canorb-idlc --emit json writes";
    if (document.value("format_version", Json{}) != known_format_version) {
        return source + " has a format_version that this program does not know; it knows " +
               std::to_string(known_format_version);
    }
    try {
        Reader{*this}.read(document);
    } catch (const std::exception& error) {
        return source + " is not as canorb-idlc writes it: " + error.what();
    }
    return std::nullopt;
}

const Interface* Model::find_interface(std::string_view name_or_id) const {
    for (const auto& [name, interface] : interfaces_) {
        if (name == name_or_id || interface.repository_id == name_or_id) return &interface;
    }
    return nullptr;
}

const Interface* Model::find_interface(std::uint16_t group_key) const {
    for (const auto& [name, interface] : interfaces_) {
        if (InterfaceInfo{interface.repository_id}.group_key() == group_key && interface.defined)
            return &interface;
    }
    return nullptr;
}

const Definition* Model::find_exception(std::string_view repository_id) const {
    for (const auto& [name, exception] : exceptions_) {
        if (exception.repository_id == repository_id) return &exception;
    }
    return nullptr;
}

std::optional<Type> Model::find_type(std::string_view name) const {
    if (auto basic = basic_type(name)) return basic;
    if (const auto found = types_.find(std::string{name}); found != types_.end())
        return found->second;
    if (const auto found = interfaces_.find(std::string{name}); found != interfaces_.end()) {
        return Type{.kind = Kind::object,
                    .name = found->first,
                    .interface_id = found->second.repository_id};
    }
    return std::nullopt;
}

const Type* Model::find_type_by_id(std::string_view repository_id) const {
    for (const auto& [name, definition] : definitions_) {
        if (definition->repository_id == repository_id) return &types_.at(name);
    }
    return nullptr;
}

std::string Operation::signature() const {
    static constexpr std::string_view directions[] = {"in ", "out ", "inout "};
    std::string text = oneway ? "oneway " : "";
    text += (result ? result->name : "void") + ' ' + name + '(';
    std::string_view separator;
    for (const Parameter& each : parameters) {
        text += separator;
        text += directions[static_cast<std::size_t>(each.direction)];
        text += each.type.name + ' ' + each.name;
        separator = ", ";
    }
    text += ')';
    separator = " raises (";
    for (const std::string& each : raises) {
        text += std::string{separator} + each;
        separator = ", ";
    }
    return raises.empty() ? text : text + ')';
}

std::size_t Operation::arguments() const {
    return static_cast<std::size_t>(
        std::count_if(parameters.begin(), parameters.end(),
                      [](const Parameter& each) { return each.direction != Direction::out; }));
}

const Operation* Interface::find(std::string_view wanted, std::size_t arguments) const {
    const std::string attribute =
        std::string{arguments == 0 ? "_get_" : "_set_"} + std::string{wanted};
    const Operation* found = nullptr;
    for (const Operation& each : operations) {
        if (each.name == wanted) return &each;
        if (each.name == attribute) found = &each;
    }
    return found;
}

const Operation* Interface::find(OperationId id) const {
    for (const Operation& each : operations) {
        if (each.id == id) return &each;
    }
    return nullptr;
}

}  // namespace canorb::console
