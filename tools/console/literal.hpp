#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "orb/base/result.hpp"

namespace canorb::console {

/// A value as people write it, before anybody knows its type.
struct Literal {
    enum class Form : std::uint8_t {
        bare,  ///< an argument as a whole, which need not be JSON
        null,
        boolean,
        number,
        string,
        array,
        object,
    };

    Form form = Form::null;
    /// Of a number as it is written, so that no digit is lost; of a boolean true or false.
    std::string text{};
    std::vector<Literal> elements{};
    std::vector<std::pair<std::string, Literal>> members{};

    /// Whether it may be meant as such.
    bool is_text() const { return form == Form::bare || form == Form::string; }
    bool is_number() const { return form == Form::bare || form == Form::number; }
};

/// A JSON text. The error is the reason why it is none, for people.
Result<Literal, std::string> parse_literal(std::string_view json);

/// In quotes; of a long text the beginning.
std::string in_quotes(std::string_view text);

/// The value as the user wrote it, for a message: in quotes but for numbers.
std::string shown(const Literal& literal);

}  // namespace canorb::console
