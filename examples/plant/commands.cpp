#include "commands.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace plant {

namespace {

std::vector<std::string_view> words_of(std::string_view line) {
    constexpr std::string_view blanks = " \t\r\n";
    std::vector<std::string_view> words;
    while (true) {
        const std::size_t begin = line.find_first_not_of(blanks);
        if (begin == std::string_view::npos) return words;
        line.remove_prefix(begin);
        const std::size_t end = std::min(line.find_first_of(blanks), line.size());
        words.push_back(line.substr(0, end));
        line.remove_prefix(end);
    }
}

template <typename Number>
Number parse_number(std::string_view text, Number least, Number greatest, std::string_view what) {
    Number number{};
    const char* const end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data(), end, number);
    // What is no number is not within the range either.
    if (error != std::errc{} || rest != end || !(number >= least && number <= greatest))
        throw std::invalid_argument(
            fmt::format("'{}' is no {} from {} to {}", text, what, least, greatest));
    return number;
}

Variable parse_variable(std::string_view text) {
    for (const Variable variable : all_variables) {
        if (!text.empty() && info_of(variable).name.starts_with(text)) return variable;
    }
    throw std::invalid_argument(fmt::format("'{}' is none of temperature, pressure, level", text));
}

float parse_value(std::string_view text) {
    return parse_number(text, -greatest_value, greatest_value, "number");
}

}  // namespace

canorb::GroupId parse_group(std::string_view text) {
    return canorb::GroupId{parse_number<std::uint8_t>(text, 1, 31, "group")};
}

Command parse_command(std::string_view line) {
    const std::vector<std::string_view> words = words_of(line);
    const std::string_view verb = words.empty() ? std::string_view{} : words[0];
    if (verb == "quit" && words.size() == 1) return Quit{};
    if (words.size() == 2) {
        if (verb == "join") return Join{parse_group(words[1])};
        if (verb == "leave") return Leave{parse_group(words[1])};
        if (verb == "forget") return Forget{parse_number(words[1], 0, 30, "node")};
    }
    if (words.size() == 3) {
        if (verb == "value") return SetValue{parse_variable(words[1]), parse_value(words[2])};
        if (verb == "limit") return SetLimit{parse_variable(words[1]), parse_value(words[2])};
        if (verb == "raise") return Change{parse_variable(words[1]), parse_value(words[2])};
        if (verb == "lower") return Change{parse_variable(words[1]), -parse_value(words[2])};
    }
    throw std::invalid_argument(
        fmt::format("'{}' is no command. There are: value VARIABLE NUMBER, limit VARIABLE NUMBER, "
                    "raise VARIABLE "
                    "NUMBER, lower VARIABLE NUMBER, join GROUP, leave GROUP, forget NODE, quit",
                    line));
}

}  // namespace plant
