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

    /// Recessive bits between which a node may take part again.
    static constexpr int integration_bits = 11;
    static constexpr int recovery_sequences = 128;
    static constexpr int suspend_bits = 8;

    /// Has been watching the bus before: `recessive_bits` is how many there were last. With 11 it
    /// takes part at once.
    BitStreamProcessor(bool automatic_recovery, std::uint64_t recessive_bits);

    /// The level that it sends in the bit time to come.
    std::uint8_t driven() const { return driven_; }

    /// The bit time is over; `seen` is the level that was sampled.
    Events step(std::uint8_t seen);

    /// Begins a frame with the bit to come. Only where may_start().
    void start(const StuffedBits& bits, bool extended);

    /// The bus is idle for it; or another node's SOF has just cut its intermission short, and it
    /// may take part from the first identifier bit on.
    bool may_start() const { return state_ == State::idle || may_join_; }

    /// Sends and receives nothing now: after the end of a frame and before the next one.
    bool is_between_frames() const { return state_ <= State::intermission; }
    /// In a frame, an error or overload frame, or the intermission after it.
    bool is_busy() const { return state_ >= State::intermission; }
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

    /// Silent on the bus, from the next frame on. `dominant`: a bit is under way that may be a SOF.
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
    void begin_error_flag();
    void begin_overload_flag();
    void enter_bus_off();
    Events dispatch(std::uint8_t seen);
    Events fail(ErrorKind kind, FramePosition position);
    Events flag_bit_error();
    bool count_recessive(std::uint64_t bits);

    FaultConfinement confinement_;
    State state_ = State::idle;
    std::uint8_t driven_ = 1;
    bool transmitter_ = false;  ///< of the frame, until it is over or the arbitration lost
    bool may_join_ = false;
    bool listen_only_ = false;
    bool silent_ = false;  ///< listen-only, in this frame
    bool automatic_recovery_;
    bool recovering_ = false;
    /// Rule 3, exception 1: a dominant bit in this passive error flag would count.
    bool unacknowledged_ = false;

    std::uint8_t last_ = 1;  ///< the bit before
    int run_ = 0;            ///< equal bits up to it
    int count_ = 0;          ///< bits of the present state
    int sequences_ = 0;      ///< of 11 recessive bits, in bus-off

    FrameField field_ = FrameField::idle;
    int width_ = 0;
    int index_ = 0;
    FramePosition stuffed_after_;
    std::uint32_t value_ = 0;
    std::uint32_t crc_ = 0;
    Frame frame_;

    StuffedBits bits_;
    std::size_t next_bit_ = 0;
    bool sends_extended_ = false;

    std::uint8_t lost_at_ = 0;
    ErrorCapture error_;
};

}  // namespace canorb::can::sim
