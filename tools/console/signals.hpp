#pragma once

#include <cstdint>

#include "orb/can/link/descriptor.hpp"

namespace canorb::console {

/// Ctrl-C, SIGTERM and SIGHUP while it lives: they end nothing by themselves, but can be waited
/// for. To be made before threads are, which must not get them either. The second one ends the
/// program as if nobody had asked for it.
class StopSignals {
  public:
    StopSignals();
    ~StopSignals();
    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;

    enum class Woken : std::uint8_t { by_signal, by_descriptor, by_time };
    /// Waits until one comes, `descriptor` is readable, or `timeout_ms` passed; -1: no limit.
    Woken wait(int descriptor, int timeout_ms = -1) const;

  private:
    can::Descriptor arrived_;
};

}  // namespace canorb::console
