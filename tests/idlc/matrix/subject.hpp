#pragma once

/// What is checked of the values of any type.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "canorb/types.hpp"

namespace canorb::test {

struct Random;

using Octets = std::vector<std::uint8_t>;

/// A value whose type the checks need not know: so they are compiled once.
class Subject {
  public:
    virtual ~Subject() = default;
    /// Another, of the same type.
    virtual std::unique_ptr<Subject> make() const = 0;
    virtual void encode(ccdr::Encoder& out) const = 0;
    virtual void decode(ccdr::Decoder& in) = 0;
    virtual bool equals(const Subject& other) const = 0;
    /// The octets of its type code.
    virtual std::string type_code() const = 0;
};

// The members of SubjectOf hide these names.
template <typename T>
void encode_value(ccdr::Encoder& out, const T& value) {
    encode(out, value);
}
template <typename T>
void decode_value(ccdr::Decoder& in, T& value) {
    decode(in, value);
}

/// Exceptions are compared by the member that all of them have here.
template <typename T>
bool are_equal(const T& a, const T& b) {
    if constexpr (std::is_base_of_v<UserException, T>) {
        return a.value == b.value;
    } else {
        return a == b;
    }
}

template <typename T>
class SubjectOf : public Subject {
  public:
    std::unique_ptr<Subject> make() const override { return std::make_unique<SubjectOf>(); }
    void encode(ccdr::Encoder& out) const override { encode_value(out, value); }
    void decode(ccdr::Decoder& in) override { decode_value(in, value); }
    bool equals(const Subject& other) const override {
        return are_equal(value, static_cast<const SubjectOf&>(other).value);
    }
    std::string type_code() const override {
        std::string octets;
        ccdr::TypeCodeOf<T>::append(octets);
        return octets;
    }

    T value{};
};

/// The octets of a random value of one of the types of types.idl, by its name without the "T_".
Octets random_octets(std::string_view type, Random& random);

/// That these octets are a value of the subject's type, alone and in an any, and become themselves
/// again; that octets which are cut off, have wrong bits or are no value at all do no harm.
void check(Subject& subject, const Octets& octets, Random& random);

/// That the subject, given `first` and then `second`, is `second`, as a fresh one is.
void check_change(Subject& subject, const Octets& first, const Octets& second);

/// The same for each type in each run of the tests.
std::uint64_t seed_of(std::string_view name);

void append(Octets& to, const Octets& octets);

}  // namespace canorb::test
