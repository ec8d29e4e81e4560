// Any frames, from any senders, at any times: the reassembler hands out only messages as long as
// their first frame says, within its limits, and never touches memory that is not its own.
//
// Input: records of identifier (1 octet), milliseconds since the frame before (1 octet), payload
// length (1 octet, modulo 9), payload. Identifier 0xFF: the link lost frames.

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <variant>

#include "orb/caniop/reassembler.hpp"

namespace {

using namespace canorb;

std::optional<std::size_t> measure(Bytes first_frame) {
    if (first_frame.size() < 3) std::abort();
    if ((first_frame[0] & 0x80) != 0) std::abort();
    if (first_frame[0] == 0x3F) return std::nullopt;
    return std::size_t{3} + read_be16(&first_frame[1]);
}

void require(bool holds) {
    if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr caniop::ReassemblerLimits limits{.max_message = 60, .max_reassemblies = 3};
    Counters counters;
    caniop::Reassembler reassembler(limits, {.header_octets = 3, .measure = measure}, counters);
    TimePoint now{};
    std::uint64_t messages = 0;

    Bytes input{data, size};
    while (input.size() >= 3) {
        const std::uint8_t id = input[0];
        now += std::chrono::milliseconds(input[1]);
        const std::size_t length = std::min<std::size_t>(input[2] % 9, input.size() - 3);
        // A copy of exactly this size: the sanitizer sees a read behind its end.
        const auto payload = std::make_unique<std::uint8_t[]>(length);
        std::copy_n(input.data() + 3, length, payload.get());
        input = input.subspan(3 + length);
        if (id == 0xFF) {
            reassembler.drop_all();
            require(reassembler.open() == 0);
            continue;
        }
        const caniop::Identifier from{(id & 1) != 0, static_cast<std::uint8_t>(id >> 1 & 3),
                                      static_cast<std::uint8_t>(id >> 3 & 7)};
        const auto reception = reassembler.accept(from, Bytes{payload.get(), length}, now);
        require(reassembler.open() <= limits.max_reassemblies);
        if (const auto* message = std::get_if<caniop::Message>(&reception)) {
            require(message->from == from);
            require(message->octets.size() <= limits.max_message);
            require(measure(message->octets) == message->octets.size());
            ++messages;
        } else if (const auto* oversize = std::get_if<caniop::Oversize>(&reception)) {
            require(oversize->from == from);
            require(*measure(oversize->first_frame) > limits.max_message);
        }
    }
    require(counters[Counter::messages_received] == messages);
    return 0;
}
