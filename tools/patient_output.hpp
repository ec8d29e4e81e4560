#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "orb/base/time.hpp"

namespace canorb::tools {

/// Text for a standard output whose reader may be slow, or may have stopped reading: it never makes
/// the writer wait. What the reader has no room for waits here, up to 64 KiB; a text that comes
/// when there is more is left out as a whole, and how many were is said when there is room again.
///
/// Not safe for use by two threads at once.
class PatientOutput {
  public:
    /// `descriptor` outlives this object. `name` is in front of what is said of texts left out.
    PatientOutput(int descriptor, std::string name);
    ~PatientOutput();
    PatientOutput(const PatientOutput&) = delete;
    PatientOutput& operator=(const PatientOutput&) = delete;

    void write(std::string_view text);

    /// Writes what there is room for now.
    void flush();

    /// The same, but waits so long for the reader. To be called at the end.
    void finish(Duration patience);

  private:
    bool write_some(int timeout_ms);

    int descriptor_;
    int own_descriptor_;  ///< the same pipe or terminal, non-blocking; or -1
    std::string name_;
    std::string waiting_;
    std::uint64_t left_out_ = 0;
};

}  // namespace canorb::tools
