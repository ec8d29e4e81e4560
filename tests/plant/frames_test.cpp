// One round on the bus, octet by octet: controller 1, sensor 11 in group 2, actuator 21 in group 1.
// Written by hand from doc/wire.

#include <fmt/format.h>

#include "tests/plant/world.hpp"

namespace plant::test {
namespace {

using testing::ElementsAre;

class Frames : public PlantTest {
  protected:
    Frames() : s(sensor(11)), a(actuator(21)), c(controller()) {}

    // As candump writes them, request ids as RRRR: the octets 3 and 4 of a first frame.
    std::vector<std::string> texts() const {
        std::vector<std::string> texts;
        for (const canorb::can::Frame& frame : frames) {
            std::string text = fmt::format("{:03X}#", frame.id);
            for (const std::uint8_t octet : frame.payload()) text += fmt::format("{:02X}", octet);
            const bool continues = (frame.payload()[0] & 0x80) != 0;
            if (!continues) text.replace(4 + 6, 4, "RRRR");
            texts.push_back(text);
        }
        return texts;
    }
    static int request_id(const canorb::can::Frame& frame) {
        return frame.payload()[3] << 8 | frame.payload()[4];
    }

    std::unique_ptr<SensorNode> s;
    std::unique_ptr<ActuatorNode> a;
    std::unique_ptr<ControllerNode> c;
};

// Identifiers: 0 (group), group in five bits, sender in five; or 1, receiver, sender.
//   021  0 00001 00001  to group 1, from the controller    041  0 00010 00001  to group 2
//   42B  1 00001 01011  to the controller, from sensor 11  561  1 01011 00001  and back
// Keys: 7C37 and F7DA are the CRCs of IDL:Plant/Actuator:1.0 and IDL:Plant/Sensor:1.0; 0801 is
// node 1, object 1.
TEST_F(Frames, of_one_round) {
    rounds(2);
    frames.clear();
    rounds(1);
    EXPECT_THAT(texts(),
                ElementsAre("021#100006RRRR7C3701",  // set_state, 6 octets after the header
                            "021#8101",              // on
                            "041#100005RRRRF7DA01",  // poll
                            "42B#10000BRRRR080100",  // push_value, 11 octets
                            "42B#810B0041A00000",    // sensor 11, temperature, 20.0
                            "561#110003RRRR00",      // no exception
                            "42B#10000BRRRR080100",  //
                            "42B#810B0140000000",    // sensor 11, pressure, 2.0
                            "561#110003RRRR00",      //
                            "42B#10000BRRRR080100",  //
                            "42B#810B0242480000",    // sensor 11, level, 50.0
                            "561#110003RRRR00"));
    // Each ORB counts its Requests; a Reply has the id of its Request.
    const auto next = [](int id) { return (id + 1) & 0xFFFF; };
    EXPECT_EQ(request_id(frames[2]), next(request_id(frames[0])));
    EXPECT_EQ(request_id(frames[6]), next(request_id(frames[3])));
    EXPECT_EQ(request_id(frames[9]), next(request_id(frames[6])));
    for (const std::size_t push : {3U, 6U, 9U})
        EXPECT_EQ(request_id(frames[push + 2]), request_id(frames[push]));
}

TEST_F(Frames, of_a_value_over_its_limit) {
    rounds(2);
    s->type("value temperature 80");
    frames.clear();
    rounds(1);
    const auto all = texts();
    ASSERT_EQ(all.size(), 14U);
    EXPECT_EQ(all[1], "021#8101");            // still on
    EXPECT_EQ(all[4], "42B#810B0042A00000");  // 80.0
    // The multicast is sent from within the call, and outranks its Reply.
    EXPECT_EQ(all[5], "021#100006RRRR7C3701");
    EXPECT_EQ(all[6], "021#8100");  // off
    EXPECT_EQ(all[7], "561#110003RRRR00");
}

// The reference of IDL:Plant/Controller:1.0 at node 1, object 1, as a string of 70 characters: its
// length with the NUL is 71, one octet of CCDR. With the header 80 octets, in 12 frames.
TEST_F(Frames, of_the_controllers_introduction) {
    rounds(1);
    simulation.run_for(50ms);
    std::string to_sensors;
    int count = 0;
    for (const canorb::can::Frame& frame : frames) {
        if (frame.id != 0x041 || count == 12) continue;
        const auto payload = frame.payload();
        const bool continues = count > 0;
        if (continues) {
            EXPECT_EQ(payload[0], 0x80 | count);
        }
        for (const std::uint8_t octet : payload.subspan(continues ? 1 : 0))
            to_sensors.push_back(static_cast<char>(octet));
        ++count;
    }
    ASSERT_EQ(to_sensors.size(), 80U);
    EXPECT_EQ(to_sensors.substr(0, 3), std::string("\x10\x00\x4D", 3));  // 77 octets follow
    EXPECT_EQ(to_sensors.substr(5, 3), std::string("\xF7\xDA\x00", 3));  // operation 0
    EXPECT_EQ(to_sensors.substr(8), std::string("\x47"
                                                "CAN_IOR:19"
                                                "49444c3a506c616e742f436f6e74726f6c6c65723a312e3000"
                                                "0000010801\0",
                                                72));
}

}  // namespace
}  // namespace plant::test
