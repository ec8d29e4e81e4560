#include "orb/caniop/reassembler.hpp"

#include <algorithm>
#include <cassert>

#include "orb/caniop/format.hpp"
#include "orb/caniop/segmenter.hpp"

namespace canorb::caniop {
namespace {

bool is_continuation(Bytes payload) {
    return !payload.empty() && (payload[0] & format::continuation_bit) != 0;
}

}  // namespace

Reassembler::Reassembler(const ReassemblerLimits& limits, const MessageFormat& format,
                         Counters& counters)
    : limits_(limits),
      format_(format),
      counters_(counters),
      slots_(limits.max_reassemblies),
      // An oversize message's first frame is kept even when the limit is shorter than a frame.
      buffer_size_(std::max(limits.max_message, frame_octets(format::longest_message, 0))),
      buffers_(
          std::make_unique_for_overwrite<std::uint8_t[]>(buffer_size_ * limits.max_reassemblies)) {
    assert(limits.max_reassemblies > 0);
}

Reception Reassembler::accept(Identifier from, Bytes payload, TimePoint received) {
    Slot* slot = find(from);
    if (slot != nullptr && is_under_way(*slot) &&
        received - slot->last_frame > limits_.inter_frame_timeout) {
        close(*slot, Counter::reassembly_timeouts);
        slot = nullptr;
    }
    return is_continuation(payload) ? accept_continuation(slot, payload, received)
                                    : accept_first(slot, from, payload, received);
}

Reception Reassembler::accept_first(Slot* slot, Identifier from, Bytes payload,
                                    TimePoint received) {
    if (slot != nullptr) {
        if (is_under_way(*slot)) {
            const Bytes opened_with{buffer(*slot), frame_octets(slot->length, 0)};
            if (slot->continuations == 0 && std::equal(payload.begin(), payload.end(),
                                                       opened_with.begin(), opened_with.end())) {
                counters_.add(Counter::duplicate_frames);
                return Nothing{};
            }
            counters_.add(Counter::interrupted_messages);
        }
        slot->state = State::free;
    }

    if (payload.size() < format_.header_octets) {
        counters_.add(Counter::short_first_frames);
        return Nothing{};
    }
    const std::optional<std::size_t> length = format_.measure(payload);
    if (!length) {
        counters_.add(Counter::malformed_messages);
        return Malformed{from, payload};
    }
    const std::size_t expected = frame_octets(*length, 0);
    if (payload.size() != expected) {
        counters_.add(payload.size() < expected ? Counter::short_frames : Counter::excess_octets);
        return Nothing{};
    }
    const bool oversize = *length > limits_.max_message;
    if (payload.size() == *length) {
        counters_.add(oversize ? Counter::oversize_messages : Counter::messages_received);
        if (oversize) return Oversize{from, payload};
        return Message{from, payload};
    }

    Slot& opened = take_slot(received);
    opened = Slot{.state = oversize ? State::skipping : State::open,
                  .from = from,
                  .length = *length,
                  .received = payload.size(),
                  .continuations = 0,
                  .last_frame = received,
                  .last_used = ++uses_};
    std::copy(payload.begin(), payload.end(), buffer(opened));
    return Nothing{};
}

Reception Reassembler::accept_continuation(Slot* slot, Bytes payload, TimePoint received) {
    if (slot == nullptr) {
        counters_.add(Counter::continuations_without_message);
        return Nothing{};
    }
    const std::size_t sequence = payload[0] & format::sequence_mask;
    if (slot->continuations > 0 && sequence == slot->continuations % format::sequence_modulus) {
        counters_.add(Counter::duplicate_frames);
        return Nothing{};
    }
    if (slot->state == State::ended) {
        close(*slot, Counter::continuations_without_message);
        return Nothing{};
    }
    const std::size_t index = slot->continuations + 1;
    if (sequence != index % format::sequence_modulus) {
        close(*slot, Counter::sequence_errors);
        return Nothing{};
    }
    const Bytes octets = payload.subspan(format::sequence_octets);
    const std::size_t expected = frame_octets(slot->length, index);
    if (octets.size() != expected) {
        close(*slot, octets.size() < expected ? Counter::short_frames : Counter::excess_octets);
        return Nothing{};
    }

    if (slot->state == State::open) {
        std::copy(octets.begin(), octets.end(), buffer(*slot) + slot->received);
    }
    slot->received += octets.size();
    slot->continuations = index;
    slot->last_frame = received;
    slot->last_used = ++uses_;
    if (slot->received < slot->length) return Nothing{};

    const bool oversize = slot->state == State::skipping;
    slot->state = State::ended;
    counters_.add(oversize ? Counter::oversize_messages : Counter::messages_received);
    if (oversize) return Oversize{slot->from, Bytes{buffer(*slot), frame_octets(slot->length, 0)}};
    return Message{slot->from, Bytes{buffer(*slot), slot->length}};
}

void Reassembler::drop_all() {
    for (Slot& slot : slots_) {
        if (is_under_way(slot)) counters_.add(Counter::partials_lost_with_frames);
        slot.state = State::free;
    }
}

std::size_t Reassembler::open() const {
    return static_cast<std::size_t>(std::count_if(slots_.begin(), slots_.end(), is_under_way));
}

bool Reassembler::is_under_way(const Slot& slot) {
    return slot.state == State::open || slot.state == State::skipping;
}

Reassembler::Slot* Reassembler::find(Identifier from) {
    for (std::size_t i = 0; i < ever_used_; ++i) {
        Slot& slot = slots_[i];
        if (slot.state != State::free && slot.from == from) return &slot;
    }
    return nullptr;
}

// A free slot, else the ended one, else the open one, whose last frame is the oldest.
Reassembler::Slot& Reassembler::take_slot(TimePoint now) {
    const auto precedes = [](const Slot& a, const Slot& b) {
        const auto rank = [](const Slot& slot) {
            if (slot.state == State::free) return 0;
            return slot.state == State::ended ? 1 : 2;
        };
        if (rank(a) != rank(b)) return rank(a) < rank(b);
        return rank(a) != 0 && a.last_used < b.last_used;
    };
    Slot& slot = *std::min_element(slots_.begin(), slots_.end(), precedes);
    ever_used_ = std::max(ever_used_, static_cast<std::size_t>(&slot - slots_.data()) + 1);
    if (is_under_way(slot)) {
        const bool stale = now - slot.last_frame > limits_.inter_frame_timeout;
        close(slot, stale ? Counter::reassembly_timeouts : Counter::reassemblies_evicted);
    }
    return slot;
}

void Reassembler::close(Slot& slot, Counter cause) {
    counters_.add(cause);
    slot.state = State::free;
}

std::uint8_t* Reassembler::buffer(const Slot& slot) const {
    return buffers_.get() + static_cast<std::size_t>(&slot - slots_.data()) * buffer_size_;
}

}  // namespace canorb::caniop
