// The packets between a client and the bus daemon, octet by octet (doc/wire/sim-bus.md).

#include "orb/can/sim/protocol.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/octets.hpp"

namespace canorb::can::sim {
namespace {

using canorb::test::hex;
using canorb::test::octets;

const TimePoint some_time = TimePoint{Duration{0x0102030405060708}};

// "canorb-bus"
constexpr std::string_view magic = "63616E6F72622D627573";

std::string golden(std::string_view text) {
    return hex(octets(text));
}

template <typename Form, typename Packets>
std::string encoded(const Form& form) {
    return hex(encode(Packets{form}).bytes());
}

template <typename Form>
std::string client_packet(const Form& form) {
    return encoded<Form, ClientPacket>(form);
}

template <typename Form>
std::string server_packet(const Form& form) {
    return encoded<Form, ServerPacket>(form);
}

template <typename Form>
Form parsed_by_daemon(std::string_view text) {
    const auto packet = parse_client_packet(octets(text));
    EXPECT_TRUE(packet) << text;
    return packet ? std::get<Form>(*packet) : Form{};
}

template <typename Form>
Form parsed_by_client(std::string_view text) {
    const auto packet = parse_server_packet(octets(text));
    EXPECT_TRUE(packet) << text;
    return packet ? std::get<Form>(*packet) : Form{};
}

TEST(SimProtocol, Hello) {
    const std::string text = "01" + std::string{magic} + "01 01 70756D702D33";
    EXPECT_EQ(client_packet(Hello{.wish = Hello::Wish::query, .client_name = "pump-3"}),
              golden(text));
    const Hello hello = parsed_by_daemon<Hello>(text);
    EXPECT_EQ(hello.version, 1);
    EXPECT_EQ(hello.wish, Hello::Wish::query);
    EXPECT_EQ(hello.client_name, "pump-3");
}

TEST(SimProtocol, HelloThatWantsAControllerOrTheStatus) {
    const std::string controller = "01" + std::string{magic} + "01 00";
    EXPECT_EQ(client_packet(Hello{}), golden(controller));
    EXPECT_EQ(parsed_by_daemon<Hello>(controller).wish, Hello::Wish::controller);
    const std::string status = "01" + std::string{magic} + "01 02";
    EXPECT_EQ(client_packet(Hello{.wish = Hello::Wish::status, .client_name = ""}), golden(status));
    EXPECT_EQ(parsed_by_daemon<Hello>(status).wish, Hello::Wish::status);
}

TEST(SimProtocol, OfAnotherVersionsHelloOnlyTheVersionIsKnown) {
    const Hello hello =
        parsed_by_daemon<Hello>("01" + std::string{magic} + "02 FF 00 01 02 03 04 05");
    EXPECT_EQ(hello.version, 2);
    EXPECT_EQ(parsed_by_daemon<Hello>("01" + std::string{magic} + "07").version, 7);
}

TEST(SimProtocol, NamesAreCutAndMadePrintable) {
    EXPECT_EQ(client_packet(Hello{.client_name = "a\nb"}),
              golden("01" + std::string{magic} + "01 00 613F62"));
    EXPECT_EQ(encode(ClientPacket{Hello{.client_name = std::string(99, 'x')}}).bytes().size(),
              13U + 32U);
}

TEST(SimProtocol, Send) {
    const std::string_view text = "02 0102030405060708 0000000000001267 01  00000123 04 DEADBEEF";
    const std::vector<std::uint8_t> data = octets("DEADBEEF");
    const SendRequest request{
        some_time, TransmitHandle{4711}, {.one_shot = true}, Frame::standard(0x123, data)};
    EXPECT_EQ(client_packet(request), golden(text));
    const auto parsed = parsed_by_daemon<SendRequest>(text);
    EXPECT_EQ(parsed.time, some_time);
    EXPECT_EQ(parsed.handle, TransmitHandle{4711});
    EXPECT_TRUE(parsed.options.one_shot);
    EXPECT_EQ(parsed.frame, Frame::standard(0x123, data));
}

TEST(SimProtocol, SendOfAnExtendedRemoteFrame) {
    const std::string_view text = "02 0102030405060708 0000000000000001 00  DFFFFFFF 08";
    Frame frame;
    frame.id = 0x1FFFFFFF;
    frame.extended = true;
    frame.remote = true;
    frame.length = 8;
    EXPECT_EQ(client_packet(SendRequest{some_time, TransmitHandle{1}, {}, frame}), golden(text));
    EXPECT_EQ(parsed_by_daemon<SendRequest>(text).frame, frame);
}

TEST(SimProtocol, AbortListenOnlyRecover) {
    EXPECT_EQ(client_packet(AbortRequest{some_time, TransmitHandle{2}}),
              golden("03 0102030405060708 0000000000000002"));
    EXPECT_EQ(parsed_by_daemon<AbortRequest>("03 0102030405060708 0000000000000002").handle,
              TransmitHandle{2});
    EXPECT_EQ(client_packet(ListenOnlyRequest{some_time, true}), golden("05 0102030405060708 01"));
    EXPECT_TRUE(parsed_by_daemon<ListenOnlyRequest>("05 0102030405060708 01").on);
    EXPECT_EQ(client_packet(RecoverRequest{some_time}), golden("06 0102030405060708"));
    EXPECT_EQ(parsed_by_daemon<RecoverRequest>("06 0102030405060708").time, some_time);
}

TEST(SimProtocol, Filters) {
    const std::string_view text =
        "04 0102030405060708 03  000007E0 00000460  1FFFFFFF 80000123  0000001F 40000005";
    const FilterRequest request{some_time,
                                {{0x7E0, 0x460},
                                 {0x1FFFFFFF, 0x123, true},
                                 {.mask = 0x01F, .value = 5, .data_only = true}}};
    EXPECT_EQ(client_packet(request), golden(text));
    EXPECT_EQ(parsed_by_daemon<FilterRequest>(text).filters, request.filters);
    EXPECT_TRUE(parsed_by_daemon<FilterRequest>("04 0102030405060708 00").filters.empty());
}

TEST(SimProtocol, AsManyFiltersAsFitAPacket) {
    FilterRequest request;
    request.filters.resize(max_packet_filters, Filter{1, 1, true});
    const Packet packet = encode(ClientPacket{request});
    EXPECT_LE(packet.bytes().size(), max_packet_size);
    const auto parsed = parse_client_packet(packet.bytes());
    ASSERT_TRUE(parsed);
    EXPECT_EQ(std::get<FilterRequest>(*parsed).filters, request.filters);
}

TEST(SimProtocol, Welcome) {
    const std::string_view text = "81 01 01 0007A120 0008 0020";
    EXPECT_EQ(server_packet(Welcome{true, 500'000, 8, 32}), golden(text));
    const auto welcome = parsed_by_client<Welcome>(text);
    EXPECT_TRUE(welcome.paced);
    EXPECT_EQ(welcome.bitrate, 500'000U);
    EXPECT_EQ(welcome.mailboxes, 8);
    EXPECT_EQ(welcome.filter_list, 32);
}

TEST(SimProtocol, Refusal) {
    EXPECT_EQ(server_packet(Refusal{1, "no"}), golden("82 01 6E6F"));
    EXPECT_EQ(parsed_by_client<Refusal>("82 02 6E6F").reason, "no");
    EXPECT_EQ(encode(ServerPacket{Refusal{1, std::string(1000, 'x')}}).bytes().size(), 402U);
}

TEST(SimProtocol, Events) {
    const std::vector<std::uint8_t> data = octets("42");
    EXPECT_EQ(server_packet(Received{Frame::standard(0x461, data), some_time}),
              golden("83 0102030405060708 00000461 01 42"));
    EXPECT_EQ(parsed_by_client<Received>("83 0102030405060708 00000461 01 42").frame,
              Frame::standard(0x461, data));
    EXPECT_EQ(server_packet(TransmitResult{TransmitHandle{9}, TransmitOutcome::failed, some_time}),
              golden("84 0000000000000009 02 0102030405060708"));
    EXPECT_EQ(parsed_by_client<TransmitResult>("84 0000000000000009 01 0102030405060708").outcome,
              TransmitOutcome::aborted);
    EXPECT_EQ(server_packet(StateChanged{{ControllerState::bus_off, 256, 3}, some_time}),
              golden("85 02 0100 0003 0102030405060708"));
    EXPECT_EQ(parsed_by_client<StateChanged>("85 01 0080 0003 0102030405060708").status,
              (ErrorStatus{ControllerState::error_passive, 128, 3}));
    EXPECT_EQ(server_packet(FramesLost{5, some_time}),
              golden("86 0000000000000005 0102030405060708"));
    EXPECT_EQ(parsed_by_client<FramesLost>("86 0000000000000005 0102030405060708").count, 5U);
}

TEST(SimProtocol, BusStatus) {
    const std::string_view text =
        "87 0102030405060708"
        "   00000000000F4240"  // 1 000 000 bits, of which
        "   0000000000030D40"  // 200 000 busy
        "   000000000007A120"  // the last second: 500 000
        "   000000000001E848"  // 125 000 busy
        "   0000000000000708"  // 1800 frames
        "   0000000000000003"  // error frames
        "   0001";             // nodes
    EXPECT_EQ(server_packet(BusStatus{some_time, 1'000'000, 200'000, 500'000, 125'000, 1800, 3, 1}),
              golden(text));
    const auto status = parsed_by_client<BusStatus>(text);
    EXPECT_EQ(status.time, some_time);
    EXPECT_EQ(status.bits, 1'000'000U);
    EXPECT_EQ(status.busy_bits, 200'000U);
    EXPECT_EQ(status.recent_bits, 500'000U);
    EXPECT_EQ(status.recent_busy_bits, 125'000U);
    EXPECT_EQ(status.frames, 1800U);
    EXPECT_EQ(status.error_frames, 3U);
    EXPECT_EQ(status.nodes, 1);
}

TEST(SimProtocol, NodeStatus) {
    const std::string_view text =
        "88 01 0088 0007"      // error passive, TEC 136, REC 7
        "   0000000000000001"  // sent
        "   0000000000000102"  // received
        "   0000000000000003"  // lost arbitrations
        "   0000000000000004"  // errors
        "   70756D702D33";     // pump-3
    EXPECT_EQ(
        server_packet(NodeStatus{{ControllerState::error_passive, 136, 7}, 1, 258, 3, 4, "pump-3"}),
        golden(text));
    const auto node = parsed_by_client<NodeStatus>(text);
    EXPECT_EQ(node.status, (ErrorStatus{ControllerState::error_passive, 136, 7}));
    EXPECT_EQ(node.sent, 1U);
    EXPECT_EQ(node.received, 258U);
    EXPECT_EQ(node.lost_arbitrations, 3U);
    EXPECT_EQ(node.errors, 4U);
    EXPECT_EQ(node.name, "pump-3");
    EXPECT_EQ(encode(ServerPacket{NodeStatus{.name = std::string(99, 'x')}}).bytes().size(),
              38U + 32U);
}

TEST(SimProtocol, RefusesMalformedClientPackets) {
    for (const std::string& text : {
             std::string{""},
             std::string{"00"},
             std::string{"07 0102030405060708"},
             std::string{"81 01 01 0007A120 0008 0020"},    // a daemon's
             std::string{"01 63616E6F72622D627574 01 00"},  // magic
             std::string{"01 63616E6F72622D627573"},        // no version
             "01" + std::string{magic} + "01",              // no flags
             "01" + std::string{magic} + "01 03",           // a query and the status
             "01" + std::string{magic} + "01 04",           // unknown flag
             "01" + std::string{magic} + "01 00 0A",        // not printable
             std::string{"02 0102030405060708 0000000000000001 00 00000123 04 DEADBE"},
             std::string{"02 0102030405060708 0000000000000001 00 00000123 04 DEADBEEF00"},
             std::string{"02 0102030405060708 0000000000000001 00 00000123 09 000102030405060708"},
             std::string{"02 0102030405060708 0000000000000001 00 00000800 00"},  // 12 bits
             std::string{"02 0102030405060708 0000000000000001 00 A0000000 00"},  // 30 bits
             std::string{"02 0102030405060708 0000000000000001 02 00000123 00"},  // unknown flag
             std::string{"02 0102030405060708 0000000000000001 00 40000123 04 DEADBEEF"},
             std::string{"03 0102030405060708 00000000000000"},
             std::string{"04 0102030405060708 01 000007E0 000004"},
             std::string{"04 0102030405060708 00 00"},
             std::string{"04 0102030405060708 39"},
             std::string{"05 0102030405060708 02"},
             std::string{"05 0102030405060708"},
             std::string{"06 01020304050607"},
             std::string{"06 0102030405060708 00"},
         }) {
        EXPECT_FALSE(parse_client_packet(octets(text))) << text;
    }
}

TEST(SimProtocol, RefusesMalformedServerPackets) {
    for (const std::string_view text : {
             "",
             "06 0102030405060708",
             "81 02 01 0007A120 0008 0020",
             "81 01 02 0007A120 0008 0020",
             "81 01 01 0007A120 0008 00",
             "82",
             "82 01 0A",
             "83 0102030405060708 00000461 02 42",
             "84 0000000000000009 03 0102030405060708",
             "85 04 0100 0003 0102030405060708",
             "86 0000000000000005 0102030405060708 00",
             "87 0102030405060708 00000000000F4240 0000000000030D40 000000000007A120"
             " 000000000001E848 0000000000000708 0000000000000003 00",
             "87 0102030405060708 00000000000F4240 0000000000030D40 000000000007A120"
             " 000000000001E848 0000000000000708 0000000000000003 0002 00",
             "88 04 0088 0007 0000000000000001 0000000000000102 0000000000000003 0000000000000004",
             "88 01 0088 0007 0000000000000001 0000000000000102 0000000000000003 00000000000000",
             "88 01 0088 0007 0000000000000001 0000000000000102 0000000000000003 0000000000000004"
             " 0A",
             "89",
         }) {
        EXPECT_FALSE(parse_server_packet(octets(text))) << text;
    }
}

}  // namespace
}  // namespace canorb::can::sim
