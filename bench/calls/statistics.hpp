#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "orb/base/time.hpp"

namespace canorb::bench {

/// Round-trip times, in the order of their measuring.
class Statistics {
  public:
    explicit Statistics(std::size_t capacity) { times_.reserve(capacity); }

    void add(Duration time) { times_.push_back(time.count()); }

    /// min, median, p99, p99.9 and mean in ns, how many, and how many in a second, back to back.
    nlohmann::json json() const;

  private:
    std::vector<std::int64_t> times_;
};

}  // namespace canorb::bench
