#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "idlc/source.hpp"

namespace canorb::idlc {

enum class Severity : std::uint8_t { error, warning, note };

struct Diagnostic {
    Severity severity;
    Location where;
    std::string text;
};

/// Collects what the stages have to say about a Source. Only the first 20 errors are kept: what
/// follows so many is mostly their consequence.
class Diagnostics {
  public:
    static constexpr std::size_t most_errors = 20;

    void error(Location where, std::string text);
    void warning(Location where, std::string text);
    /// Belongs to the error or warning before it, and is dropped with it.
    void note(Location where, std::string text);

    bool failed() const { return errors_ != 0; }
    /// More errors than are kept: stages may stop.
    bool full() const { return errors_ > most_errors; }
    const std::vector<Diagnostic>& all() const { return all_; }

  private:
    void add(Severity severity, Location where, std::string text);

    std::vector<Diagnostic> all_;
    std::set<std::pair<Location, std::string>> said_;
    std::size_t errors_ = 0;
    bool last_was_dropped_ = false;
};

/// As compilers print them: "file:line:column: error: text", the source line, and a caret below.
std::string format(Severity severity, const Position& position, std::string_view text);

/// All of them, in the order of the source. The first of an included file says where it was
/// included.
std::string format(const Diagnostics& diagnostics, const Source& source);

}  // namespace canorb::idlc
