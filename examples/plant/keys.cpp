#include "keys.hpp"

#include <fmt/format.h>

#include "variables.hpp"

namespace plant {

std::optional<Keys::Typed> Keys::take(int key) {
    if (line_) return edit(key);
    for (const VariableInfo& variable : variables) {
        const int lower = variable.name.front();
        const int upper = lower - 'a' + 'A';
        if (key == lower || key == upper) {
            return Typed{selected_, fmt::format("{} {} {}", key == upper ? "raise" : "lower",
                                                variable.name, variable.step)};
        }
    }
    if (key == 'q') quit_ = true;
    if (key == ':' || key == enter) line_ = "";
    if (key == 'j') line_ = "join ";
    if (key == 'v') line_ = "leave ";
    if (key == 'f') line_ = "forget ";
    if (key == tab) selected_ = (selected_ + 1) % panels_;
    if (key >= '1' && key <= '9' && static_cast<std::size_t>(key - '1') < panels_)
        selected_ = static_cast<std::size_t>(key - '1');
    return std::nullopt;
}

std::optional<Keys::Typed> Keys::edit(int key) {
    constexpr std::size_t longest = 60;
    if (key == enter) {
        Typed typed{selected_, *line_};
        line_.reset();
        if (!typed.command.empty()) return typed;
    } else if (key == escape) {
        line_.reset();
    } else if (key == backspace) {
        if (!line_->empty()) line_->pop_back();
    } else if (key >= ' ' && key <= '~' && line_->size() < longest) {
        line_->push_back(static_cast<char>(key));
    }
    return std::nullopt;
}

}  // namespace plant
