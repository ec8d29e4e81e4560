#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "idlc/parse/token_reader.hpp"

namespace canorb::idlc::parse {

/// Reads types and constant expressions.
class TypeParser : public TokenReader {
  protected:
    using TokenReader::TokenReader;

    ast::Type type();
    /// The sizes of an array, none where there is no [.
    std::vector<ast::Expression> dimensions();
    ast::Expression expression(int precedence = 0);
    /// Names the feature where a keyword begins one that this compiler does not know.
    void reject_unsupported();

    bool in_template_ = false;  ///< inside of < >, where >> is no shift

  private:
    struct Binary {
        std::string_view symbol;
        ast::Operator op;
        int precedence;
    };

    void sequence(ast::Type& type);
    /// A >> in it closes two templates; a shift needs parentheses.
    ast::Expression bound();
    ast::TypeKind basic_type();

    std::optional<Binary> binary_operator() const;
    ast::Expression unary();
    ast::Literal literal();
    std::uint64_t integer(const Token& token);
    long double floating(const Token& token);
    ast::Literal string_literal();
};

}  // namespace canorb::idlc::parse
