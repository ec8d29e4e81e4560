#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace plant {

/// What keys on a screen full of panels mean: they choose one, and become commands to it.
///
///     1 to 9, Tab        choose a panel
///     t T p P l L        lower or raise temperature, pressure, level by a step
///     j v f : or Enter   begin a line: "join ", "leave ", "forget ", or an empty one; Enter sends
///                        it, Escape drops it
///     q                  the end
class Keys {
  public:
    struct Typed {
        std::size_t panel;
        std::string command;

        bool operator==(const Typed&) const = default;
    };

    static constexpr int backspace = 0x08;
    static constexpr int tab = '\t';
    static constexpr int enter = '\n';
    static constexpr int escape = 0x1B;

    /// There are so many panels, at least one.
    explicit Keys(std::size_t panels) : panels_(panels) {}

    /// The command that this key completes.
    std::optional<Typed> take(int key);

    std::size_t selected() const { return selected_; }
    /// The line that is being typed.
    const std::optional<std::string>& line() const { return line_; }
    bool quit() const { return quit_; }

  private:
    std::optional<Typed> edit(int key);

    std::size_t panels_;
    std::size_t selected_ = 0;
    std::optional<std::string> line_;
    bool quit_ = false;
};

}  // namespace plant
