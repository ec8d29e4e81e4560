#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace plant {

/// Gives the lines that come in on a file descriptor, without ever waiting for one.
class LineReader {
  public:
    /// What follows the end of the input: nothing, or in a file that others write, more.
    enum class End { final, may_grow };

    explicit LineReader(int file_descriptor, End end = End::final)
        : file_descriptor_(file_descriptor), end_(end) {}

    /// Gives every line that is there by now, without its end.
    void read(const std::function<void(std::string_view)>& take);
    /// Nothing will come any more.
    bool at_end() const { return at_end_; }

  private:
    int file_descriptor_;
    End end_;
    std::string rest_;
    bool at_end_ = false;
};

}  // namespace plant
