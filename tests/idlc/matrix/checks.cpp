#include "subject.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <span>

#include "pairs.hpp"
#include "roles.hpp"
#include "tests/support/octets.hpp"
#include "tests/support/soak.hpp"
#include "values.hpp"

namespace canorb::test {

namespace {

/// In memory of just their size, so that reading beyond their end is seen by AddressSanitizer.
Octets octets_of(const Subject& subject) {
    static Octets buffer(1 << 20);
    ccdr::Encoder out{buffer};
    subject.encode(out);
    EXPECT_EQ(out.error(), ccdr::EncodeError::none);
    return {out.octets().begin(), out.octets().end()};
}

bool decodes(Subject& subject, const Octets& octets) {
    ccdr::Decoder in{octets};
    subject.decode(in);
    return in.finished();
}

/// A buffer that is too small by one octet.
void check_full_buffer(const Subject& subject, const Octets& octets) {
    if (octets.empty()) return;
    Octets buffer(octets.size() - 1);
    ccdr::Encoder out{buffer};
    subject.encode(out);
    EXPECT_EQ(out.error(), ccdr::EncodeError::buffer_full) << hex(octets);
}

void check_cut_off(Subject& into, const Octets& octets) {
    // All prefixes of the shorter ones, and as many of the longer.
    constexpr std::size_t most = 100;
    const std::size_t step = octets.size() / most + 1;
    for (std::size_t size = 0; size < octets.size(); size += step) {
        const Octets prefix{octets.begin(), octets.begin() + static_cast<std::ptrdiff_t>(size)};
        EXPECT_FALSE(decodes(into, prefix)) << hex(prefix) << " of " << hex(octets);
    }
    Octets longer = octets;
    longer.push_back(0);
    EXPECT_FALSE(decodes(into, longer)) << hex(longer);
}

/// Whatever is accepted can be encoded, and that is the same value again.
void check_hostile(Subject& into, const Octets& octets) {
    if (!decodes(into, octets)) return;
    const Octets again = octets_of(into);
    ASSERT_TRUE(decodes(into, again)) << hex(octets) << " became " << hex(again);
    ASSERT_EQ(hex(octets_of(into)), hex(again)) << hex(octets);
}

void check_wrong_bits(Subject& into, const Octets& octets, Random& random) {
    if (octets.empty()) return;
    for (int i = 0; i < 20; ++i) {
        Octets forged = octets;
        const std::size_t changes = 1 + random.below(3);
        for (std::size_t change = 0; change < changes; ++change) {
            std::uint8_t& octet = forged[random.below(forged.size())];
            if (random.one_in(4)) {
                octet = static_cast<std::uint8_t>(random.bits());
            } else {
                octet ^= static_cast<std::uint8_t>(1U << random.below(8));
            }
        }
        check_hostile(into, forged);
    }
}

void check_random_octets(Subject& into, Random& random) {
    for (int i = 0; i < 20; ++i) {
        Octets octets(random.below(40));
        // Many small numbers: counts that are right, and texts that end.
        for (std::uint8_t& octet : octets) {
            octet = static_cast<std::uint8_t>(random.bits() >> (56 + random.below(8)));
        }
        check_hostile(into, octets);
    }
}

void check_in_any(const Subject& subject, const Octets& octets, Random& random) {
    Octets in_any;
    const std::string type_code = subject.type_code();
    in_any.assign(type_code.begin(), type_code.end());
    append(in_any, octets);
    SubjectOf<Any> any;
    ASSERT_TRUE(decodes(any, in_any)) << hex(in_any);
    ASSERT_EQ(hex(octets_of(any)), hex(in_any));
    SubjectOf<Any> into;
    check_cut_off(into, in_any);
    check_wrong_bits(into, in_any, random);
}

}  // namespace

std::uint64_t seed_of(std::string_view name) {
    // FNV-1a.
    std::uint64_t hash = 0xCBF29CE484222325;
    for (const char c : name) hash = (hash ^ static_cast<std::uint8_t>(c)) * 0x100000001B3;
    return hash;
}

void append(Octets& to, const Octets& octets) {
    to.insert(to.end(), octets.begin(), octets.end());
}

const std::map<std::string_view, MakeValue>& all_values() {
    static const auto all = [] {
        std::map<std::string_view, MakeValue> values;
        add_values_1(values);
        add_values_2(values);
        add_values_3(values);
        add_values_4(values);
        return values;
    }();
    return all;
}

Octets random_octets(std::string_view type, Random& random) {
    const std::unique_ptr<Value> value = all_values().at(type)();
    value->randomize(random);
    return octets_of(value->subject());
}

void check(Subject& subject, const Octets& octets, Random& random) {
    ASSERT_TRUE(decodes(subject, octets)) << hex(octets);
    ASSERT_EQ(hex(octets_of(subject)), hex(octets));
    const std::unique_ptr<Subject> other = subject.make();
    ASSERT_TRUE(decodes(*other, octets));
    ASSERT_TRUE(other->equals(subject)) << hex(octets);
    check_full_buffer(subject, octets);
    check_in_any(subject, octets, random);
    check_cut_off(*other, octets);
    check_wrong_bits(*other, octets, random);
    check_random_octets(*other, random);
}

void check_change(Subject& subject, const Octets& first, const Octets& second) {
    ASSERT_TRUE(decodes(subject, first)) << hex(first);
    ASSERT_TRUE(decodes(subject, second)) << hex(second);
    ASSERT_EQ(hex(octets_of(subject)), hex(second));
    const std::unique_ptr<Subject> fresh = subject.make();
    ASSERT_TRUE(decodes(*fresh, second));
    ASSERT_TRUE(subject.equals(*fresh)) << hex(second);
}

/// As the struct is declared in CMakeLists.txt.
void check_roles(std::string_view type, Subject& structure, Subject& exception) {
    SCOPED_TRACE(type);
    Random random{seed_of(type)};
    for (std::uint64_t round = 0; round < 5 * soak_factor(); ++round) {
        Octets octets;
        const auto values = [&](int count) {
            for (int i = 0; i < count; ++i) append(octets, random_octets(type, random));
        };
        values(1);  // of_member
        values(2);  // of_array
        append(octets, {2});
        values(2);  // of_sequence
        check(structure, octets, random);
        check(exception, random_octets(type, random), random);
        if (testing::Test::HasFatalFailure()) return;
    }
}

void check_row(std::string_view first, Subject& row) {
    SCOPED_TRACE(first);
    Random random{seed_of(first)};
    for (std::uint64_t round = 0; round < 2 * soak_factor(); ++round) {
        Octets octets;
        bool is_later = false;
        for (const std::string_view second : pair_types) {
            is_later = is_later || second == first;
            if (!is_later) continue;
            append(octets, random_octets(first, random));
            append(octets, random_octets(second, random));
        }
        check(row, octets, random);
        if (testing::Test::HasFatalFailure()) return;
    }
}

TEST(MatrixValues, ComeBack) {
    for (const auto& [name, make] : all_values()) {
        SCOPED_TRACE(name);
        Random random{seed_of(name)};
        const std::unique_ptr<Value> value = make();
        for (std::uint64_t round = 0; round < 20 * soak_factor(); ++round) {
            value->randomize(random);
            SCOPED_TRACE(value->printed());
            const Octets octets = octets_of(value->subject());
            const std::unique_ptr<Subject> back = value->subject().make();
            ASSERT_TRUE(decodes(*back, octets)) << hex(octets);
            ASSERT_TRUE(back->equals(value->subject())) << hex(octets);
            check(*back, octets, random);

            SubjectOf<Any> any;
            any.value = value->to_any();
            SubjectOf<Any> received;
            ASSERT_TRUE(decodes(received, octets_of(any))) << hex(octets_of(any));
            ASSERT_TRUE(received.equals(any));
            ASSERT_TRUE(value->is_in(received.value));
            if (HasFatalFailure()) return;
        }
    }
}

}  // namespace canorb::test
