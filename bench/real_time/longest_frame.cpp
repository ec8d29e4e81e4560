#include "longest_frame.hpp"

#include <algorithm>

namespace canorb::bench {

std::uint32_t LongestFrame::State::send(std::uint32_t bit) {
    const bool feedback = ((crc >> 14) ^ bit) != 0;
    crc = (crc << 1) & 0x7FFFU;
    if (feedback) crc ^= 0x4599U;
    run = bit == level ? run + 1 : 1;
    level = bit;
    if (run < 5) return 0;
    run = 1;
    level ^= 1U;
    return 1;
}

std::uint32_t LongestFrame::State::send_bits(std::uint32_t value, int width) {
    std::uint32_t stuff_bits = 0;
    for (int shift = width - 1; shift >= 0; --shift) stuff_bits += send((value >> shift) & 1U);
    return stuff_bits;
}

LongestFrame::LongestFrame() {
    const auto for_each_state = [](std::vector<std::uint8_t>& layer, const auto& most_from) {
        for (std::uint32_t i = 0; i < states; ++i) {
            layer[i] = most_from(State{i >> 3, (i >> 2) & 1U, (i & 3U) + 1});
        }
    };
    most_stuff_bits_.assign(most_data_bits + 1, std::vector<std::uint8_t>(states));
    for_each_state(most_stuff_bits_[0], [](State state) {
        return static_cast<std::uint8_t>(state.send_bits(state.crc, 15));
    });
    for (std::size_t left = 1; left <= most_data_bits; ++left) {
        const std::vector<std::uint8_t>& next = most_stuff_bits_[left - 1];
        for_each_state(most_stuff_bits_[left], [&next](State state) {
            State zero = state;
            State one = state;
            const std::uint32_t with_zero = zero.send(0);
            const std::uint32_t with_one = one.send(1);
            return static_cast<std::uint8_t>(
                std::max(with_zero + next[zero.index()], with_one + next[one.index()]));
        });
    }
}

can::Frame LongestFrame::find(std::uint32_t id, std::uint8_t octets,
                              std::mt19937_64& random) const {
    can::Frame frame;
    frame.id = id;
    frame.length = octets;
    State state;
    state.send(0);            // SOF
    state.send_bits(id, 11);  // identifier
    state.send_bits(0, 3);    // RTR, IDE, r0
    state.send_bits(octets, 4);
    const std::size_t bits = std::size_t{octets} * 8;
    for (std::size_t i = 0; i < bits; ++i) {
        const std::vector<std::uint8_t>& next = most_stuff_bits_[bits - i - 1];
        State zero = state;
        State one = state;
        const std::uint32_t with_zero = zero.send(0) + next[zero.index()];
        const std::uint32_t with_one = one.send(1) + next[one.index()];
        const bool choice =
            with_one > with_zero || (with_one == with_zero && (random() >> 63) != 0);
        state = choice ? one : zero;
        if (choice) frame.data[i / 8] |= static_cast<std::uint8_t>(0x80U >> (i % 8));
    }
    return frame;
}

}  // namespace canorb::bench
