// Each pair of types as members of one union: one is what it holds, the other is what it gets.

#include <gtest/gtest.h>

#include <cstddef>
#include <iterator>

#include "choice.hpp"
#include "pairs.hpp"
#include "random.hpp"
#include "subject.hpp"

namespace canorb::test {
namespace {

Octets random_choice(std::size_t index, Random& random) {
    Octets octets(10);
    ccdr::Encoder out{octets};
    encode(out, static_cast<std::int16_t>(index));
    octets.resize(out.size());
    append(octets, random_octets(pair_types[index], random));
    return octets;
}

TEST(MatrixPairs, InAUnion) {
    constexpr std::size_t count = std::size(pair_types);
    Random random{seed_of("choice")};
    for (std::size_t first = 0; first < count; ++first) {
        SubjectOf<Pairs::Choice> subject;
        check(subject, random_choice(first, random), random);
        for (std::size_t second = 0; second < count; ++second) {
            SCOPED_TRACE(std::string{pair_types[first]} + ", " + pair_types[second]);
            check_change(subject, random_choice(first, random), random_choice(second, random));
            if (HasFatalFailure()) return;
        }
    }
}

TEST(MatrixPairs, NoOtherMemberInAUnion) {
    SubjectOf<Pairs::Choice> subject;
    Random random{seed_of("none")};
    check(subject, {0x9F, 0xFF}, random);
    subject.value._default();
    EXPECT_EQ(subject.value._d(), static_cast<std::int16_t>(std::size(pair_types)));
    EXPECT_THROW(subject.value.it_boolean(), BAD_PARAM);
    EXPECT_THROW(subject.value._d(0), BAD_PARAM);
}

}  // namespace
}  // namespace canorb::test
