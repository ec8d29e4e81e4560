#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "orb/base/bytes.hpp"

namespace canorb::core {

/// Octets that are handed from one owner to the next.
using Buffer = std::vector<std::uint8_t>;

/// Buffers to use again, so that a call does not allocate once as many as are in use at a time,
/// and as large, have been made.
class BufferPool {
  public:
    /// Empty, with whatever capacity it had before.
    Buffer acquire() {
        if (free_.empty()) return {};
        Buffer buffer = std::move(free_.back());
        free_.pop_back();
        buffer.clear();
        return buffer;
    }

    Buffer copy_of(Bytes octets) {
        Buffer buffer = acquire();
        buffer.assign(octets.begin(), octets.end());
        return buffer;
    }

    void release(Buffer buffer) {
        if (buffer.capacity() > 0) free_.push_back(std::move(buffer));
    }

  private:
    std::vector<Buffer> free_;
};

}  // namespace canorb::core
