#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "orb/can/sim/bit_stream_processor.hpp"
#include "tests/can/frames.hpp"

namespace canorb::can::sim::test {

inline FramePosition in(FrameField field, int index = 0) {
    return {field, static_cast<std::uint8_t>(index), false};
}

inline FramePosition stuff_after(FrameField field, int index = 0) {
    return {field, static_cast<std::uint8_t>(index), true};
}

inline BitStreamProcessor new_processor() {
    return BitStreamProcessor{false, BitStreamProcessor::integration_bits};
}

/// Bit stream processors on a wire, and drawings of the bits to come that they must agree with:
///
///     Wire wire{"AB"};
///     wire.send('A', standard(0x555));
///     wire.draw({{"A", "0 10101010101 000 00I00 ..."},
///                {"B", "- ----------- --- ----- ..."},
///                {"B sees", ". ........... ... 1.... ..."},
///                {"bus", "0 10101010101 000 00I00 ..."}});
///
/// A row is named after a node and has what it drives: 0 and 1, O and I for the inserted (stuff)
/// bits, - for recessive where it does not matter whether it takes the bit for an inserted one.
/// "bus" is the wired AND. What a node sees is the bus, but for the 0 and 1 in its "sees" row. A
/// fault of all is "all see". Blanks are for the reader.
class Wire {
  public:
    struct Row {
        std::string_view name;
        std::string_view levels;
    };
    struct Error {
        int bit;  ///< counted from the wire's first one
        ErrorCapture capture;
        friend bool operator==(const Error&, const Error&) = default;
    };
    struct Node {
        BitStreamProcessor processor = new_processor();
        std::optional<Frame> to_send{};
        std::vector<int> sent{};  ///< bits at which a frame was sent
        std::vector<int> received_at{};
        std::vector<Frame> received{};
        std::vector<int> lost_at{};
        std::vector<Error> errors{};
    };

    explicit Wire(std::string_view names) {
        for (const char name : names) nodes_.try_emplace(name);
    }

    Node& operator[](char name) { return nodes_.at(name); }
    const ErrorStatus& status(char name) { return nodes_.at(name).processor.status(); }

    /// As soon as it may, and until it was sent.
    void send(char name, const Frame& frame) { nodes_.at(name).to_send = frame; }

    /// The number of bits that are over.
    int bits() const { return bit_; }

    /// Lets the bits pass that are drawn. Says where they differ and gives up there.
    void draw(std::initializer_list<Row> drawn) {
        std::map<std::string, std::string> rows;
        std::size_t length = 0;
        for (const Row& row : drawn) {
            std::string levels;
            for (const char c : row.levels) {
                if (c != ' ') levels += c;
            }
            if (length == 0) length = levels.size();
            ASSERT_EQ(levels.size(), length) << "the drawing: " << row.name;
            rows.emplace(row.name, levels);
        }
        for (std::size_t i = 0; i < length; ++i) {
            begin_bit();
            for (const auto& [name, node] : nodes_) {
                const auto row = rows.find(std::string(1, name));
                if (row == rows.end()) continue;
                const char c = row->second[i];
                const FramePosition position = node.processor.position();
                const std::string place = row->first + ", bit " + std::to_string(i) + " of " +
                                          row->second + ": " +
                                          std::string(can::name(position.field));
                ASSERT_EQ(int{node.processor.driven()}, c == '0' || c == 'O' ? 0 : 1) << place;
                if (c == '-') continue;
                ASSERT_EQ(position.stuff, c == 'O' || c == 'I') << place;
            }
            const std::uint8_t level = this->level();
            if (const auto bus = rows.find("bus"); bus != rows.end()) {
                const char c = bus->second[i];
                ASSERT_EQ(int{level}, c == '0' || c == 'O' ? 0 : 1) << "bus, bit " << i;
            }
            const auto seen = [&](const std::string& row, std::uint8_t otherwise) {
                const auto found = rows.find(row);
                if (found == rows.end() || found->second[i] == '.') return otherwise;
                return static_cast<std::uint8_t>(found->second[i] - '0');
            };
            const std::uint8_t all = seen("all see", level);
            for (auto& [name, node] : nodes_) {
                end_bit(node, seen(std::string(1, name) + " sees", all));
            }
            ++bit_;
        }
    }

    /// Undisturbed.
    void pass(int count) {
        for (; count > 0; --count) {
            begin_bit();
            const std::uint8_t level = this->level();
            for (auto& [name, node] : nodes_) end_bit(node, level);
            ++bit_;
        }
    }

    void pass_until_idle() {
        bool busy = true;
        while (busy) {
            pass(1);
            busy = false;
            for (const auto& [name, node] : nodes_) {
                busy = busy || !node.processor.may_start() || node.to_send;
            }
        }
    }

  private:
    void begin_bit() {
        for (auto& [name, node] : nodes_) {
            if (!node.to_send || !node.processor.may_start()) continue;
            node.processor.start(stuffed_bits(*node.to_send), node.to_send->extended);
        }
    }

    std::uint8_t level() const {
        std::uint8_t level = 1;
        for (const auto& [name, node] : nodes_) level &= node.processor.driven();
        return level;
    }

    void end_bit(Node& node, std::uint8_t seen) {
        const BitStreamProcessor::Events events = node.processor.step(seen);
        if ((events & BitStreamProcessor::sent) != 0) {
            node.sent.push_back(bit_);
            node.to_send.reset();
        }
        if ((events & BitStreamProcessor::received) != 0) {
            node.received_at.push_back(bit_);
            node.received.push_back(node.processor.frame());
        }
        if ((events & BitStreamProcessor::lost_arbitration) != 0) {
            node.lost_at.push_back(node.processor.lost_at());
        }
        if ((events & BitStreamProcessor::detected_error) != 0) {
            node.errors.push_back({bit_, node.processor.error()});
        }
    }

    std::map<char, Node> nodes_;
    int bit_ = 0;
};

/// Levels that a single processor sees, one after the other: 0, 1, and I for an inserted recessive
/// bit, O for a dominant one. Blanks are for the reader.
inline void feed(BitStreamProcessor& processor, std::string_view levels) {
    for (const char c : levels) {
        if (c != ' ') processor.step(c == '1' || c == 'I' ? 1 : 0);
    }
}

inline void begin(BitStreamProcessor& processor, const Frame& frame) {
    processor.start(stuffed_bits(frame), frame.extended);
}

/// Sees what it drives until it may send.
inline void settle(BitStreamProcessor& processor) {
    while (!processor.may_start()) processor.step(processor.driven());
}

/// Its SOF cannot be seen: rule 3, TEC + 8 each time.
inline void fail_as_transmitter(BitStreamProcessor& processor, int times) {
    for (; times > 0; --times) {
        begin(processor, standard(0x555));
        processor.step(1);
        settle(processor);
    }
}

/// Six dominant bits: rule 1, REC + 1 each time.
inline void fail_as_receiver(BitStreamProcessor& processor, int times) {
    for (; times > 0; --times) {
        feed(processor, "000000");
        settle(processor);
    }
}

/// TEC 128.
inline void make_passive(BitStreamProcessor& processor) {
    fail_as_transmitter(processor, 16);
}

}  // namespace canorb::can::sim::test
