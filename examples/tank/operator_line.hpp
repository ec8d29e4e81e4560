#pragma once

#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace tank {

/// Node A's end of the serial line to the operator station. Neither function blocks.
class OperatorLine {
  public:
    virtual ~OperatorLine() = default;

    /// The oldest character that came in and was not read yet.
    virtual std::optional<char> read() = 0;
    /// Sends text; what the line cannot take is lost.
    virtual void write(std::string_view text) = 0;
};

/// A line whose other end is in the same program. Safe from any thread.
class LocalOperatorLine final : public OperatorLine {
  public:
    /// `show` gets what node A writes, in the thread of node A.
    explicit LocalOperatorLine(std::function<void(std::string_view)> show = {})
        : show_(std::move(show)) {}

    /// What the operator does. As in a serial port's buffer there is room for only so much.
    void type(char character) {
        const std::lock_guard lock{mutex_};
        if (typed_.size() < buffer_size) typed_.push_back(character);
    }

    std::optional<char> read() override {
        const std::lock_guard lock{mutex_};
        if (typed_.empty()) return std::nullopt;
        const char character = typed_.front();
        typed_.pop_front();
        return character;
    }

    void write(std::string_view text) override {
        if (show_) show_(text);
    }

  private:
    static constexpr std::size_t buffer_size = 64;

    std::function<void(std::string_view)> show_;
    std::mutex mutex_;
    std::deque<char> typed_;
};

}  // namespace tank
