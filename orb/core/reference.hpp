#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "orb/base/ids.hpp"
#include "orb/base/result.hpp"
#include "orb/base/system_error.hpp"
#include "orb/ccdr/decoder.hpp"
#include "orb/ccdr/encoder.hpp"

namespace canorb::core {

/// Where a reference leads, as a value. doc/wire/giop.md, "Object references".
struct Reference {
    enum class Kind : std::uint8_t { nil, object, group };

    Kind kind = Kind::nil;
    std::string type_id{};            ///< repository id, or empty where nobody knew
    ObjectKey key{std::uint16_t{0}};  ///< where kind is object
    GroupId group{0};                 ///< where kind is group

    static Reference to_object(ObjectKey key, std::string type_id);
    static Reference to_group(GroupId group, std::string type_id);

    /// Same destination; the type does not count.
    bool same_target(const Reference& other) const;
};

void encode(ccdr::Encoder& out, const Reference& value);
/// Fails the decoder for octets that are no reference.
void decode(ccdr::Decoder& in, Reference& value);

/// Why a text is no reference. `why` is for people and constant.
struct ReferenceError {
    SystemError error;  ///< bad_reference_text or bad_reference_octets
    std::string_view why;
};

/// "CAN_IOR:" and lower-case hex.
std::string to_string(const Reference& reference);

/// Either stringified form: CAN_IOR with hex in either case, or corbaloc:caniop.
Result<Reference, ReferenceError> parse_reference(std::string_view text);

}  // namespace canorb::core
