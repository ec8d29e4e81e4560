#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace canorb {

/// A first-in-first-out queue with a fixed capacity. It does not allocate after construction.
template <typename T>
class Fifo {
  public:
    explicit Fifo(std::size_t capacity) : items_(capacity) {}

    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    bool full() const { return size_ == items_.size(); }

    /// Precondition: not full().
    void push(T item) {
        items_[(first_ + size_) % items_.size()] = std::move(item);
        ++size_;
    }

    std::optional<T> pop() {
        if (empty()) return std::nullopt;
        std::optional<T> item{std::move(items_[first_])};
        first_ = (first_ + 1) % items_.size();
        --size_;
        return item;
    }

  private:
    std::vector<T> items_;
    std::size_t first_ = 0;
    std::size_t size_ = 0;
};

}  // namespace canorb
