#include "idlc/ast.hpp"

#include <array>
#include <charconv>
#include <cstdio>
#include <type_traits>

namespace canorb::idlc::ast {

namespace {

std::string_view name(TypeKind kind) {
    switch (kind) {
        case TypeKind::boolean:
            return "boolean";
        case TypeKind::character:
            return "char";
        case TypeKind::wide_character:
            return "wchar";
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
        case TypeKind::float128:
            return "long double";
        case TypeKind::fixed:
            return "fixed";
        case TypeKind::any:
            return "any";
        case TypeKind::object:
            return "Object";
        case TypeKind::string:
            return "string";
        case TypeKind::wide_string:
            return "wstring";
        case TypeKind::sequence:
            return "sequence";
        case TypeKind::map:
            return "map";
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

/// Hexadecimal digits, as many as asked for.
std::string hex(unsigned value, int digits) {
    std::string text;
    for (int shift = 4 * (digits - 1); shift >= 0; shift -= 4) {
        text += "0123456789abcdef"[(value >> shift) & 0xF];
    }
    return text;
}

/// What is not printable ASCII as an escape.
template <typename Text>
std::string quoted(const Text& content, char quote) {
    std::string text{quote};
    for (const auto unit : content) {
        const auto value = static_cast<unsigned>(
            static_cast<std::make_unsigned_t<std::decay_t<decltype(unit)>>>(unit));
        if (value == '\\' || value == static_cast<unsigned char>(quote)) text += '\\';
        if (value >= ' ' && value < 127) {
            text += static_cast<char>(value);
        } else if (value == '\n') {
            text += "\\n";
        } else {
            text += sizeof unit == 1 ? "\\x" + hex(value, 2) : "\\u" + hex(value, 4);
        }
    }
    return text + quote;
}

/// The shortest digits that read as the same double. Numbers that no double holds have the digits
/// that any machine's long double has.
std::string to_string(long double value) {
    std::array<char, 64> buffer{};
    const auto narrow = static_cast<double>(value);
    const bool fits = value == 0 || (narrow != 0 && narrow - narrow == 0);
    if (!fits) {
        std::snprintf(buffer.data(), buffer.size(), "%.15Lg", value);
        return buffer.data();
    }
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), narrow).ptr;
    std::string text{buffer.data(), end};
    return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

std::string to_string(const Literal& literal) {
    return std::visit(
        [](const auto& value) -> std::string {
            using T = std::decay_t<decltype(value)>;
            if constexpr (std::is_same_v<T, bool>) {
                return value ? "TRUE" : "FALSE";
            } else if constexpr (std::is_same_v<T, char>) {
                return quoted(std::string_view{&value, 1}, '\'');
            } else if constexpr (std::is_same_v<T, StringLiteral>) {
                return quoted(value.value, '"');
            } else if constexpr (std::is_same_v<T, WideCharacterLiteral>) {
                return 'L' + quoted(std::u16string_view{&value.value, 1}, '\'');
            } else if constexpr (std::is_same_v<T, WideStringLiteral>) {
                return 'L' + quoted(value.value, '"');
            } else if constexpr (std::is_same_v<T, FixedLiteral>) {
                return value.digits + 'd';
            } else if constexpr (std::is_same_v<T, long double>) {
                return to_string(value);
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
    const auto add = [&](const std::string& argument) {
        arguments += (arguments.empty() ? "" : ", ") + argument;
    };
    for (const Type& element : type.elements) add(to_string(element));
    if (type.bound) add(to_string(*type.bound));
    if (type.scale) add(to_string(*type.scale));
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

std::string to_string(const Annotation& annotation) {
    std::string text = '@' + to_string(annotation.name);
    std::string arguments;
    for (const AnnotationArgument& argument : annotation.arguments) {
        if (!arguments.empty()) arguments += ", ";
        if (argument.name) arguments += argument.name->text + " = ";
        arguments += to_string(argument.value);
    }
    return arguments.empty() ? text : text + '(' + arguments + ')';
}

/// All on the line of what they belong to, each with a space behind it.
std::string inlined(const std::vector<Annotation>& annotations) {
    std::string text;
    for (const Annotation& annotation : annotations) text += to_string(annotation) + ' ';
    return text;
}

std::string to_string(const std::vector<Enumerator>& enumerators) {
    std::string text;
    for (const Enumerator& enumerator : enumerators) {
        text += ' ' + inlined(enumerator.annotations) + enumerator.name.text;
    }
    return text;
}

std::string_view prefix(InterfaceKind kind) {
    switch (kind) {
        case InterfaceKind::plain:
            break;
        case InterfaceKind::local:
            return "local ";
        case InterfaceKind::abstract:
            return "abstract ";
    }
    return "";
}

std::string contexts(const std::vector<std::string>& list) {
    std::string text;
    for (const std::string& one : list) text += (text.empty() ? "" : ", ") + quoted(one, '"');
    return text.empty() ? text : " context (" + text + ')';
}

class Dump {
  public:
    void declarations(const std::vector<Declaration>& list) {
        for (const Declaration& declaration : list) {
            before(declaration.comment, declaration.annotations);
            std::visit([&](const auto& body) { show(declaration.name.text, body); },
                       declaration.body);
        }
    }

    std::string text;

  private:
    void line(const std::string& content) { text += std::string(2 * depth_, ' ') + content + '\n'; }
    void before(const std::vector<std::string>& comments,
                const std::vector<Annotation>& annotations) {
        for (const std::string& comment : comments) line(comment);
        for (const Annotation& annotation : annotations) line(to_string(annotation));
    }
    void nested(const std::vector<Declaration>& list) {
        ++depth_;
        declarations(list);
        --depth_;
    }
    void member(const std::string& label, const Member& member) {
        declarations(member.declared);
        before(member.comment, member.annotations);
        line(label + to_string(member.type) + ' ' + member.name.text +
             dimensions(member.dimensions) +
             (member.default_value ? " default " + to_string(*member.default_value) : ""));
    }
    void members(const std::vector<Member>& list) {
        ++depth_;
        for (const Member& one : list) member("", one);
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
        line("enum " + name + ':' + to_string(enumeration.enumerators));
    }
    void show(const std::string& name, const Bitmask& bitmask) {
        line("bitmask " + name + ':' + to_string(bitmask.flags));
    }
    void show(const std::string& name, const Struct& structure) {
        line("struct " + name + (structure.base ? ": " + to_string(*structure.base) : ""));
        members(structure.members);
    }
    void show(const std::string& name, const Union& one) {
        line("union " + name + " switch (" + inlined(one.discriminator_annotations) +
             to_string(one.discriminator) + ')');
        nested(one.declared);
        ++depth_;
        for (const UnionCase& branch : one.cases) {
            std::string labels;
            for (const UnionLabel& label : branch.labels) {
                labels += label.value ? "case " + to_string(*label.value) : "default";
                labels += ": ";
            }
            member(labels, branch.member);
        }
        --depth_;
    }
    void show(const std::string& name, const Exception& exception) {
        line("exception " + name);
        members(exception.members);
    }
    void show(const std::string& name, const Alias& alias) {
        line("typedef " + to_string(alias.type) + ' ' + name + dimensions(alias.dimensions));
    }
    void show(const std::string& name, const Native&) { line("native " + name); }
    void show(const std::string& name, const ValueType&) { line("valuetype " + name); }
    void show(const std::string& name, const ForwardStruct&) {
        line("struct " + name + " (forward)");
    }
    void show(const std::string& name, const ForwardUnion&) {
        line("union " + name + " (forward)");
    }
    void show(const std::string& name, const ForwardInterface& interface) {
        line(std::string{prefix(interface.kind)} + "interface " + name + " (forward)");
    }
    void show(const std::string& name, const Interface& interface) {
        line(std::string{prefix(interface.kind)} + "interface " + name +
             names(": ", interface.bases, ""));
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
            parameters += inlined(parameter.annotations);
            parameters += directions[static_cast<std::size_t>(parameter.direction)];
            parameters += to_string(parameter.type) + ' ' + parameter.name.text;
        }
        line(std::string{operation.oneway ? "oneway " : ""} +
             (operation.result ? to_string(*operation.result) : "void") + ' ' + name + '(' +
             parameters + ')' + names(" raises (", operation.raises, ")") +
             contexts(operation.context));
    }
    void show(const std::string&, const IdDirective& directive) {
        const std::string of = to_string(directive.name) + ' ';
        switch (directive.kind) {
            case IdDirective::Kind::prefix:
                return line("#pragma prefix " + quoted(directive.text, '"'));
            case IdDirective::Kind::id:
                return line("#pragma ID " + of + quoted(directive.text, '"'));
            case IdDirective::Kind::version:
                return line("#pragma version " + of + directive.text);
            case IdDirective::Kind::type_prefix:
                return line("typeprefix " + of + quoted(directive.text, '"'));
            case IdDirective::Kind::type_id:
                return line("typeid " + of + quoted(directive.text, '"'));
        }
    }
    void show(const std::string& name, const AnnotationType& annotation) {
        line("@annotation " + name);
        nested(annotation.declared);
        members(annotation.members);
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
