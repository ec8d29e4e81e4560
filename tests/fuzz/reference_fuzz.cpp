// Any text and any octets as an object reference: what is read can be written and read again, and
// stays what it was.
//
// Input: the text, and once more the octets of a reference.

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "orb/base/minor_codes.hpp"
#include "orb/core/reference.hpp"

namespace {

using namespace canorb;

void require(bool holds) {
    if (!holds) std::abort();
}

void require_valid(const core::Reference& reference) {
    if (reference.kind == core::Reference::Kind::object) {
        require(reference.key.node().is_valid());
    } else if (reference.kind == core::Reference::Kind::group) {
        require(reference.group.is_valid());
    } else {
        require(reference.type_id.empty());
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string text(data, data + size);
    const auto parsed = core::parse_reference(text);
    if (parsed) {
        require_valid(*parsed);
        const std::string written = core::to_string(*parsed);
        const auto again = core::parse_reference(written);
        require(again.ok() && again->same_target(*parsed) && again->type_id == parsed->type_id);
        require(core::to_string(*again) == written);
    } else {
        require(parsed.error().error == cause::bad_reference_text ||
                parsed.error().error == cause::bad_reference_octets);
        require(!parsed.error().why.empty());
    }

    ccdr::Decoder in{Bytes{data, size}};
    core::Reference reference;
    decode(in, reference);
    if (!in.ok()) return 0;
    require_valid(reference);
    // There is one encoding only.
    std::vector<std::uint8_t> buffer(size);
    ccdr::Encoder out{buffer};
    encode(out, reference);
    require(out.error() == ccdr::EncodeError::none);
    require(out.size() == size - in.remaining());
    require(
        std::string_view{text}.starts_with(std::string(out.octets().begin(), out.octets().end())));
    return 0;
}
