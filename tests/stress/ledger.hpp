#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

namespace canorb::test::stress {

/// Names one call of a run.
using Token = std::uint32_t;

/// What a servant answers to it: another one for each token.
constexpr std::uint32_t answer_to(Token token) {
    return token * 2'654'435'761U ^ 0x5EED5EEDU;
}

/// Whose answer that is, if it is one.
constexpr Token token_of(std::uint32_t answer) {
    return (answer ^ 0x5EED5EEDU) * 244'002'641U;  // the factor's inverse modulo 2^32
}
static_assert(token_of(answer_to(12'345)) == 12'345);

/// What the caller was told about the execution of its call.
enum class Fate : std::uint8_t { open, never, maybe, once };

/// What was called, what was executed, and whether the two fit together. Any thread.
class Ledger {
  public:
    static constexpr int highest_node = 7;

    explicit Ledger(std::size_t capacity) : entries_(capacity) {}

    /// A new call, to the nodes whose bits are set in `targets`.
    Token begin(unsigned targets) {
        const std::size_t token = begun_++;
        entries_.at(token).targets = static_cast<std::uint8_t>(targets);
        return static_cast<Token>(token);
    }
    void end(Token token, Fate fate) { entries_.at(token).fate = fate; }

    /// A servant of that node was called. False: with a token that nobody has made.
    [[nodiscard]] bool execute(Token token, int node) {
        if (token >= begun_) return false;
        ++entries_[token].executed[static_cast<std::size_t>(node)];
        return true;
    }

    std::size_t size() const { return begun_; }

    /// What does not fit, at most twenty sentences. Not while calls are under way.
    std::vector<std::string> contradictions() const {
        std::vector<std::string> found;
        for (std::size_t token = 0; token < begun_ && found.size() < 20; ++token) {
            const Entry& entry = entries_[token];
            const Fate fate = entry.fate;
            if (fate == Fate::open) found.push_back(name(token) + " did not end");
            for (int node = 0; node <= highest_node; ++node) {
                const int times = entry.executed[static_cast<std::size_t>(node)];
                const bool target = (entry.targets >> node & 1) != 0;
                const int most = target && fate != Fate::never ? 1 : 0;
                const int least = target && fate == Fate::once ? 1 : 0;
                if (times >= least && times <= most) continue;
                found.push_back(name(token) + " was executed " + std::to_string(times) +
                                " times at node " + std::to_string(node) + ", not " +
                                std::to_string(least) + " to " + std::to_string(most));
            }
        }
        return found;
    }

  private:
    struct Entry {
        std::array<std::atomic<std::uint8_t>, highest_node + 1> executed{};
        std::atomic<std::uint8_t> targets = 0;
        std::atomic<Fate> fate = Fate::open;
    };

    static std::string name(std::size_t token) { return "call " + std::to_string(token); }

    std::vector<Entry> entries_;
    std::atomic<std::size_t> begun_ = 0;
};

}  // namespace canorb::test::stress
