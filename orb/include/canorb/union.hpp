#pragma once

/// What generated union classes are made of.

#include <cstddef>
#include <initializer_list>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>

#include "canorb/exceptions.hpp"
#include "orb/ccdr/print.hpp"

namespace canorb {

/// Throws BAD_PARAM: `member`, "Shape::radius", is not what the union's discriminator selects.
/// Never inline, so that what generated classes check costs little.
[[noreturn, gnu::noinline]] inline void throw_not_selected(std::string_view member) {
    throw_system_exception(cause::bad_union_member,
                           std::string{member} + ": the discriminator does not select it");
}

inline void check_selected(bool is_selected, std::string_view member) {
    if (!is_selected) throw_not_selected(member);
}

/// The I-th member of a union; BAD_PARAM where it is not the active one.
template <std::size_t I, typename Members>
auto& union_member(Members& members, std::string_view name) {
    auto* const member = std::get_if<I>(&members);
    if (member == nullptr) throw_not_selected(name);
    return *member;
}

/// {_d: circle, radius: 1.5}, or only the discriminator where there is no member.
template <OutputStream Stream, typename Discriminator, typename... Members>
Stream& print_union(Stream& out, const Discriminator& discriminator,
                    const std::variant<Members...>& members,
                    std::initializer_list<std::string_view> names) {
    out << "{_d: ";
    print(out, discriminator);
    const auto print_member = [&](const auto& member) {
        if constexpr (!std::is_same_v<decltype(member), const std::monostate&>) {
            out << ", " << names.begin()[members.index() - 1] << ": ";
            print(out, member);
        }
    };
    if (!members.valueless_by_exception()) std::visit(print_member, members);
    out << '}';
    return out;
}

}  // namespace canorb
