#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace canorb::idlc {

/// A place in a Source, as the offset of an octet in its text.
struct Location {
    std::uint32_t offset = 0;

    friend auto operator<=>(Location, Location) = default;
};

/// A place as people name it. Lines and columns count from 1; a column is an octet.
struct Position {
    std::string file;
    std::uint32_t line = 1;
    std::uint32_t column = 1;
    std::string source_line;  ///< the whole line, without its end
};

/// The text of one compilation: an IDL file as the C preprocessor leaves it, with linemarkers
/// (`# 12 "file" 1`). It knows for each octet from which file and line it came. It does not change
/// once it is complete, and it outlives everything that points into its text.
class Source {
  public:
    /// `main_file` is spelled as the linemarkers spell it.
    Source(std::string main_file, std::string preprocessed);

    Source(const Source&) = delete;
    Source& operator=(const Source&) = delete;

    /// A file before preprocessing. With it positions have the column that an editor shows: the
    /// preprocessor folds white space.
    void add_original(const std::string& file, std::string_view text);

    /// The text to compile: linemarkers and #include lines are blank, offsets are kept.
    std::string_view text() const { return text_; }
    const std::string& main_file() const { return files_.front(); }
    /// Every file that contributed, the main file first.
    const std::vector<std::string>& files() const { return files_; }
    /// What the main file itself includes, as it spells it.
    const std::vector<std::string>& includes() const { return includes_; }

    bool in_main_file(Location where) const;
    /// The file and line alone, without a look at the line.
    const std::string& file(Location where) const;
    std::uint32_t line(Location where) const;
    Position position(Location where) const;
    /// The #include that the file of this place came in by; nothing in the main file.
    std::optional<Location> included_from(Location where) const;

  private:
    /// Text from `offset` on, to the next segment, begins at `line` of `file`.
    struct Segment {
        std::uint32_t offset;
        std::uint32_t file;
        std::uint32_t line;
        std::optional<Location> included_from;
    };

    void scan();
    /// True when the line was a linemarker or an #include, which is then blanked.
    bool take_directive(std::size_t begin, std::size_t end);
    /// How many lines of the text begin before this place, or at it.
    std::size_t text_line(std::size_t offset) const;
    std::uint32_t file_index(std::string_view name);
    const Segment& segment(Location where) const;

    std::string text_;
    std::vector<std::string> files_;
    std::vector<std::string> includes_;
    std::vector<Segment> segments_;
    std::vector<std::uint32_t> line_begins_;
    std::vector<Location> open_includes_;  ///< of the files that the scan is in
    Location last_include_;                ///< the #include line last seen
    std::map<std::string, std::vector<std::string>, std::less<>> originals_;
};

}  // namespace canorb::idlc
