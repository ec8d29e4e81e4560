#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "keys.hpp"
#include "panel.hpp"

namespace plant {

/// Panels on the whole terminal, the first one above the others, with what is told below them.
class Screen {
  public:
    /// Nothing when this terminal cannot show it.
    static std::unique_ptr<Screen> open(std::string title, std::vector<std::string> names);

    virtual ~Screen() = default;
    Screen(const Screen&) = delete;
    Screen& operator=(const Screen&) = delete;

    virtual void show(std::size_t panel, Panel content) = 0;
    virtual void tell(std::string_view line) = 0;
    virtual void draw() = 0;

    /// The next command that the keys typed since make; nothing when there is none yet.
    virtual std::optional<Keys::Typed> next_command() = 0;
    virtual bool quit() const = 0;

  protected:
    Screen() = default;
};

}  // namespace plant
