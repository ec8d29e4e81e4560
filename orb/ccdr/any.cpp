#include "orb/ccdr/any.hpp"

#include "orb/ccdr/format.hpp"
#include "orb/ccdr/nesting.hpp"

namespace canorb {

void Any::assign(TypeCode type, EncodeValue encode_value, const void* value) {
    // Nothing of this any changes before the value is written, for that may be this any itself.
    std::vector<std::uint8_t> octets;
    std::shared_ptr<const ccdr::DecodeContext> context;
    ccdr::EncodeError error{};
    for (const std::size_t size : {std::size_t{64}, std::size_t{4096}, ccdr::largest_message}) {
        octets.resize(size);
        ccdr::Encoder out{octets};
        encode_value(out, value);
        octets.resize(out.size());
        error = out.error();
        if (error == ccdr::EncodeError::buffer_full) continue;
        if (out.context() != nullptr) context = out.context()->shared();
        break;
    }
    is_bad_ = error != ccdr::EncodeError::none;
    if (is_bad_) octets.clear();
    type_ = std::move(type);
    value_ = std::move(octets);
    context_ = std::move(context);
}

void encode(ccdr::Encoder& out, const Any& any) {
    const ccdr::Nesting nesting{out};
    if (!nesting) return;
    if (any.is_bad_) return out.fail();
    encode(out, any.type_);
    if (out.error() != ccdr::EncodeError::none) return;
    // Read as the receiver will: so nothing is sent that it would refuse, as a value that is too
    // deep only because of what is around this any.
    ccdr::Decoder check{any.value_, nullptr, out.levels()};
    ccdr::read_value(check, any.type_.octets());
    if (!check.finished()) return out.fail();
    out.octets(any.value_);
    out.belongs_to(any.context());
}

void decode(ccdr::Decoder& in, Any& any) {
    any = Any{};
    const ccdr::Nesting nesting{in};
    if (!nesting) return;
    TypeCode type;
    decode(in, type);
    const Bytes value = ccdr::read_value(in, type.octets());
    if (!in.ok()) return;
    any.type_ = std::move(type);
    any.value_.assign(value.begin(), value.end());
    if (in.context() != nullptr) any.context_ = in.context()->shared();
}

}  // namespace canorb
