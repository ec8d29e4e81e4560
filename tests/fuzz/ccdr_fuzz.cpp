// Whatever decodes as a type encodes to the same octets again: there is one encoding of a value.
// The first octet chooses the type, the others are decoded.
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "orb/ccdr/bounded.hpp"
#include "orb/ccdr/decoder.hpp"
#include "orb/ccdr/encoder.hpp"

using canorb::BoundedString;
using canorb::BoundedVector;
using canorb::Bytes;
namespace ccdr = canorb::ccdr;

namespace {

struct Record {
    bool flag{};
    std::int16_t level{};
    std::uint64_t serial{};
    std::string name;
    std::vector<std::string> notes;
    std::array<float, 2> range{};
    BoundedVector<BoundedString<4>, 3> tags;
};

void encode(ccdr::Encoder& out, const Record& value) {
    encode(out, value.flag);
    encode(out, value.level);
    encode(out, value.serial);
    encode(out, value.name);
    encode(out, ccdr::bounded<4, 8>(value.notes));
    encode(out, value.range);
    encode(out, value.tags);
}

void decode(ccdr::Decoder& in, Record& value) {
    decode(in, value.flag);
    decode(in, value.level);
    decode(in, value.serial);
    decode(in, value.name);
    decode(in, ccdr::bounded<4, 8>(value.notes));
    decode(in, value.range);
    decode(in, value.tags);
}

template <typename T>
void check(Bytes octets) {
    ccdr::Decoder in{octets};
    T value{};
    decode(in, value);
    if (!in.ok()) return;
    const Bytes read = octets.first(octets.size() - in.remaining());
    std::vector<std::uint8_t> buffer(read.size());
    ccdr::Encoder out{buffer};
    encode(out, value);
    if (out.error() != ccdr::EncodeError::none || out.size() != read.size() ||
        !std::equal(read.begin(), read.end(), buffer.begin())) {
        std::abort();
    }
}

using Check = void (*)(Bytes);
constexpr Check checks[] = {
    check<bool>,
    check<char>,
    check<std::int8_t>,
    check<std::uint8_t>,
    check<std::int16_t>,
    check<std::uint16_t>,
    check<std::int32_t>,
    check<std::uint32_t>,
    check<std::int64_t>,
    check<std::uint64_t>,
    check<float>,
    check<double>,
    check<std::string>,
    check<BoundedString<8>>,
    check<std::array<std::int32_t, 3>>,
    check<std::vector<bool>>,
    check<std::vector<std::uint8_t>>,
    check<std::vector<std::uint32_t>>,
    check<std::vector<std::string>>,
    check<std::vector<std::vector<std::vector<std::int16_t>>>>,
    check<BoundedVector<std::uint16_t, 5>>,
    check<BoundedVector<std::uint8_t, 5>>,
    check<std::vector<BoundedString<3>>>,
    check<Record>,
    check<std::vector<Record>>,
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    checks[data[0] % std::size(checks)](Bytes{data + 1, size - 1});
    return 0;
}
