#include "orb/ccdr/any.hpp"

#include "orb/ccdr/format.hpp"
#include "orb/ccdr/nesting.hpp"

namespace canorb {
void Any::assign(TypeCode type, EncodeValue encode_value, const void* value) {
    type_ = std::move(type);
    context_.reset();
    ccdr::EncodeError error{};
    for (const std::size_t size : {std::size_t{64}, std::size_t{4096}, ccdr::largest_message}) {
        value_.resize(size);
        ccdr::Encoder out{value_};
        encode_value(out, value);
        value_.resize(out.size());
        error = out.error();
        if (error != ccdr::EncodeError::buffer_full) break;
    }
    is_bad_ = error != ccdr::EncodeError::none;
    if (is_bad_) value_.clear();
}

void encode(ccdr::Encoder& out, const Any& any) {
    const ccdr::Nesting nesting{out};
    if (!nesting) return;
    if (any.is_bad_) return out.fail();
    encode(out, any.type_);
    // Read as the receiver will: so nothing is sent that it would refuse, as a value that is too
    // deep only because of what is around this any.
    ccdr::Decoder check{any.value_, nullptr, out.levels()};
    ccdr::read_value(check, any.type_.octets());
    if (!check.finished()) return out.fail();
    out.octets(any.value_);
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
