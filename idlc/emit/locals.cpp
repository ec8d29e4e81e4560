#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "idlc/emit/pieces.hpp"
#include "idlc/emit/text.hpp"

namespace canorb::idlc::emit {

namespace {

using Operations = std::set<const model::Operation*>;

const model::Interface& body_of(const model::Definition& interface) {
    return std::get<model::Interface>(interface.body);
}

bool is_local(const model::Definition* interface) {
    return body_of(*interface).kind == model::InterfaceKind::local;
}

/// All operations that an interface has, inherited ones too.
void collect(const model::Definition& interface, Operations& operations) {
    for (const model::InheritedOperation& entry : model::inherited_operations(body_of(interface))) {
        operations.insert(entry.operation);
    }
    for (const model::Operation& own : body_of(interface).operations) operations.insert(&own);
}

/// The operations that the class itself declares: its own, and those of bases that are not local,
/// whose classes are stubs.
std::vector<const model::Operation*> declared_operations(const model::Definition& interface) {
    const model::Interface& body = body_of(interface);
    Operations inherited;
    for (const model::Definition* base : body.bases) {
        if (is_local(base)) collect(*base, inherited);
    }
    std::vector<const model::Operation*> operations;
    for (const model::InheritedOperation& entry : model::inherited_operations(body)) {
        if (inherited.count(entry.operation) == 0) operations.push_back(entry.operation);
    }
    for (const model::Operation& own : body.operations) operations.push_back(&own);
    return operations;
}

constexpr std::string_view class_piece = R"(
// $place$
$comment$
class $name$$bases$ {
  public:
    virtual ~$name$() = default;
$types$
$operations$};
)";

std::string bases(const model::Definition& interface, const Names& names) {
    std::vector<std::string> list;
    for (const model::Definition* base : body_of(interface).bases) {
        if (!is_local(base)) continue;
        list.push_back("public virtual " + names.spell(*base, beside(interface)));
    }
    return list.empty() ? "" : " : " + join(list, ", ");
}

std::string members(const model::Definition& interface, const Names& names) {
    const Context context = in_servant(interface);
    std::string text;
    for (const model::Operation* operation : declared_operations(interface)) {
        if (text.empty() || !operation->comment.empty()) text += '\n';
        text += comment(operation->comment) +
                remarked("virtual " + signature(*operation, names, context, context) + " = 0;",
                         place(operation->provenance) + raised_remark(*operation, names, context));
    }
    return indent(text);
}

}  // namespace

std::string local_declaration(const model::Definition& interface, const std::vector<Step>& steps,
                              const Names& names) {
    return fill(class_piece, {{"place", place(interface.provenance)},
                              {"comment", comment(interface.comment)},
                              {"name", names.own(interface)},
                              {"bases", bases(interface, names)},
                              {"types", nested_types(interface, steps, names)},
                              {"operations", members(interface, names)}});
}

}  // namespace canorb::idlc::emit
