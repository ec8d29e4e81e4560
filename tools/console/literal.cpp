#include "tools/console/literal.hpp"

#include <cstddef>
#include <nlohmann/json.hpp>

namespace canorb::console {
namespace {

using Json = nlohmann::json;
using Form = Literal::Form;

/// Far more than a message can have, and few enough to be built and destroyed on the stack.
constexpr std::size_t deepest = 512;

/// Builds a Literal from what nlohmann-json reads, whose own values would lose digits and members
/// that are there twice.
class Builder {
  public:
    Literal take() { return std::move(root_); }
    const std::string& error() const { return error_; }

    bool null() { return value({}); }
    bool boolean(bool is) { return value({.form = Form::boolean, .text = is ? "true" : "false"}); }
    bool number_integer(Json::number_integer_t number) { return written(std::to_string(number)); }
    bool number_unsigned(Json::number_unsigned_t number) { return written(std::to_string(number)); }
    bool number_float(Json::number_float_t, const std::string& text) { return written(text); }
    bool string(std::string& text) {
        return value({.form = Form::string, .text = std::move(text)});
    }
    bool binary(Json::binary_t&) { return false; }
    bool start_object(std::size_t) { return open(Form::object); }
    bool key(std::string& name) {
        open_.back()->members.emplace_back(std::move(name), Literal{});
        return true;
    }
    bool end_object() { return close(); }
    bool start_array(std::size_t) { return open(Form::array); }
    bool end_array() { return close(); }
    bool parse_error(std::size_t, const std::string&, const Json::exception& error) {
        error_ = error.what();
        // "[json.exception.parse_error.101] parse error at line 1, column 2: ..."
        if (const std::size_t end = error_.find("] "); end != std::string::npos)
            error_.erase(0, end + 2);
        return false;
    }

  private:
    bool written(std::string text) {
        return value({.form = Form::number, .text = std::move(text)});
    }

    Literal* place() {
        if (open_.empty()) return &root_;
        Literal& around = *open_.back();
        if (around.form == Form::object) return &around.members.back().second;
        around.elements.emplace_back();
        return &around.elements.back();
    }
    bool value(Literal literal) {
        *place() = std::move(literal);
        return true;
    }
    bool open(Form form) {
        if (open_.size() >= deepest) {
            error_ = "there are more than " + std::to_string(deepest) + " levels";
            return false;
        }
        Literal* const literal = place();
        literal->form = form;
        open_.push_back(literal);
        return true;
    }
    bool close() {
        open_.pop_back();
        return true;
    }

    Literal root_;
    /// What is around the next value. The elements of each that is open stay where they are: only
    /// the last of them is ever added to.
    std::vector<Literal*> open_;
    std::string error_;
};

}  // namespace

Result<Literal, std::string> parse_literal(std::string_view json) {
    Builder builder;
    if (!Json::sax_parse(json, &builder)) return Failure{builder.error()};
    return builder.take();
}

std::string in_quotes(std::string_view text) {
    constexpr std::size_t longest = 60;
    if (text.size() <= longest) return '\'' + std::string{text} + '\'';
    return '\'' + std::string{text.substr(0, longest)} + "...'";
}

std::string shown(const Literal& literal) {
    const bool is_number = literal.text.find_first_not_of("0123456789+-.e") == std::string::npos &&
                           literal.text.find_first_of("0123456789") != std::string::npos;
    switch (literal.form) {
        case Form::bare:
            return is_number ? literal.text : in_quotes(literal.text);
        case Form::null:
            return "null";
        case Form::array:
            return "an array";
        case Form::object:
            return "an object";
        case Form::boolean:
        case Form::number:
            return literal.text;
        default:
            return in_quotes(literal.text);
    }
}

}  // namespace canorb::console
