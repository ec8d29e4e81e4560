#include "idlc/ast.hpp"

#include <type_traits>

namespace canorb::idlc::ast {

namespace {

std::string_view name(TypeKind kind) {
    switch (kind) {
        case TypeKind::boolean:
            return "boolean";
        case TypeKind::character:
            return "char";
        case TypeKind::octet:
            return "octet";
        case TypeKind::int8:
            return "int8";
        case TypeKind::uint8:
            return "uint8";
        case TypeKind::int16:
            return "int16";
        case TypeKind::uint16:
            return "uint16";
        case TypeKind::int32:
            return "int32";
        case TypeKind::uint32:
            return "uint32";
        case TypeKind::int64:
            return "int64";
        case TypeKind::uint64:
            return "uint64";
        case TypeKind::float32:
            return "float";
        case TypeKind::float64:
            return "double";
        case TypeKind::object:
            return "Object";
        case TypeKind::string:
            return "string";
        case TypeKind::sequence:
            return "sequence";
        case TypeKind::name:
            break;
    }
    return "";
}

std::string_view symbol(Operator op) {
    switch (op) {
        case Operator::literal:
        case Operator::name:
            break;
        case Operator::plus:
        case Operator::add:
            return "+";
        case Operator::negate:
        case Operator::subtract:
            return "-";
        case Operator::complement:
            return "~";
        case Operator::bit_or:
            return "|";
        case Operator::bit_xor:
            return "^";
        case Operator::bit_and:
            return "&";
        case Operator::shift_left:
            return "<<";
        case Operator::shift_right:
            return ">>";
        case Operator::multiply:
            return "*";
        case Operator::divide:
            return "/";
        case Operator::modulo:
            return "%";
    }
    return "";
}

std::string to_string(const Literal& literal) {
    return std::visit(
        [](const auto& value) -> std::string {
            using T = std::decay_t<decltype(value)>;
            if constexpr (std::is_same_v<T, bool>) {
                return value ? "TRUE" : "FALSE";
            } else if constexpr (std::is_same_v<T, char>) {
                return std::string{"'"} + value + "'";
            } else if constexpr (std::is_same_v<T, StringLiteral>) {
                return '"' + value.value + '"';
            } else {
                return std::to_string(value);
            }
        },
        literal);
}

std::string to_string(const Expression& expression) {
    if (expression.op == Operator::literal) return to_string(expression.literal);
    if (expression.op == Operator::name) return to_string(expression.name);
    std::string text{"("};
    text += symbol(expression.op);
    for (const Expression& operand : expression.operands) text += ' ' + to_string(operand);
    return text + ')';
}

std::string to_string(const Type& type) {
    if (type.kind == TypeKind::name) return to_string(type.name);
    std::string arguments;
    if (!type.element.empty()) arguments = to_string(type.element.front());
    if (type.bound) arguments += (arguments.empty() ? "" : ", ") + to_string(*type.bound);
    std::string text{name(type.kind)};
    return arguments.empty() ? text : text + '<' + arguments + '>';
}

std::string dimensions(const std::vector<Expression>& sizes) {
    std::string text;
    for (const Expression& size : sizes) text += '[' + to_string(size) + ']';
    return text;
}

std::string names(std::string_view before, const std::vector<ScopedName>& list,
                  std::string_view after) {
    if (list.empty()) return {};
    std::string text{before};
    for (const ScopedName& name : list) {
        if (&name != &list.front()) text += ", ";
        text += to_string(name);
    }
    text += after;
    return text;
}

class Dump {
  public:
    void declarations(const std::vector<Declaration>& list) {
        for (const Declaration& declaration : list) {
            for (const std::string& comment : declaration.comment) line(comment);
            for (const Annotation& annotation : declaration.annotations) {
                std::string arguments;
                for (const Expression& argument : annotation.arguments) {
                    arguments += (arguments.empty() ? "" : ", ") + to_string(argument);
                }
                line('@' + annotation.name.text + '(' + arguments + ')');
            }
            std::visit([&](const auto& body) { show(declaration.name.text, body); },
                       declaration.body);
        }
    }

    std::string text;

  private:
    void line(const std::string& content) { text += std::string(2 * depth_, ' ') + content + '\n'; }
    void nested(const std::vector<Declaration>& list) {
        ++depth_;
        declarations(list);
        --depth_;
    }
    void members(const std::vector<Member>& list) {
        ++depth_;
        for (const Member& member : list) {
            for (const std::string& comment : member.comment) line(comment);
            line(to_string(member.type) + ' ' + member.name.text + dimensions(member.dimensions));
        }
        --depth_;
    }

    void show(const std::string& name, const Module& module) {
        line("module " + name);
        nested(module.declarations);
    }
    void show(const std::string& name, const Constant& constant) {
        line("const " + to_string(constant.type) + ' ' + name + " = " + to_string(constant.value));
    }
    void show(const std::string& name, const Enum& enumeration) {
        std::string enumerators;
        for (const Enumerator& enumerator : enumeration.enumerators) {
            enumerators += ' ' + enumerator.name.text;
        }
        line("enum " + name + ':' + enumerators);
    }
    void show(const std::string& name, const Struct& structure) {
        line("struct " + name);
        members(structure.members);
    }
    void show(const std::string& name, const Exception& exception) {
        line("exception " + name);
        members(exception.members);
    }
    void show(const std::string& name, const Alias& alias) {
        line("typedef " + to_string(alias.type) + ' ' + name + dimensions(alias.dimensions));
    }
    void show(const std::string& name, const ForwardInterface&) {
        line("interface " + name + " (forward)");
    }
    void show(const std::string& name, const Interface& interface) {
        line("interface " + name + names(": ", interface.bases, ""));
        nested(interface.body);
    }
    void show(const std::string& name, const Attribute& attribute) {
        line(std::string{attribute.readonly ? "readonly " : ""} + "attribute " +
             to_string(attribute.type) + ' ' + name +
             names(" getraises (", attribute.get_raises, ")") +
             names(" setraises (", attribute.set_raises, ")"));
    }
    void show(const std::string& name, const Operation& operation) {
        std::string parameters;
        for (const Parameter& parameter : operation.parameters) {
            constexpr std::string_view directions[] = {"in ", "out ", "inout "};
            if (!parameters.empty()) parameters += ", ";
            parameters += directions[static_cast<std::size_t>(parameter.direction)];
            parameters += to_string(parameter.type) + ' ' + parameter.name.text;
        }
        line(std::string{operation.oneway ? "oneway " : ""} +
             (operation.result ? to_string(*operation.result) : "void") + ' ' + name + '(' +
             parameters + ')' + names(" raises (", operation.raises, ")"));
    }

    std::size_t depth_ = 0;
};

}  // namespace

std::string to_string(const ScopedName& name) {
    std::string text;
    for (const Identifier& part : name.parts) {
        if (name.global || !text.empty()) text += "::";
        text += part.text;
    }
    return text;
}

std::string dump(const File& file) {
    Dump dump;
    dump.declarations(file.declarations);
    return dump.text;
}

}  // namespace canorb::idlc::ast
