// What an Orb and a bus refuse, and what they say then.

#include "canorb/bus.hpp"
#include "tests/runtime/world.hpp"

namespace canorb::test {
namespace {

class Options : public World {
  protected:
    std::string refusal(const std::function<void(OrbOptions&)>& change) {
        OrbOptions options = node(3);
        change(options);
        return what<BAD_PARAM>([&] { const Orb orb{bus, options}; });
    }
};

using testing::HasSubstr;

TEST_F(Options, OutOfRangeNameTheirValue) {
    EXPECT_THAT(refusal([](auto& o) { o.node = 31; }), HasSubstr("node 31 is not 0 to 30"));
    EXPECT_THAT(refusal([](auto& o) { o.node = 300; }), HasSubstr("node 300 "));
    EXPECT_THAT(refusal([](auto& o) { o.node = -1; }), HasSubstr("node -1 "));
    EXPECT_THAT(refusal([](auto& o) { o.name = "seventeen letters"; }),
                HasSubstr("'seventeen letters' is longer than 16"));
    EXPECT_THAT(refusal([](auto& o) { o.default_timeout = 0ms; }),
                HasSubstr("default_timeout 0 ns"));
    EXPECT_THAT(refusal([](auto& o) { o.default_timeout = -1ns; }), HasSubstr("-1 ns"));
    EXPECT_THAT(refusal([](auto& o) { o.max_message = 7; }), HasSubstr("max_message 7 "));
    EXPECT_THAT(refusal([](auto& o) { o.max_message = 65539; }), HasSubstr("max_message 65539 "));
    EXPECT_THAT(refusal([](auto& o) { o.max_queued_messages = 0; }),
                HasSubstr("max_queued_messages"));
    EXPECT_THAT(refusal([](auto& o) { o.max_outstanding_calls = 0; }),
                HasSubstr("max_outstanding_calls"));
    EXPECT_THAT(refusal([](auto& o) { o.frames_in_controller = 0; }),
                HasSubstr("frames_in_controller"));
    EXPECT_THAT(refusal([](auto& o) { o.inter_frame_timeout = 0ms; }),
                HasSubstr("inter_frame_timeout 0 ns"));
    EXPECT_THAT(refusal([](auto& o) { o.continuation_gap = 50ms; }),
                HasSubstr("continuation_gap 50000000 ns"));
    EXPECT_THAT(refusal([](auto& o) { o.continuation_gap = -1ns; }), HasSubstr("-1 ns"));
}

TEST_F(Options, AtTheirLimitsAreTaken) {
    for (const int number : {0, 30}) {
        OrbOptions options = node(number);
        options.name = "sixteen letters.";
        options.max_message = number == 0 ? 8 : 65538;
        const Orb orb{bus, options};
        EXPECT_EQ(orb.options().name, "sixteen letters.");
    }
    const Orb orb{bus, node(7)};
    EXPECT_EQ(orb.options().name, "node-7");
    EXPECT_EQ(orb.link_capabilities().bitrate, 500'000U);
    EXPECT_EQ(orb.error_status().state, can::ControllerState::error_active);
    EXPECT_THAT(what<BAD_PARAM>([&] { simulation.add_bus({.bitrate = 4'999}); }),
                HasSubstr("4999"));
}

TEST(NodeNumber, FromText) {
    EXPECT_EQ(parse_node_id("0"), 0);
    EXPECT_EQ(parse_node_id("30"), 30);
    for (const char* text : {"31", "-1", "", "3x", "x", "99999999999999999999", " 3"}) {
        EXPECT_THAT(what<BAD_PARAM>([&] { static_cast<void>(parse_node_id(text)); }),
                    HasSubstr("'" + std::string{text} + "' is no node id"));
    }
}

TEST(BusAddress, ThatIsNoneSaysWhatIs) {
    EXPECT_THAT(what<BAD_PARAM>([] { open_bus("can0"); }),
                HasSubstr("\"can0\" is not a bus address: it begins with none of local:NAME, "
                          "sim:PATH, socketcan:IFNAME"));
    EXPECT_THAT(what<BAD_PARAM>([] { open_bus("local:x?bitrate=5"); }),
                HasSubstr("\"5\" is not a bit rate"));
    EXPECT_THROW(open_bus(""), BAD_PARAM);
    EXPECT_THROW(open_bus("local:"), BAD_PARAM);
}

TEST(BusAddress, WithoutABusSaysHowToGetOne) {
    EXPECT_THAT(what<COMM_FAILURE>([] { open_bus("sim:/nonexistent/bus"); }),
                HasSubstr("start one with: canorb-bus --listen sim:/nonexistent/bus"));
}

}  // namespace
}  // namespace canorb::test
