#include "idlc/emit/emit.hpp"

#include <algorithm>
#include <functional>
#include <vector>

#include "idlc/emit/names.hpp"
#include "idlc/emit/order.hpp"
#include "idlc/emit/pieces.hpp"
#include "idlc/emit/text.hpp"

namespace canorb::idlc::emit {

namespace {

using Steps = std::vector<Step>;
using Leaf = std::function<std::string(const Step&)>;

/// The modules around a definition, from the outside, as C++ calls them.
std::vector<std::string> namespaces_of(const model::Definition& definition, const Names& names) {
    std::vector<std::string> path;
    for (const model::Definition* at = in_namespace_of(definition).around; at != nullptr;
         at = at->parent) {
        path.insert(path.begin(), names.own(*at));
    }
    return path;
}

/// Puts declarations into their namespaces, which it opens and closes as they come.
class NamespaceWriter {
  public:
    void add(const std::vector<std::string>& path, const std::string& declaration) {
        if (declaration.empty()) return;
        const auto [common, ours] =
            std::mismatch(open_.begin(), open_.end(), path.begin(), path.end());
        close(static_cast<std::size_t>(common - open_.begin()));
        // Constants and aliases stand close together.
        const bool is_line = declaration.find('\n') == declaration.size() - 1;
        if (!text_.empty() && !(after_line_ && is_line && ours == path.end())) text_ += '\n';
        for (auto name = ours; name != path.end(); ++name) {
            text_ += "namespace " + *name + " {\n\n";
            open_.push_back(*name);
        }
        text_ += declaration;
        after_line_ = is_line;
    }

    std::string finish() {
        close(0);
        return std::move(text_);
    }

  private:
    void close(std::size_t depth) {
        while (open_.size() > depth) {
            text_ += "\n}  // namespace " + open_.back() + '\n';
            open_.pop_back();
            after_line_ = false;
        }
    }

    std::string text_;
    std::vector<std::string> open_;
    bool after_line_ = false;
};

/// What `leaf` gives for each step, in namespaces; empty where it gives nothing at all.
std::string in_namespaces(const Steps& steps, const Names& names, const Leaf& leaf) {
    NamespaceWriter writer;
    for (const Step& step : steps) {
        writer.add(namespaces_of(*step.definition, names), leaf(step));
    }
    return writer.finish();
}

const model::Interface* as_interface(const model::Definition& definition) {
    return std::get_if<model::Interface>(&definition.body);
}

bool is_local(const Step& step) {
    const model::Interface* interface = as_interface(*step.definition);
    return interface != nullptr && interface->kind == model::InterfaceKind::local;
}

/// An interface that has a stub and a servant.
bool is_remote(const Step& step) {
    return as_interface(*step.definition) != nullptr && !is_local(step);
}

std::string named(const model::Definition& definition, const Names& names) {
    const bool is_struct = std::holds_alternative<model::Struct>(definition.body);
    return (is_struct ? "struct " : "class ") + names.own(definition) + ";\n";
}

std::string declared(const Step& step, const Steps& steps, const Names& names) {
    const model::Definition& definition = *step.definition;
    if (step.kind == Step::Kind::declare) return named(definition, names);
    if (const auto* forward = std::get_if<model::Forward>(&definition.body)) {
        return named(*forward->definition, names);
    }
    std::string text;
    if (step.kind == Step::Kind::behind) {
        const std::string name = names.spell(definition, in_namespace_of(definition));
        text = type_declaration(definition, names, name);
    } else if (step.kind == Step::Kind::define) {
        text = as_interface(definition) == nullptr
                   ? type_declaration(definition, names, names.own(definition))
               : is_local(step) ? local_declaration(definition, steps, names)
                                : stub_declaration(definition, steps, names);
    }
    return text + codec_declaration(definition, names);
}

std::string base_name(const std::string& path) {
    const std::size_t slash = path.rfind('/');
    return slash == std::string::npos ? path : path.substr(slash + 1);
}

/// `#include "other.hpp"` for each "other.idl" that the main file includes.
std::string included_headers(const model::Model& model) {
    std::string text;
    const bool has_orb_idl = std::any_of(
        model.storage.begin(), model.storage.end(),
        [](const auto& definition) { return definition->provenance.file == "<orb.idl>"; });
    if (has_orb_idl) text = "#include <canorb/corba.hpp>\n";
    for (const std::string& spelled : model.includes) {
        // The generated files do not lie as the IDL files do: the name is what they share.
        const bool elsewhere = spelled.starts_with('/') || spelled.starts_with("../");
        const std::string file = elsewhere ? base_name(spelled) : spelled;
        const std::size_t dot = file.rfind('.');
        if (dot == std::string::npos || file.substr(dot) != ".idl") continue;
        text += "#include \"" + file.substr(0, dot) + ".hpp\"\n";
    }
    return text;
}

std::string section(const std::string& title, const std::string& text) {
    if (text.empty()) return {};
    return "\n// " + title + "\n\n" + text;
}

constexpr std::string_view header_piece = R"(
// Generated by canorb-idlc from $file$. Changes would be lost: change $file$.
// clang-format off
#pragma once

$canorb_includes$
$gap$
$includes$

// Parameters are called as in the IDL, whatever else is called so.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"
)";

constexpr std::string_view source_piece = R"(
// Generated by canorb-idlc from $file$. Changes would be lost: change $file$.
// clang-format off
#include "$stem$.hpp"

#include <utility>

#pragma GCC diagnostic ignored "-Wshadow"
)";

}  // namespace

GeneratedCode generate(const model::Model& model, const std::string& stem) {
    const Names names{model};
    const Steps steps = cpp_order(model.definitions);
    const auto all = [&](const Leaf& leaf) { return in_namespaces(steps, names, leaf); };
    const auto interfaces = [&](const auto& piece) {
        return all([&](const Step& step) {
            return is_remote(step) ? piece(*step.definition) : std::string{};
        });
    };
    const std::string file = base_name(model.main_file);
    const std::string includes = included_headers(model);
    const bool calls = std::any_of(steps.begin(), steps.end(), is_remote);

    GeneratedCode code;
    code.header = fill(header_piece, {{"file", file},
                                      {"canorb_includes", calls ? "#include <canorb/servant.hpp>\n"
                                                                  "#include <canorb/stub.hpp>\n"
                                                                  "#include <canorb/types.hpp>"
                                                                : "#include <canorb/types.hpp>"},
                                      {"gap", includes.empty() ? "" : "\n"},
                                      {"includes", includes}});
    code.header += section(calls ? "Types and stubs." : "Types.",
                           all([&](const Step& step) { return declared(step, steps, names); }));
    code.header += section("Servants: derive from these.", interfaces([&](const auto& interface) {
                               return servant_declaration(interface, names);
                           }));

    code.header +=
        section("Operations.",
                interfaces([&](const auto& interface) { return operations(interface, names); }));
    code.header += section("Asynchronous calls.", interfaces([&](const auto& interface) {
                               return asynchronous_definitions(interface, names);
                           }));

    code.header += "\n#pragma GCC diagnostic pop\n";

    code.source = fill(source_piece, {{"file", file}, {"stem", stem}});
    code.source += section("Codec.", all([&](const Step& step) {
                               return step.kind == Step::Kind::declare
                                          ? std::string{}
                                          : codec_definition(*step.definition, names);
                           }));
    code.source += section("Stubs.", interfaces([&](const auto& interface) {
                               return stub_definition(interface, names);
                           }));
    code.source += section("Servants.", interfaces([&](const auto& interface) {
                               return servant_definition(interface, names);
                           }));
    return code;
}

}  // namespace canorb::idlc::emit
