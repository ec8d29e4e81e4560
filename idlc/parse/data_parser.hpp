#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "idlc/parse/type_parser.hpp"

namespace canorb::idlc::parse {

/// Reads the declarations of types and constants.
class DataParser : public TypeParser {
  protected:
    using TypeParser::TypeParser;
    using Declarations = std::vector<ast::Declaration>;

    /// What every declaration and member begins with.
    struct Head {
        std::vector<std::string> comment;
        std::vector<ast::Annotation> annotations;
    };

    Head head();
    void add_annotations(Head& head);
    static ast::Declaration declaration(const Head& head, ast::Identifier name);

    /// Runs `one`, and goes on behind what it began to read where it gives up.
    template <typename One>
    void attempt(One one) {
        const std::size_t begin = at_;
        const int depth = depth_;
        try {
            one();
        } catch (const GiveUp&) {
            depth_ = depth;
            open_angles_ = 0;
            in_template_ = false;
            half_taken_ = false;
            if (!std::exchange(goes_on_here_, false)) skip_from(begin);
        }
    }
    /// Goes behind a balanced { } that is here.
    void skip_block();

    /// The declaration of a type or a constant that is here, up to its end but for its semicolon;
    /// false when there is none.
    bool data(Declarations& into, Head& head);

    /// Reports that the } of the { at `open` is missing here; what follows is read as if it were
    /// there.
    [[noreturn]] void fail_unclosed(const Token& open);
    /// Whether a new line is here that is indented no more than that of the { at `open`.
    bool outdented(const Token& open) const;

  private:
    /// Where a type is declared: for itself, or in front of a member or a new type's name.
    enum class Place : std::uint8_t { alone, in_front };

    void skip_from(std::size_t begin);

    bool begins_constructed() const;
    bool begins_bitmask() const;
    void constructed(Declarations& into, const Head& head, Place place);
    /// A type, or one that is declared in place, which goes to `declared`.
    ast::Type type_or_declaration(Declarations& declared);

    void constant(Declarations& into, const Head& head);
    void alias(Declarations& into, Head& head);
    void native(Declarations& into, const Head& head);
    void enumeration(Declarations& into, const Head& head);
    void bitmask(Declarations& into, const Head& head);
    std::vector<ast::Enumerator> enumerators(const std::string& one, std::string_view annotation);
    void structure(Declarations& into, const Head& head, Place place);
    void exception(Declarations& into, const Head& head);
    void reject_reference(Place place, std::string_view kind, const ast::Identifier& name);

    std::vector<ast::Member> members(std::string_view behind);
    bool begins_no_member() const;
    void member(std::vector<ast::Member>& into);

    void union_type(Declarations& into, const Head& head, Place place);
    void union_case(std::vector<ast::UnionCase>& into);
    void discriminator(ast::Union& into);

    void annotation_type(Declarations& into, const Head& head);
    void annotation_member(ast::AnnotationType& into);

    bool goes_on_here_ = false;  ///< where an attempt gives up: nothing is to be skipped
};

}  // namespace canorb::idlc::parse
