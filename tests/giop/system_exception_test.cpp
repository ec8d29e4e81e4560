// The body of a SYSTEM_EXCEPTION Reply: doc/wire/giop.md, "Reply".
#include "orb/giop/system_exception.hpp"

#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <vector>

#include "orb/giop/message.hpp"
#include "tests/support/octets.hpp"

namespace canorb::giop {
namespace {

using test::hex;
using test::octets;

std::optional<SystemError> decoded(Bytes body) {
    ccdr::Decoder in{body};
    SystemError error;
    decode(in, error);
    if (!in.finished()) return std::nullopt;
    return error;
}

constexpr std::string_view timeout_body =
    "1E"                                     // 29 octets and the NUL
    "49444C3A 6F6D672E6F7267 2F"             // IDL:omg.org/
    "434F524241 2F 54494D454F5554 3A312E30"  // CORBA/TIMEOUT:1.0
    "00"
    "02"   // minor
    "02";  // MAYBE

TEST(SystemException, IsIdMinorCompletion) {
    std::array<std::uint8_t, 64> buffer{};
    ccdr::Encoder out{buffer};
    encode(out, SystemError{SystemErrorKind::timeout, Completion::maybe, 2});
    ASSERT_EQ(out.error(), ccdr::EncodeError::none);
    EXPECT_EQ(hex(out.octets()), hex(octets(timeout_body)));
}

TEST(SystemException, IsRead) {
    EXPECT_EQ(decoded(octets(timeout_body)),
              (SystemError{SystemErrorKind::timeout, Completion::maybe, 2}));
}

TEST(SystemException, InAReply) {
    // OBJECT_NOT_EXIST, minor 300, NO, in answer to Request 0x1234.
    constexpr std::string_view golden =
        "11 002E 1234 02"  // 3 and a body of 43
        "27 49444C3A 6F6D672E6F7267 2F 434F524241 2F"
        "4F424A4543545F4E4F545F4558495354 3A312E30 00"
        "812C"
        "01";
    std::array<std::uint8_t, reply_header_size + max_system_exception_octets> buffer{};
    ccdr::Encoder out{MutableBytes{buffer}.subspan(reply_header_size)};
    encode(out, SystemError{SystemErrorKind::object_not_exist, Completion::no, 300});
    write_reply_header(std::span{buffer}.first<reply_header_size>(), 0x1234,
                       ReplyStatus::system_exception, out.size());
    EXPECT_EQ(hex(Bytes{buffer}.first(reply_header_size + out.size())), hex(octets(golden)));
}

TEST(SystemException, EveryKindRoundTripsInTheRoomPromised) {
    for (unsigned kind = 0; kind < system_error_kind_count; ++kind) {
        for (const Completion completion : {Completion::yes, Completion::no, Completion::maybe}) {
            const SystemError error{static_cast<SystemErrorKind>(kind), completion, 0xFFFFFFFF};
            std::array<std::uint8_t, max_system_exception_octets> buffer{};
            ccdr::Encoder out{buffer};
            encode(out, error);
            ASSERT_EQ(out.error(), ccdr::EncodeError::none) << repository_id(error.kind);
            EXPECT_EQ(decoded(out.octets()), error) << repository_id(error.kind);
        }
    }
}

TEST(SystemException, AnUnknownIdKeepsMinorAndCompletion) {
    EXPECT_EQ(decoded(octets("05 49444C3A 00 812C 00")),
              (SystemError{SystemErrorKind::unknown, Completion::yes, 300}));
    EXPECT_EQ(decoded(octets("0100 05 01")),
              (SystemError{SystemErrorKind::unknown, Completion::no, 5}));
}

TEST(SystemException, MalformedFormsAreRefused) {
    EXPECT_FALSE(decoded(octets("0100 05 03"))) << "completion above 2";
    EXPECT_FALSE(decoded(octets("0100 05 01 00"))) << "left over";
    EXPECT_FALSE(decoded(octets("00 05 01"))) << "string length 0";
    EXPECT_FALSE(decoded(octets("0100 8005 01"))) << "minor not in its shortest form";
    const auto golden = octets(timeout_body);
    for (std::size_t size = 0; size < golden.size(); ++size) {
        const std::vector<std::uint8_t> prefix{golden.data(), golden.data() + size};
        EXPECT_FALSE(decoded(prefix)) << size;
    }
}

}  // namespace
}  // namespace canorb::giop
