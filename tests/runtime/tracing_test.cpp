// Messages as lines: doc/tracing.md. The columns are written down here by hand.

#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "tests/runtime/world.hpp"
#include "tests/support/octets.hpp"

namespace canorb::test {
namespace {

using Lines = std::vector<std::string>;
using testing::ElementsAre;
using testing::EndsWith;
using testing::IsEmpty;
using testing::SizeIs;
using testing::StartsWith;

constexpr std::size_t time_width = 16 + 1;

struct Broken : UserException {
    static constexpr std::string_view repository_id = "IDL:Test/Broken:1.0";
    std::string_view _repository_id() const noexcept override { return repository_id; }
};
void encode(ccdr::Encoder&, const Broken&) {}

class Tracing : public World {
  protected:
    Tracing() {
        server.root_poa().activate_object_with_id(1, servant);
        server.object_join(at(server, 3, 1), GroupId{7});
        server.on_message(into(server_lines));
        client.on_message(into(client_lines));
    }

    /// Keeps the lines without their time.
    static std::function<void(const MessageTrace&)> into(Lines& lines) {
        return [&lines](const MessageTrace& trace) {
            lines.push_back(to_string(trace).substr(time_width));
        };
    }

    /// The request id in the frame that was on the bus as number `i`, in hex.
    std::string id(std::size_t i) const {
        return hex(Bytes{seen.at(i).frame.payload()}.subspan(3, 2));
    }

    /// What is left for the hooks to be told.
    void run() { simulation.run_for(10ms); }

    Orb server{bus, node(3)};
    Orb client{bus, node(5)};
    TestServant servant{{{0, nothing},
                         {1, echo},
                         {2, [](ServerCall& call) { call.raise(Broken{}); }},
                         {3, [](ServerCall&) { throw NO_PERMISSION{"", Completion::no, 200}; }},
                         {4, [](ServerCall& call) { call.oneway(); }}}};
    Lines server_lines;
    Lines client_lines;
};

TEST_F(Tracing, ATwoWayCall) {
    const std::vector<std::uint8_t> octets(10);
    at(client, 3, 1).invoke(1, octets);
    run();
    const std::string i = id(0);
    // 18 octets are frames of 8, 7 and 3; 16 of 8, 7 and 1.
    EXPECT_THAT(client_lines, ElementsAre("out    5 -> 3        Request      " + i +
                                              "    18 octets    3 frames  object 1, operation 1",
                                          "in     3 -> 5        Reply        " + i +
                                              "    16 octets    3 frames  NO_EXCEPTION"));
    EXPECT_THAT(
        server_lines,
        ElementsAre(
            "in     5 -> 3        Request      " + i +
                "    18 octets    3 frames  object 1, operation 1, IDL:Test/Lamp:1.0",
            "out    3 -> 5        Reply        " + i + "    16 octets    3 frames  NO_EXCEPTION"));
}

TEST_F(Tracing, TheTimeIsThatOfTheLastFrame) {
    std::vector<MessageTrace> traces;
    client.on_message([&](const MessageTrace& trace) { traces.push_back(trace); });
    at(client, 3, 1).invoke(0, {});
    run();
    ASSERT_THAT(traces, SizeIs(2));
    ASSERT_THAT(seen, SizeIs(2));
    EXPECT_EQ(traces[0].time, seen[0].end);
    EXPECT_EQ(traces[1].time, seen[1].end);
    MessageTrace late = traces[0];
    late.time = TimePoint{12'345'678'901us + 999ns};
    EXPECT_THAT(to_string(late), StartsWith("    12345.678901 out    5 -> 3 "));
    late.time = TimePoint{};
    EXPECT_THAT(to_string(late), StartsWith("        0.000000 out    5 -> 3 "));
}

TEST_F(Tracing, ACallToAGroup) {
    call_through(group(client, 7), ring);
    run();
    const std::string i = id(0);
    const std::string key = hex(Bytes{seen.at(0).frame.payload()}.subspan(5, 2));
    EXPECT_THAT(client_lines,
                ElementsAre("out    5 -> group 7  Request      " + i +
                            "     8 octets    1 frame   interface key " + key + ", operation 0"));
    EXPECT_THAT(server_lines,
                ElementsAre("in     5 -> group 7  Request      " + i +
                            "     8 octets    1 frame   interface key " + key + ", operation 0"));
}

TEST_F(Tracing, AOnewayCallIsKnownAsSuchWhereItIsMade) {
    const OperationInfo note{&lamp_interface, 4, "note", true, true};
    call_through(at(client, 3, 1), note);
    run();
    const std::string i = id(0);
    EXPECT_THAT(client_lines,
                ElementsAre("out    5 -> 3        Request      " + i +
                            "     8 octets    1 frame   object 1, operation 4, oneway"));
    EXPECT_THAT(server_lines,
                ElementsAre("in     5 -> 3        Request      " + i +
                            "     8 octets    1 frame   object 1, operation 4, IDL:Test/Lamp:1.0"));
}

TEST_F(Tracing, Exceptions) {
    EXPECT_THROW(at(client, 3, 1).invoke(2, {}), UNKNOWN);
    EXPECT_THROW(at(client, 3, 1).invoke(3, {}), NO_PERMISSION);
    EXPECT_THROW(at(client, 3, 9).invoke(0, {}), OBJECT_NOT_EXIST);
    run();
    ASSERT_THAT(client_lines, SizeIs(6));
    // 6 + 1 + 20 octets.
    EXPECT_THAT(client_lines[1],
                EndsWith("    27 octets    4 frames  USER_EXCEPTION IDL:Test/Broken:1.0"));
    // 6 + 1 + 36, a minor of two octets, and the completion.
    EXPECT_THAT(
        client_lines[3],
        EndsWith("    46 octets    7 frames  SYSTEM_EXCEPTION NO_PERMISSION NO, minor 200"));
    EXPECT_THAT(
        client_lines[5],
        EndsWith("    48 octets    7 frames  SYSTEM_EXCEPTION OBJECT_NOT_EXIST NO, minor 16"));
    // Nothing is active there, so nobody knows the interface.
    EXPECT_THAT(server_lines[4], EndsWith("  object 9, operation 0"));
}

TEST_F(Tracing, MalformedMessagesAndMessageErrors) {
    // Node 4 is a stranger that speaks version 2.
    const auto stranger = bus.attach("stranger");
    ASSERT_TRUE(stranger->set_filters({}));
    ASSERT_TRUE(std::holds_alternative<can::TransmitHandle>(
        stranger->send(can::Frame::standard(0x464, octets("20 0005 1234 1801 02")))));
    run();
    EXPECT_THAT(server_lines,
                ElementsAre("in     4 -> 3        malformed             8 octets    1 frame",
                            "out    3 -> 4        MessageError          3 octets    1 frame"));
    server_lines.clear();
    ASSERT_TRUE(std::holds_alternative<can::TransmitHandle>(
        stranger->send(can::Frame::standard(0x464, octets("12 0000")))));
    run();
    EXPECT_THAT(server_lines,
                ElementsAre("in     4 -> 3        MessageError          3 octets    1 frame"));
}

TEST_F(Tracing, CallsWithinTheNodeAreMarked) {
    const TimePoint before = simulation.now();
    std::vector<MessageTrace> traces;
    server.on_message([&](const MessageTrace& trace) { traces.push_back(trace); });
    const std::vector<std::uint8_t> octets(2);
    at(server, 3, 1).invoke(1, octets);
    EXPECT_THROW(at(server, 3, 9).invoke(0, {}), OBJECT_NOT_EXIST);
    const OperationInfo note{&lamp_interface, 4, "note", true, true};
    call_through(at(server, 3, 1), note);
    run();
    EXPECT_THAT(seen, IsEmpty());
    Lines lines;
    for (const MessageTrace& trace : traces) {
        EXPECT_EQ(trace.time, before);
        lines.push_back(to_string(trace).substr(time_width));
    }
    EXPECT_THAT(
        lines,
        ElementsAre("local  3 -> 3        Request              10 octets              object 1, "
                    "operation 1, IDL:Test/Lamp:1.0",
                    "local  3 -> 3        Reply                 8 octets              NO_EXCEPTION",
                    "local  3 -> 3        Request               8 octets              object 9, "
                    "operation 0",
                    "local  3 -> 3        Reply                48 octets              "
                    "SYSTEM_EXCEPTION OBJECT_NOT_EXIST NO, minor 16",
                    "local  3 -> 3        Request               8 octets              object 1, "
                    "operation 4, oneway, IDL:Test/Lamp:1.0"));
}

TEST_F(Tracing, WhatWasNotSentSaysSo) {
    OrbOptions options = node(9);
    Simulation alone;
    SimulatedBus& empty = alone.add_bus();
    Orb lonely{empty, options};
    Lines lines;
    lonely.on_message(into(lines));
    // With nobody to acknowledge, two frames stay in the controller for ever.
    for (int n = 0; n < 3; ++n) {
        call_through(at(lonely, 3, 1).with_timeout(10ms), ring_oneway);
    }
    alone.run_for(5ms);
    EXPECT_THAT(lines, IsEmpty());
    alone.run_for(10ms);
    ASSERT_THAT(lines, SizeIs(1));
    EXPECT_THAT(lines[0], EndsWith("object 1, operation 0, oneway, NOT SENT: its deadline passed"));
}

TEST_F(Tracing, WhatIsAboveTheLimitIsRefused) {
    OrbOptions options = node(9);
    options.max_message = 10;
    Orb small{bus, options};
    Lines lines;
    small.on_message(into(lines));
    const std::vector<std::uint8_t> octets(3);
    EXPECT_THROW(at(client, 9, 1).invoke(1, octets), IMP_LIMIT);
    run();
    ASSERT_THAT(lines, SizeIs(2));
    EXPECT_EQ(lines[0], "in     5 -> 9        Request      " + id(0) +
                            "    11 octets    2 frames  object 1, operation 1, "
                            "REFUSED: above max_message");
}

TEST_F(Tracing, OffItRecordsNothing) {
    client.on_message({});
    at(client, 3, 1).invoke(0, {});
    run();
    client.on_message(into(client_lines));  // what was before is not told now
    run();
    EXPECT_THAT(client_lines, IsEmpty());
    EXPECT_THAT(server_lines, SizeIs(2));
    at(client, 3, 1).invoke(0, {});
    run();
    EXPECT_THAT(client_lines, SizeIs(2));
    EXPECT_THAT(log, IsEmpty());  // nobody asked for lines there
}

TEST_F(Tracing, ByOptionLinesGoToTheLog) {
    OrbOptions options = node(9);
    options.trace = true;
    {
        Orb traced{bus, options};
        at(traced, 3, 1).invoke(0, {});
        // The end of the call was not yet told; it comes before the Orb is gone.
    }
    const std::string i = id(0);
    ASSERT_THAT(log, SizeIs(2));
    EXPECT_THAT(log[0], StartsWith("node-9:         0.000"));
    EXPECT_THAT(log[0], EndsWith(" out    9 -> 3        Request      " + i +
                                 "     8 octets    1 frame   object 1, operation 0"));
    EXPECT_THAT(log[1], EndsWith(" in     3 -> 9        Reply        " + i +
                                 "     6 octets    1 frame   NO_EXCEPTION"));
}

TEST_F(Tracing, ByEnvironmentLinesGoToTheLog) {
    ::setenv("CANORB_TRACE", "1", 1);
    Orb traced{bus, node(9)};
    ::setenv("CANORB_TRACE", "0", 1);
    const Orb other{bus, node(10)};
    ::unsetenv("CANORB_TRACE");
    EXPECT_TRUE(traced.options().trace);
    EXPECT_FALSE(other.options().trace);
    Lines lines;
    traced.on_message(into(lines));
    at(traced, 3, 1).invoke(0, {});
    run();
    EXPECT_THAT(lines, SizeIs(2));
    EXPECT_THAT(log, SizeIs(2));
    traced.on_message({});  // the log goes on without the callback
    at(traced, 3, 1).invoke(0, {});
    run();
    EXPECT_THAT(lines, SizeIs(2));
    EXPECT_THAT(log, SizeIs(4));
}

TEST_F(Tracing, ACallbackThatThrowsIsAnEventAndHarmsNobody) {
    client.on_message([](const MessageTrace&) { throw std::runtime_error{"a bug"}; });
    at(client, 3, 1).invoke(0, {});
    run();
    EXPECT_THAT(log, ElementsAre("node-5: the on_message callback raised a bug",
                                 "node-5: the on_message callback raised a bug"));
    at(client, 3, 1).invoke(0, {});
}

TEST_F(Tracing, ACallbackMayCallTheOrb) {
    int calls = 0;
    client.on_message([&](const MessageTrace& trace) {
        client_lines.push_back(to_string(trace).substr(time_width));
        if (calls++ == 0) at(client, 3, 1).invoke(1, {});
    });
    at(client, 3, 1).invoke(0, {});
    run();
    EXPECT_EQ(servant.calls, 2);
    // Its own messages are told, too.
    EXPECT_THAT(client_lines, SizeIs(4));
    EXPECT_EQ(calls, 4);
}

TEST_F(Tracing, ACallbackMayEndItself) {
    int calls = 0;
    client.on_message([&](const MessageTrace&) {
        ++calls;
        client.on_message({});
    });
    at(client, 3, 1).invoke(0, {});
    at(client, 3, 1).invoke(0, {});
    run();
    EXPECT_EQ(calls, 1);
}

}  // namespace
}  // namespace canorb::test
