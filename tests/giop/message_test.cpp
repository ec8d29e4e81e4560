// Requests, Replies and MessageErrors: doc/wire/giop.md. All octets are from that page.
#include "orb/giop/message.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "orb/ccdr/encoder.hpp"
#include "tests/support/octets.hpp"

namespace canorb::giop {
namespace {

using test::hex;
using test::octets;

std::optional<std::size_t> length_of(std::string_view first_frame) {
    return message_length(octets(first_frame));
}

bool is_malformed(std::string_view message) {
    return !parse(octets(message));
}

// SetAttributeValueUL("max_acceleration", 3, 42), operation 7 of object 1 at node 3.
constexpr std::string_view size_vector =
    "10"    // Request, version 1.0
    "0019"  // message_size
    "ABCD"  // request_id
    "1801"  // object_key
    "07"    // operation
    "11 6D61785F616363656C65726174696F6E 00 03 2A";

TEST(Request, WithoutParametersHasEightOctets) {
    std::array<std::uint8_t, request_header_size> header{};
    write_request_header(header, 0xFFFE, ObjectKey{NodeId{3}, 1}.value(), 2, 0);
    EXPECT_EQ(hex(header), "100005FFFE180102");
}

TEST(Request, WithoutParametersIsRead) {
    const auto golden = octets("10 0005 FFFE 1801 02");
    const std::optional<Message> message = parse(golden);
    ASSERT_TRUE(message);
    const auto* request = std::get_if<Request>(&*message);
    ASSERT_NE(request, nullptr);
    EXPECT_EQ(request->id, 0xFFFE);
    EXPECT_EQ(request->object_key, 0x1801);
    EXPECT_EQ(ObjectKey{request->object_key}, (ObjectKey{NodeId{3}, 1}));
    EXPECT_EQ(request->operation, 2);
    EXPECT_TRUE(request->parameters.empty());
}

TEST(Request, OfTheSizeVectorHasTwentyEightOctets) {
    std::array<std::uint8_t, 64> buffer{};
    ccdr::Encoder out{MutableBytes{buffer}.subspan(request_header_size)};
    out.string("max_acceleration");
    out.variable_unsigned(3);
    out.variable_unsigned(42);
    write_request_header(std::span{buffer}.first<request_header_size>(), 0xABCD, 0x1801, 7,
                         out.size());
    const Bytes message = Bytes{buffer}.first(request_header_size + out.size());
    EXPECT_EQ(message.size(), 28U);
    EXPECT_EQ(hex(message), hex(octets(size_vector)));
}

TEST(Request, OfTheSizeVectorIsRead) {
    const auto golden = octets(size_vector);
    const std::optional<Message> message = parse(golden);
    ASSERT_TRUE(message);
    const auto* request = std::get_if<Request>(&*message);
    ASSERT_NE(request, nullptr);
    EXPECT_EQ(request->id, 0xABCD);
    EXPECT_EQ(request->operation, 7);
    EXPECT_EQ(hex(request->parameters), "116D61785F616363656C65726174696F6E00032A");
    EXPECT_EQ(request->parameters.data(), golden.data() + 8) << "a view, not a copy";
}

TEST(Reply, OfAVoidOperationHasSixOctets) {
    std::array<std::uint8_t, reply_header_size> header{};
    write_reply_header(header, 0xFFFE, ReplyStatus::no_exception, 0);
    EXPECT_EQ(hex(header), "110003FFFE00");
}

TEST(Reply, IsRead) {
    const auto golden = octets("11 0007 ABCD 00 40490FDB");
    const std::optional<Message> message = parse(golden);
    ASSERT_TRUE(message);
    const auto* reply = std::get_if<Reply>(&*message);
    ASSERT_NE(reply, nullptr);
    EXPECT_EQ(reply->id, 0xABCD);
    EXPECT_EQ(reply->status, ReplyStatus::no_exception);
    EXPECT_EQ(hex(reply->body), "40490FDB");
}

TEST(Reply, HasThreeStatuses) {
    std::array<std::uint8_t, reply_header_size> header{};
    write_reply_header(header, 1, ReplyStatus::user_exception, 2);
    EXPECT_EQ(hex(header), "110005000101");
    write_reply_header(header, 1, ReplyStatus::system_exception, 0x0102);
    EXPECT_EQ(hex(header), "110105000102");
    for (unsigned status = 0; status <= 0xFF; ++status) {
        auto golden = octets("11 0003 0001 00");
        golden[5] = static_cast<std::uint8_t>(status);
        EXPECT_EQ(parse(golden).has_value(), status <= 2) << status;
        EXPECT_EQ(parse_reply_header(golden).has_value(), status <= 2) << status;
    }
}

TEST(MessageError, IsTheHeaderAlone) {
    EXPECT_EQ(hex(message_error()), "120000");
    const std::optional<Message> message = parse(octets("120000"));
    ASSERT_TRUE(message);
    EXPECT_TRUE(std::holds_alternative<MessageError>(*message));
}

TEST(MessageLength, IsToldByTheFirstThreeOctets) {
    EXPECT_EQ(length_of("10 0005"), 8U);
    EXPECT_EQ(length_of("10 0005 FFFE 1801 02"), 8U);
    EXPECT_EQ(length_of("10 0019 ABCD 1801 07"), 28U);
    EXPECT_EQ(length_of("11 0003"), 6U);
    EXPECT_EQ(length_of("12 0000"), 3U);
    EXPECT_EQ(length_of("10 FFFF"), 65538U);
    EXPECT_EQ(length_of("11 FFFF"), max_message);
}

TEST(MessageLength, OfAnImpossibleSizeIsNothing) {
    for (const char* first_frame :
         {"100000", "100004", "110000", "110002", "120001", "12FFFF", "120100"}) {
        EXPECT_FALSE(length_of(first_frame)) << first_frame;
    }
}

TEST(MessageLength, OfFewerThanThreeOctetsIsNothing) {
    for (const char* first_frame : {"", "10", "1000", "12", "1200"}) {
        EXPECT_FALSE(length_of(first_frame)) << first_frame;
    }
}

TEST(MessageLength, OnlyThreeFirstOctetsAreGiop10) {
    for (unsigned first = 0; first <= 0xFF; ++first) {
        auto message = octets("00 0005 0001 00 0000");
        message[0] = static_cast<std::uint8_t>(first);
        EXPECT_EQ(message_length(message).has_value(), first == 0x10 || first == 0x11) << first;
        EXPECT_EQ(parse(message).has_value(), first == 0x10 || first == 0x11) << first;
    }
}

TEST(Parse, RefusesOctetsThatAreNotTheMessageSize) {
    EXPECT_TRUE(is_malformed(""));
    EXPECT_TRUE(is_malformed("10 0005 FFFE 1801"));
    EXPECT_TRUE(is_malformed("10 0005 FFFE 1801 02 00"));
    EXPECT_TRUE(is_malformed("10 0006 FFFE 1801 02"));
    EXPECT_TRUE(is_malformed("11 0003 FFFE"));
    EXPECT_TRUE(is_malformed("11 0003 FFFE 00 00"));
    EXPECT_TRUE(is_malformed("12 0000 00"));
}

TEST(Parse, RefusesEveryPrefix) {
    const auto golden = octets(size_vector);
    for (std::size_t size = 0; size < golden.size(); ++size) {
        const std::vector<std::uint8_t> prefix{golden.data(), golden.data() + size};
        EXPECT_FALSE(parse(prefix)) << size;
    }
}

TEST(RequestHeader, IsReadFromTheFirstFrameOfALongerMessage) {
    const std::optional<Request> request = parse_request_header(octets("10 FFFF ABCD 1801 07"));
    ASSERT_TRUE(request);
    EXPECT_EQ(request->id, 0xABCD);
    EXPECT_EQ(request->object_key, 0x1801);
    EXPECT_EQ(request->operation, 7);
    EXPECT_TRUE(request->parameters.empty());
}

TEST(RequestHeader, OfAnythingElseIsNothing) {
    for (const char* first_frame : {"10 FFFF ABCD 1801", "11 FFFF ABCD 0001 07", "12 0000",
                                    "10 0004 ABCD 1801 07", "14 FFFF ABCD 1801 07", ""}) {
        EXPECT_FALSE(parse_request_header(octets(first_frame))) << first_frame;
    }
}

TEST(ReplyHeader, IsReadFromTheFirstFrameOfALongerMessage) {
    const std::optional<Reply> reply = parse_reply_header(octets("11 FFFF ABCD 01 2949"));
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->id, 0xABCD);
    EXPECT_EQ(reply->status, ReplyStatus::user_exception);
    EXPECT_TRUE(reply->body.empty());
}

TEST(ReplyHeader, OfAnythingElseIsNothing) {
    for (const char* first_frame : {"11 FFFF ABCD", "10 FFFF ABCD 0001 07", "12 0000",
                                    "11 0002 ABCD 01 2949", "11 FFFF ABCD 03 2949", ""}) {
        EXPECT_FALSE(parse_reply_header(octets(first_frame))) << first_frame;
    }
}

TEST(LongestMessage, FillsMessageSize) {
    std::array<std::uint8_t, request_header_size> request{};
    write_request_header(request, 1, 2, 3, max_parameter_octets);
    EXPECT_EQ(hex(request), "10FFFF0001000203");
    EXPECT_EQ(max_parameter_octets, 65530U);
    std::array<std::uint8_t, reply_header_size> reply{};
    write_reply_header(reply, 1, ReplyStatus::no_exception, max_body_octets);
    EXPECT_EQ(hex(reply), "11FFFF000100");
    EXPECT_EQ(max_body_octets, 65532U);

    std::vector<std::uint8_t> message(max_message);
    std::copy(request.begin(), request.end(), message.begin());
    const std::optional<Message> parsed = parse(message);
    ASSERT_TRUE(parsed);
    EXPECT_EQ(std::get<Request>(*parsed).parameters.size(), max_parameter_octets);
}

}  // namespace
}  // namespace canorb::giop
