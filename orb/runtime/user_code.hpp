#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <thread>
#include <vector>

namespace canorb::runtime {

/// Which threads run user code of an ORB now: servants, timers, callbacks.
///
/// Invariants:
///  * at most `threads` threads run user code at once; each may nest up to max_nesting deep;
///  * callbacks, which is all user code but servants, run in one thread at a time.
class UserCode {
  public:
    static constexpr int max_nesting = 8;

    explicit UserCode(std::size_t threads) : limit_(threads) { running_.reserve(threads); }

    /// Whether the calling thread runs user code already.
    bool is_here() const { return here() != nullptr; }
    bool is_anywhere() const { return !running_.empty(); }

    /// Whether the calling thread may begin, as far as the others go.
    bool may_begin() const {
        const Running* mine = here();
        return mine != nullptr ? mine->depth < max_nesting : running_.size() < limit_;
    }
    /// Whether the calling thread may begin with a callback, given that it may begin.
    bool may_call_back() const {
        return !calling_back_ || calling_back_ == std::this_thread::get_id();
    }
    /// Whether no thread could begin before one of them ends, and the calling one cannot nest.
    bool is_too_deep() const {
        const Running* mine = here();
        return mine != nullptr && running_.size() >= limit_ &&
               std::ranges::all_of(running_,
                                   [](const Running& it) { return it.depth >= max_nesting; });
    }

    /// Precondition: may_begin().
    void begin() {
        if (Running* mine = here()) {
            ++mine->depth;
        } else {
            running_.push_back({std::this_thread::get_id(), 1});
        }
    }
    void end() {
        Running* mine = here();
        if (--mine->depth > 0) return;
        *mine = running_.back();
        running_.pop_back();
    }

    /// Between begin() and end(): what runs is a callback. Returns what end_callback() wants.
    std::optional<std::thread::id> begin_callback() {
        const auto before = calling_back_;
        calling_back_ = std::this_thread::get_id();
        return before;
    }
    void end_callback(std::optional<std::thread::id> before) { calling_back_ = before; }

  private:
    struct Running {
        std::thread::id thread;
        int depth;
    };

    Running* here() {
        const auto found =
            std::ranges::find(running_, std::this_thread::get_id(), &Running::thread);
        return found == running_.end() ? nullptr : &*found;
    }
    const Running* here() const {
        const auto found =
            std::ranges::find(running_, std::this_thread::get_id(), &Running::thread);
        return found == running_.end() ? nullptr : &*found;
    }

    std::size_t limit_;
    std::vector<Running> running_;
    std::optional<std::thread::id> calling_back_;
};

}  // namespace canorb::runtime
