#pragma once

#include <string_view>
#include <vector>

#include "idlc/parse/expression_parser.hpp"

namespace canorb::idlc::parse {

/// Reads types, and says what is IDL for types that other languages have.
class TypeParser : public ExpressionParser {
  protected:
    using ExpressionParser::ExpressionParser;

    ast::Type type();
    /// Of a constant: a fixed has no digits there.
    ast::Type constant_type();
    /// Of a parameter, result or attribute (`of`), which CORBA wants named.
    ast::Type operation_type(std::string_view of);
    /// The sizes of an array, none where there is no [.
    std::vector<ast::Expression> dimensions();

  private:
    void expect_open_angle(std::string_view behind);
    void close_angle();
    void optional_bound(ast::Type& type);
    void sequence(ast::Type& type);
    void map(ast::Type& type);
    void fixed(ast::Type& type);
    ast::Type element_type();
    void named_type(ast::Type& type);
    ast::TypeKind basic_type();
    ast::TypeKind unsigned_type();
    ast::TypeKind long_type();
    void skip_surplus_int();
    bool foreign_type(ast::Type& type);
    void reject_pointer_signs();
};

}  // namespace canorb::idlc::parse
