#pragma once

#include <cstdint>
#include <optional>

#include "orb/can/controller.hpp"
#include "orb/can/frame.hpp"
#include "orb/can/frame_length.hpp"
#include "orb/can/sim/error_capture.hpp"
#include "orb/can/sim/fault_confinement.hpp"

namespace canorb::can::sim {

/// What a controller does with bits: one state machine, stepped once per nominal bit time.
/// 0 is dominant, 1 recessive.
///
///     level = a.driven() & b.driven();
///     a.step(level);
///     b.step(level);
///
/// ISO 11898-1 for classic frames (CAN 2.0 B): a receiver takes SRR and the reserved bits as they
/// come, and a DLC above 8 as 8 octets. Where the standard leaves a choice: a bit error in a flag
/// begins the flag anew and counts once (rule 4 or 5); a transmitter's wrong bit in a field of
/// fixed form is a form error; overload flags are sent in reply only, never to gain time.
class BitStreamProcessor {
  public:
    /// What step() has to tell, as a set.
    using Events = std::uint8_t;
    static constexpr Events lost_arbitration = 1;
    static constexpr Events detected_error = 2;
    static constexpr Events sent = 4;      ///< at the end of EOF
    static constexpr Events received = 8;  ///< at the end of EOF
    static constexpr Events status_changed = 16;
    static constexpr Events overload = 64;  ///< begins an overload flag
    static constexpr Events joinable = 32;  ///< may_start() in the middle of a frame

    /// Recessive bits between which a node may take part again.
    static constexpr int integration_bits = 11;
    static constexpr int recovery_sequences = 128;
    static constexpr int suspend_bits = 8;

    /// Has been watching the bus before: `recessive_bits` is how many there were last. With 11 it
    /// takes part at once.
    BitStreamProcessor(bool automatic_recovery, std::uint64_t recessive_bits);

    /// The level that it sends in the bit time to come.
    std::uint8_t driven() const { return silent_ ? std::uint8_t{1} : driven_; }

    /// The bit time is over; `seen` is the level that was sampled.
    Events step(std::uint8_t seen) { return step_plain(seen) ? Events{0} : step_any(seen); }

    /// Begins a frame with the bit to come. Only where may_start().
    void start(const StuffedBits& bits, bool extended);

    /// The bus is idle for it; or another node's SOF has just cut its intermission short, and it
    /// may take part from the first identifier bit on.
    bool may_start() const { return state_ == State::idle || may_join_; }

    /// Sends and receives nothing now: after the end of a frame and before the next one.
    bool is_between_frames() const { return state_ <= State::intermission; }
    /// In a frame, an error or overload frame, or the intermission after it.
    bool is_busy() const { return state_ >= State::intermission; }
    /// Of several processors the lowest and the highest tell: whether any is_idle(), and whether
    /// all are between frames, or any is busy.
    struct Activity {
        std::uint8_t lowest = 0xFF;
        std::uint8_t highest = 0;

        void add(const BitStreamProcessor& processor) {
            const auto state = static_cast<std::uint8_t>(processor.state_);
            lowest = state < lowest ? state : lowest;
            highest = state > highest ? state : highest;
        }
        bool any_idle() const { return lowest == static_cast<std::uint8_t>(State::idle); }
        bool any_busy() const { return highest >= static_cast<std::uint8_t>(State::intermission); }
        bool all_between_frames() const {
            return highest <= static_cast<std::uint8_t>(State::intermission);
        }
    };
    bool is_integrating() const { return state_ == State::integrating; }
    /// Neither bus-off nor still waiting for its first 11 recessive bits.
    bool takes_part() const { return state_ != State::bus_off && state_ != State::integrating; }
    bool is_recovering() const { return state_ == State::bus_off && recovering_; }
    /// Bits of intermission to come, of a frame that is over.
    int intermission_left() const;

    /// Between frames, and as long as the bus is recessive: after how many bits it may start;
    /// nothing in bus-off.
    std::optional<std::uint64_t> bits_to_start() const;
    /// And after how many bus-off is over; nothing where it is not recovering.
    std::optional<std::uint64_t> bits_to_recovery() const;
    /// So many recessive bits at once. Only between frames. status_changed when bus-off is over.
    Events skip_recessive(std::uint64_t bits);

    /// The end of the EOF of a frame that nothing disturbed and somebody acknowledged, without the
    /// bits before it. Only between frames.
    void end_undisturbed(bool transmitter);
    /// Whether the end of such a frame is then all there is to tell.
    bool is_predictable() const { return confinement_.status().rec <= 127; }

    /// Silent on the bus, from the next frame on: as ISO 11898-1 has it for bus monitoring, what
    /// would be dominant is seen by itself only, and the counters stand still. `dominant`: a bit is
    /// under way that may be a SOF.
    void set_listen_only(bool on, bool dominant);
    bool is_listen_only() const { return listen_only_; }
    bool is_silent() const { return silent_; }  ///< in the present frame

    /// Leaves bus-off after 128 times 11 recessive bits. `partial`: the bit time under way does not
    /// count.
    void recover(bool partial);
    /// For a frame in one step: `bits` of its end were after recover().
    void recovered_for(int bits);

    const ErrorStatus& status() const { return confinement_.status(); }
    /// Where the bit to come is.
    FramePosition position() const;
    /// After `received`.
    const Frame& frame() const { return frame_; }
    /// After `lost_arbitration`: 0..31 as an SJA1000 counts.
    std::uint8_t lost_at() const { return lost_at_; }
    /// After `detected_error`.
    const ErrorCapture& error() const { return error_; }
    /// After `overload`: the bit that should not have been dominant.
    FramePosition overload_position() const { return overload_position_; }

  private:
    enum class State : std::uint8_t {
        // between frames
        idle,
        suspend,
        integrating,
        bus_off,
        intermission,
        // in a frame
        stuffed,  ///< SOF to the CRC
        crc_delimiter,
        ack_slot,
        ack_delimiter,
        end_of_frame,
        active_error_flag,
        passive_error_flag,
        error_superposition,
        error_delimiter,
        overload_flag,
        overload_superposition,
        overload_delimiter,
    };

    static constexpr int stuff_run = 5;
    static constexpr int crc_bits = 15;
    static constexpr std::uint32_t crc_polynomial = 0x4599;

    /// Nine of ten bits: inside a field, not stuffed, as sent. False: it is not one of these, and
    /// nothing is done yet.
    bool step_plain(std::uint8_t seen) {
        const int run = seen == last_ ? run_ + 1 : 1;
        const bool is_plain = state_ == State::stuffed && run < stuff_run && run_ != stuff_run &&
                              index_ + 1 < field_step_ && (seen == driven_ || !transmitter_);
        if (!is_plain) return false;
        run_ = run;
        last_ = seen;
        take(seen);
        driven_ = transmitter_ ? bits_.bits[next_bit_++] : 1;
        return true;
    }
    void take(std::uint8_t seen) {
        const std::uint32_t feedback = (crc_ >> (crc_bits - 1)) ^ seen;
        crc_ = ((crc_ << 1) & ((1U << crc_bits) - 1)) ^ (crc_polynomial & (0U - feedback));
        value_ = (value_ << 1) | seen;
        ++index_;
    }

    Events step_any(std::uint8_t seen);
    Events step_stuffed(std::uint8_t seen);
    Events step_tail(std::uint8_t seen);
    Events step_flag(std::uint8_t seen);
    Events step_superposition(std::uint8_t seen);
    Events step_delimiter(std::uint8_t seen);
    Events step_between(std::uint8_t seen);

    void begin_frame();
    void accept(std::uint8_t seen);
    void enter_field(FrameField field, int width);
    void finish_field();
    bool in_arbitration() const;
    void enter(State state);
    void leave_intermission();
    void begin_error_flag(bool is_passive);
    Events begin_overload_flag();
    void enter_bus_off();
    Events dispatch(std::uint8_t seen);
    Events fail(ErrorKind kind, FramePosition position);
    Events flag_bit_error();
    bool count_recessive(std::uint64_t bits);

    // What every bit needs.
    State state_ = State::idle;
    std::uint8_t driven_ = 1;
    bool transmitter_ = false;     ///< of the frame, until it is over or the arbitration lost
    std::uint8_t last_ = 1;        ///< the bit before
    int run_ = 0;                  ///< equal bits up to it
    std::uint8_t index_ = 0;       ///< in the field
    std::uint8_t field_step_ = 0;  ///< the end of the field, or of the octet of data
    FrameField field_ = FrameField::idle;
    std::uint32_t value_ = 0;  ///< of the field
    std::uint32_t crc_ = 0;
    std::size_t next_bit_ = 0;
    StuffedBits bits_;

    FaultConfinement confinement_;
    bool may_join_ = false;
    bool listen_only_ = false;
    bool silent_ = false;  ///< listen-only, in this frame
    bool automatic_recovery_;
    bool recovering_ = false;
    /// Rule 3, exception 1: a dominant bit in this passive error flag would count.
    bool unacknowledged_ = false;

    int count_ = 0;      ///< bits of the present state
    int sequences_ = 0;  ///< of 11 recessive bits, in bus-off

    int width_ = 0;  ///< of the field
    FramePosition stuffed_after_;
    Frame frame_;
    bool sends_extended_ = false;

    std::uint8_t lost_at_ = 0;
    ErrorCapture error_;
    FramePosition overload_position_;
};

}  // namespace canorb::can::sim
