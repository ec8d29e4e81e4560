#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace canorb::bench {

/// What an operation carries, for protocols that are calculated and not run: octets of its values
/// in a plain encoding without alignment, strings and sequences without length.
struct Values {
    std::size_t request = 0;
    std::size_t reply = 0;
    std::size_t strings = 0;    ///< strings and sequences up to 255 octets in the request
    std::size_t long_ones = 0;  ///< and longer ones
    bool answered = true;       ///< it has a reply
    bool raises = false;        ///< it ends with an exception
};

/// CANopen (CiA 301) with SDOs, classical CAN: a call is a write of the parameters to one entry of
/// the object dictionary, and a read of the result from another where there is one. Up to 4 octets
/// expedited, more segmented. A call without parameters writes one octet. A oneway call is a PDO.
/// An exception is an abort in place of the answer.
nlohmann::ordered_json with_canopen(const Values& values);

/// Cyphal/CAN 1.0, classical CAN: a service request and response with 29-bit identifiers; a oneway
/// call is a message. One tail octet in each frame, two octets of CRC where there are several. An
/// exception is a response with one octet that tells which, and its values.
nlohmann::ordered_json with_cyphal(const Values& values);

}  // namespace canorb::bench
