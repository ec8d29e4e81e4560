#pragma once

#include <string>
#include <utility>
#include <vector>

namespace canorb::console {

/// Columns as wide as what is in them; two blanks between.
class Table {
  public:
    explicit Table(std::vector<std::string> head) { rows_.push_back(std::move(head)); }
    /// As many cells as the head has.
    void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
    void print() const;

  private:
    std::vector<std::vector<std::string>> rows_;
};

}  // namespace canorb::console
