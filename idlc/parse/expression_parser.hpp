#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "idlc/parse/token_reader.hpp"

namespace canorb::idlc::parse {

/// Reads constant expressions, and annotations, which consist of them.
class ExpressionParser : public TokenReader {
  protected:
    using TokenReader::TokenReader;

    ast::Expression expression();
    /// One inside of < >, where a >> may close two of them.
    ast::Expression template_argument();
    std::vector<ast::Annotation> annotations();

    int open_angles_ = 0;
    bool in_template_ = false;  ///< in an expression inside of < >, and in no parentheses there

  private:
    struct Binary {
        std::string_view symbol;
        ast::Operator op;
        int precedence;
    };

    std::optional<Binary> binary_operator() const;
    bool closes_two_angles() const;
    /// Of operators that bind at least as strong.
    ast::Expression operation(int precedence);
    ast::Expression unary();
    ast::Literal literal();
    ast::Literal text();
    std::uint64_t integer(const Token& token);
    long double floating(const Token& token);
    ast::FixedLiteral fixed(const Token& token);
    ast::Annotation annotation();
    ast::ScopedName annotation_name();

    int operators_ = 0;  ///< of two operands, in the current expression
};

}  // namespace canorb::idlc::parse
