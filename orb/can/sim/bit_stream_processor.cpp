#include "orb/can/sim/bit_stream_processor.hpp"

#include <algorithm>
#include <cassert>

namespace canorb::can::sim {
namespace {

constexpr int flag_bits = 6;
constexpr int delimiter_bits = 8;
constexpr int end_of_frame_bits = 7;
constexpr int intermission_length = static_cast<int>(intermission_bits);
constexpr int dominant_bits_tolerated = 8;  // the eighth is the first that counts
constexpr int identifier_bits = 11;
constexpr int extended_identifier_bits = 18;

/// ACK delimiter and EOF: the recessive bits with which an acknowledged frame ends.
constexpr int recessive_end_bits = 1 + end_of_frame_bits;

}  // namespace

BitStreamProcessor::BitStreamProcessor(bool automatic_recovery, std::uint64_t recessive_bits)
    : automatic_recovery_(automatic_recovery) {
    if (recessive_bits < integration_bits) {
        enter(State::integrating);
        run_ = static_cast<int>(recessive_bits);
    }
}

BitStreamProcessor::Events BitStreamProcessor::step_any(std::uint8_t seen) {
    may_join_ = false;
    if (silent_) seen &= driven_;
    const ControllerState before = status().state;
    Events events = dispatch(seen);
    if (status().state != before) {
        events |= status_changed;
        if (confinement_.is_bus_off()) enter_bus_off();
    }
    return events;
}

BitStreamProcessor::Events BitStreamProcessor::dispatch(std::uint8_t seen) {
    switch (state_) {
        case State::stuffed:
            return step_stuffed(seen);
        case State::crc_delimiter:
        case State::ack_slot:
        case State::ack_delimiter:
        case State::end_of_frame:
            return step_tail(seen);
        case State::active_error_flag:
        case State::passive_error_flag:
        case State::overload_flag:
            return step_flag(seen);
        case State::error_superposition:
        case State::overload_superposition:
            return step_superposition(seen);
        case State::error_delimiter:
        case State::overload_delimiter:
            return step_delimiter(seen);
        case State::idle:
        case State::suspend:
        case State::intermission:
        case State::integrating:
        case State::bus_off:
            break;
    }
    return step_between(seen);
}

void BitStreamProcessor::enter(State state) {
    state_ = state;
    count_ = 0;
    driven_ = 1;
    if (is_between_frames()) silent_ = listen_only_;
}

void BitStreamProcessor::set_listen_only(bool on, bool dominant) {
    listen_only_ = on;
    if (is_between_frames() && !dominant) silent_ = on;
}

// ---- SOF to CRC

void BitStreamProcessor::begin_frame() {
    enter(State::stuffed);
    may_join_ = false;
    transmitter_ = false;
    unacknowledged_ = false;
    run_ = 0;
    last_ = 1;
    crc_ = 0;
    frame_ = Frame{};
    enter_field(FrameField::start_of_frame, 1);
}

void BitStreamProcessor::start(const StuffedBits& bits, bool extended) {
    assert(may_start());
    const bool joins = may_join_;  // its SOF is the other's
    if (!joins) begin_frame();
    may_join_ = false;
    transmitter_ = true;
    sends_extended_ = extended;
    bits_ = bits;
    next_bit_ = joins ? 1 : 0;
    driven_ = bits_.bits[next_bit_++];
}

void BitStreamProcessor::enter_field(FrameField field, int width) {
    field_ = field;
    width_ = width;
    // Data is stored octet by octet.
    field_step_ = static_cast<std::uint8_t>(field == FrameField::data ? 8 : width);
    index_ = 0;
    value_ = 0;
}

/// A transmitter may lose the arbitration here. For an inserted bit `field_` is that of the bit
/// after it.
bool BitStreamProcessor::in_arbitration() const {
    const FrameField last =
        sends_extended_ ? FrameField::extended_remote_request : FrameField::remote_request;
    return field_ >= FrameField::identifier && field_ <= last;
}

BitStreamProcessor::Events BitStreamProcessor::step_stuffed(std::uint8_t seen) {
    Events events = 0;
    if (run_ == stuff_run) {
        if (seen == last_) {
            const bool is_bit_error = transmitter_ && (driven_ == 0 || !in_arbitration());
            return fail(is_bit_error ? ErrorKind::bit : ErrorKind::stuff, position());
        }
        last_ = seen;
        run_ = 1;
    } else {
        if (transmitter_ && seen != driven_) {
            if (seen == 1 || !in_arbitration()) return fail(ErrorKind::bit, position());
            transmitter_ = false;
            // In the order of the fields, with IDE and SRR or RTR one bit each.
            const int before = field_ == FrameField::identifier             ? 0
                               : field_ == FrameField::remote_request       ? identifier_bits
                               : field_ == FrameField::identifier_extension ? identifier_bits + 1
                               : field_ == FrameField::extended_identifier
                                   ? identifier_bits + 2
                                   : identifier_bits + 2 + extended_identifier_bits;
            lost_at_ = static_cast<std::uint8_t>(before + index_);
            events |= lost_arbitration;
        }
        run_ = seen == last_ ? run_ + 1 : 1;
        last_ = seen;
        accept(seen);
    }
    if (field_ == FrameField::crc_delimiter && run_ != stuff_run) {
        enter(State::crc_delimiter);
    } else {
        driven_ = transmitter_ ? bits_.bits[next_bit_++] : 1;
    }
    return events;
}

void BitStreamProcessor::accept(std::uint8_t seen) {
    if (run_ == stuff_run) stuffed_after_ = {field_, index_, true};
    take(seen);
    if (field_ == FrameField::data && index_ == field_step_) {
        frame_.data[static_cast<std::size_t>(index_ / 8 - 1)] =
            static_cast<std::uint8_t>(value_ & 0xFFU);
        field_step_ = static_cast<std::uint8_t>(field_step_ + 8);
    }
    if (index_ == width_) finish_field();
}

void BitStreamProcessor::finish_field() {
    switch (field_) {
        case FrameField::start_of_frame:
            return enter_field(FrameField::identifier, identifier_bits);
        case FrameField::identifier:
            frame_.id = value_;
            return enter_field(FrameField::remote_request, 1);
        case FrameField::remote_request:
            frame_.remote = value_ != 0;
            return enter_field(FrameField::identifier_extension, 1);
        case FrameField::identifier_extension:
            frame_.extended = value_ != 0;
            if (frame_.extended) {
                return enter_field(FrameField::extended_identifier, extended_identifier_bits);
            }
            return enter_field(FrameField::reserved_0, 1);
        case FrameField::extended_identifier:
            frame_.id = (frame_.id << extended_identifier_bits) | value_;
            return enter_field(FrameField::extended_remote_request, 1);
        case FrameField::extended_remote_request:
            frame_.remote = value_ != 0;
            return enter_field(FrameField::reserved_1, 1);
        case FrameField::reserved_1:
            return enter_field(FrameField::reserved_0, 1);
        case FrameField::reserved_0:
            return enter_field(FrameField::data_length_code, 4);
        case FrameField::data_length_code:
            frame_.length = static_cast<std::uint8_t>(
                std::min<std::uint32_t>(value_, Frame::max_classic_payload));
            if (frame_.length == 0 || frame_.remote) {
                return enter_field(FrameField::crc, crc_bits);
            }
            return enter_field(FrameField::data, 8 * frame_.length);
        case FrameField::data:
            return enter_field(FrameField::crc, crc_bits);
        default:
            return enter_field(FrameField::crc_delimiter, 1);
    }
}

// ---- CRC delimiter to EOF

BitStreamProcessor::Events BitStreamProcessor::step_tail(std::uint8_t seen) {
    const bool is_dominant = seen == 0;
    // With its own CRC sequence in it the register of an intact frame is 0 at the end.
    const bool crc_ok = crc_ == 0;
    switch (state_) {
        case State::crc_delimiter:
            if (is_dominant) return fail(ErrorKind::form, position());
            enter(State::ack_slot);
            driven_ = !transmitter_ && crc_ok ? 0 : 1;
            return 0;
        case State::ack_slot:
            if (transmitter_ && !is_dominant) return fail(ErrorKind::acknowledgment, position());
            if (driven_ == 0) {
                if (!is_dominant) return fail(ErrorKind::bit, position());
                if (!silent_) confinement_.received();
            }
            enter(State::ack_delimiter);
            return 0;
        case State::ack_delimiter:
            if (is_dominant) return fail(ErrorKind::form, position());
            if (!transmitter_ && !crc_ok) return fail(ErrorKind::crc, position());
            enter(State::end_of_frame);
            return 0;
        default:
            break;
    }
    const bool is_last = count_ + 1 == end_of_frame_bits;
    if (is_dominant && (transmitter_ || !is_last)) return fail(ErrorKind::form, position());
    if (!is_last) {
        ++count_;
        return 0;
    }
    // For a receiver the frame is valid whatever this bit is: it was without error up to the last
    // but one.
    if (transmitter_) confinement_.transmitted();
    Events events = transmitter_ ? sent : received;
    if (is_dominant) {
        events |= begin_overload_flag();
    } else {
        enter(State::intermission);
    }
    return events;
}

// ---- errors and overload

BitStreamProcessor::Events BitStreamProcessor::fail(ErrorKind kind, FramePosition where) {
    error_ = {kind, where, transmitter_};
    const bool is_passive = !confinement_.is_active();
    unacknowledged_ = false;
    if (!silent_) {
        if (!transmitter_) {
            confinement_.receiver_detected_error();
        } else if (kind == ErrorKind::acknowledgment && is_passive) {
            unacknowledged_ = true;  // rule 3, exception 1
        } else if (kind != ErrorKind::stuff) {
            // Exception 2: for a transmitter only a recessive stuff bit in the arbitration that
            // was overwritten is a stuff error.
            confinement_.transmitter_sends_error_flag();
        }
    }
    begin_error_flag(is_passive);
    return detected_error;
}

BitStreamProcessor::Events BitStreamProcessor::flag_bit_error() {
    error_ = {ErrorKind::bit, position(), transmitter_};
    const bool is_passive = !confinement_.is_active();
    confinement_.bit_error_in_flag(transmitter_);
    begin_error_flag(is_passive);
    return detected_error;
}

/// `is_passive`: before the error was counted. The one that makes a node passive still has an
/// active flag (rule 9).
void BitStreamProcessor::begin_error_flag(bool is_passive) {
    enter(is_passive ? State::passive_error_flag : State::active_error_flag);
    driven_ = is_passive ? 1 : 0;
    run_ = 0;
}

BitStreamProcessor::Events BitStreamProcessor::begin_overload_flag() {
    overload_position_ = position();
    enter(State::overload_flag);
    driven_ = 0;
    return overload;
}

BitStreamProcessor::Events BitStreamProcessor::step_flag(std::uint8_t seen) {
    if (state_ == State::passive_error_flag) {
        if (seen == 0 && unacknowledged_) {
            unacknowledged_ = false;
            confinement_.transmitter_sends_error_flag();
        }
        // It is over after six equal bits, whoever sends them.
        run_ = run_ > 0 && seen == last_ ? run_ + 1 : 1;
        last_ = seen;
        if (count_ < flag_bits) ++count_;
        if (run_ == flag_bits) enter(State::error_superposition);
        return 0;
    }
    if (seen != 0) return flag_bit_error();
    if (++count_ == flag_bits) {
        enter(state_ == State::overload_flag ? State::overload_superposition
                                             : State::error_superposition);
    }
    return 0;
}

BitStreamProcessor::Events BitStreamProcessor::step_superposition(std::uint8_t seen) {
    const bool is_error = state_ == State::error_superposition;
    if (seen != 0) {
        enter(is_error ? State::error_delimiter : State::overload_delimiter);
        count_ = 1;
        return 0;
    }
    ++count_;
    if (count_ == 1 && is_error && !transmitter_ && !silent_) {
        confinement_.receiver_flag_was_first();
    }
    if (count_ % dominant_bits_tolerated == 0 && !silent_) {
        confinement_.eight_dominant_bits(transmitter_);
    }
    // A bus may be dominant for ever.
    if (count_ == 2 * dominant_bits_tolerated) count_ = dominant_bits_tolerated;
    return 0;
}

BitStreamProcessor::Events BitStreamProcessor::step_delimiter(std::uint8_t seen) {
    const bool is_last = count_ + 1 == delimiter_bits;
    if (seen == 0) {
        if (!is_last) return fail(ErrorKind::form, position());
        return begin_overload_flag();
    }
    if (is_last) {
        enter(State::intermission);
    } else {
        ++count_;
    }
    return 0;
}

// ---- between frames

BitStreamProcessor::Events BitStreamProcessor::step_between(std::uint8_t seen) {
    if (seen != 0) {
        skip_recessive(1);  // a change of state is seen by step()
        return 0;
    }
    switch (state_) {
        case State::idle:
        case State::suspend:
            begin_frame();
            return step_stuffed(seen);
        case State::intermission:
            if (count_ + 1 < intermission_length) {
                return begin_overload_flag();
            } else {
                // Taken for a SOF. Who has a frame to send goes on with its identifier.
                const bool suspended = transmitter_ && !confinement_.is_active();
                begin_frame();
                step_stuffed(seen);
                may_join_ = !suspended;
                return may_join_ ? joinable : Events{0};
            }
        default:
            run_ = 0;
            return 0;
    }
}

void BitStreamProcessor::leave_intermission() {
    const bool suspended = transmitter_ && !confinement_.is_active();
    transmitter_ = false;
    enter(suspended ? State::suspend : State::idle);
}

int BitStreamProcessor::intermission_left() const {
    return state_ == State::intermission ? intermission_length - count_ : 0;
}

BitStreamProcessor::Events BitStreamProcessor::skip_recessive(std::uint64_t bits) {
    assert(is_between_frames());
    if (state_ == State::intermission) {
        const auto left = static_cast<std::uint64_t>(intermission_length - count_);
        const std::uint64_t taken = std::min(bits, left);
        count_ += static_cast<int>(taken);
        bits -= taken;
        if (taken == left) leave_intermission();
    }
    if (bits == 0) return 0;
    if (state_ == State::suspend) {
        const auto left = static_cast<std::uint64_t>(suspend_bits - count_);
        count_ += static_cast<int>(std::min(bits, left));
        if (bits >= left) enter(State::idle);
    } else if (state_ == State::integrating) {
        run_ = static_cast<int>(
            std::min<std::uint64_t>(bits + static_cast<std::uint64_t>(run_), integration_bits));
        if (run_ == integration_bits) enter(State::idle);
    } else if (is_recovering() && count_recessive(bits)) {
        confinement_.recovered();
        recovering_ = false;
        enter(State::idle);
        return status_changed;
    }
    return 0;
}

/// In bus-off. True: that was enough.
bool BitStreamProcessor::count_recessive(std::uint64_t bits) {
    const std::int64_t run = run_ + static_cast<std::int64_t>(bits);
    sequences_ += static_cast<int>(run / integration_bits);
    run_ = static_cast<int>(run % integration_bits);
    return sequences_ >= recovery_sequences;
}

std::optional<std::uint64_t> BitStreamProcessor::bits_to_start() const {
    switch (state_) {
        case State::suspend:
            return static_cast<std::uint64_t>(suspend_bits - count_);
        case State::intermission: {
            const bool suspended = transmitter_ && !confinement_.is_active();
            return static_cast<std::uint64_t>(intermission_left() + (suspended ? suspend_bits : 0));
        }
        case State::integrating:
            return static_cast<std::uint64_t>(integration_bits - run_);
        case State::bus_off:
            return std::nullopt;
        default:
            return 0;
    }
}

std::optional<std::uint64_t> BitStreamProcessor::bits_to_recovery() const {
    if (!is_recovering()) return std::nullopt;
    return static_cast<std::uint64_t>((recovery_sequences - sequences_) * integration_bits - run_);
}

void BitStreamProcessor::enter_bus_off() {
    enter(State::bus_off);
    transmitter_ = false;
    recovering_ = automatic_recovery_;
    sequences_ = 0;
    run_ = 0;
}

void BitStreamProcessor::recover(bool partial) {
    if (state_ != State::bus_off || recovering_) return;
    recovering_ = true;
    sequences_ = 0;
    run_ = partial ? -1 : 0;
}

void BitStreamProcessor::recovered_for(int bits) {
    assert(is_recovering());
    run_ = bits;
}

void BitStreamProcessor::end_undisturbed(bool transmitter) {
    if (!takes_part()) {
        run_ = recessive_end_bits;
        return;
    }
    transmitter_ = transmitter;
    if (transmitter) {
        confinement_.transmitted();
    } else if (!silent_) {
        confinement_.received();
    }
    enter(State::intermission);
}

// ---- what it tells

FramePosition BitStreamProcessor::position() const {
    const auto counted = [this](FrameField field) {
        return FramePosition{field, static_cast<std::uint8_t>(count_), false};
    };
    switch (state_) {
        case State::stuffed:
            if (run_ == stuff_run) return stuffed_after_;
            return {field_, index_, false};
        case State::crc_delimiter:
            return counted(FrameField::crc_delimiter);
        case State::ack_slot:
            return counted(FrameField::ack_slot);
        case State::ack_delimiter:
            return counted(FrameField::ack_delimiter);
        case State::end_of_frame:
            return counted(FrameField::end_of_frame);
        case State::active_error_flag:
            return counted(FrameField::active_error_flag);
        case State::passive_error_flag:
            return counted(FrameField::passive_error_flag);
        case State::error_superposition:
        case State::overload_superposition:
            return counted(FrameField::error_superposition);
        case State::error_delimiter:
            return counted(FrameField::error_delimiter);
        case State::overload_flag:
            return counted(FrameField::overload_flag);
        case State::overload_delimiter:
            return counted(FrameField::overload_delimiter);
        case State::intermission:
            return counted(FrameField::intermission);
        case State::suspend:
            return counted(FrameField::suspend_transmission);
        case State::idle:
        case State::integrating:
        case State::bus_off:
            break;
    }
    return {};
}

}  // namespace canorb::can::sim
