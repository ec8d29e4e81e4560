#pragma once

#include "orb/can/controller.hpp"

namespace canorb::can::sim {

/// A controller's error counters and what follows from them. Each function is one of the twelve
/// rules of CAN's fault confinement, numbered as in the CAN specification 2.0, chapter 8 (ISO
/// 11898-1 has the same ones).
///
/// Invariant: the state is bus-off when TEC > 255, else error passive when TEC or REC > 127, else
/// error active (rules 9 to 11); only recovered() ends bus-off.
class FaultConfinement {
  public:
    const ErrorStatus& status() const { return status_; }
    bool is_active() const { return status_.state == ControllerState::error_active; }
    bool is_bus_off() const { return status_.state == ControllerState::bus_off; }

    /// Rule 1: a receiver detected an error, but not a bit error in its own flag.
    void receiver_detected_error() { add_to_rec(1); }
    /// Rule 2: a receiver saw a dominant bit right after its error flag.
    void receiver_flag_was_first() { add_to_rec(8); }
    /// Rule 3: a transmitter sends an error flag. Its caller knows the two exceptions.
    void transmitter_sends_error_flag() { add_to_tec(8); }
    /// Rules 4 and 5: a bit error while sending an active error flag or an overload flag.
    void bit_error_in_flag(bool transmitter) { add_eight(transmitter); }
    /// Rule 6: eight consecutive dominant bits after a flag, and each eight more.
    void eight_dominant_bits(bool transmitter) { add_eight(transmitter); }
    /// Rule 7.
    void transmitted();
    /// Rule 8: received without error up to the ACK slot, and the ACK was seen on the bus.
    void received();
    /// Rule 12: 128 times 11 recessive bits have passed in bus-off.
    void recovered() { status_ = ErrorStatus{}; }

  private:
    void add_to_tec(int change);
    void add_to_rec(int change);
    void add_eight(bool transmitter);
    void decide();

    ErrorStatus status_;
};

}  // namespace canorb::can::sim
