// Calls from one node to another, and within one: answers, exceptions, deadlines.

#include "tests/runtime/world.hpp"
#include "tests/support/octets.hpp"

namespace canorb::test {
namespace {

constexpr SystemError timeout_no{SystemErrorKind::timeout, Completion::no, 1};
constexpr SystemError timeout_maybe{SystemErrorKind::timeout, Completion::maybe, 2};

struct TestException : UserException {
    static constexpr std::string_view repository_id = "IDL:Test/Broken:1.0";
    std::string_view _repository_id() const noexcept override { return repository_id; }
    std::uint8_t code = 0;
};
void encode(ccdr::Encoder& out, const TestException& value) {
    out.octet(value.code);
}
void decode(ccdr::Decoder& in, TestException& value) {
    value.code = in.octet();
}

/// The same tests on a remote object (true) and on one of the caller's own node (false).
class Calls : public World, public testing::WithParamInterface<bool> {
  protected:
    Calls() {
        servant_orb().root_poa().activate_object_with_id(1, servant);
        target = at(client, GetParam() ? 3 : 5, 1);
    }
    Orb& servant_orb() { return GetParam() ? server : client; }

    Orb server{bus, node(3)};
    Orb client{bus, node(5)};
    TestServant servant{{
        {0, nothing},
        {1, echo},
        {2, [](ServerCall&) { throw NO_PERMISSION{"not you", Completion::yes, 7}; }},
        {3, [](ServerCall&) { throw std::runtime_error{"a bug"}; }},
        {4, [](ServerCall&) { throw 4; }},
        {5,
         [](ServerCall& call) {
             TestException exception;
             exception.code = 9;
             call.raise(exception);
         }},
        {6,
         [this](ServerCall& call) {
             simulation.run_for(30ms);
             call.reply();
         }},
        {7,
         [](ServerCall& call) {
             std::uint8_t value{};
             if (call.read(value)) call.reply(value);
         }},
        {8, [](ServerCall& call) { call.reply(RawOctets{std::vector<std::uint8_t>(70'000)}); }},
        {9, [](ServerCall&) { throw TestException{}; }},
    }};
    ObjectRef target;
};

INSTANTIATE_TEST_SUITE_P(Remote, Calls, testing::Values(true));
INSTANTIATE_TEST_SUITE_P(OwnNode, Calls, testing::Values(false));

TEST_P(Calls, WithoutParametersTakeEightAndSixOctets) {
    EXPECT_TRUE(target.invoke(0, {}).empty());
    EXPECT_EQ(servant.calls, 1);
    if (!GetParam()) {
        EXPECT_TRUE(seen.empty());
        return;
    }
    ASSERT_EQ(seen.size(), 2U);
    EXPECT_EQ(seen[0].frame.id, 0b1'00011'00101U);
    EXPECT_EQ(seen[0].frame.length, 8);
    EXPECT_EQ(seen[1].frame.id, 0b1'00101'00011U);
    EXPECT_EQ(seen[1].frame.length, 6);
    EXPECT_EQ(simulation.now(), seen[1].end);
}

TEST_P(Calls, CarryOctetsBothWays) {
    std::vector<std::uint8_t> octets;
    for (std::size_t i = 0; i < 2000; ++i) octets.push_back(static_cast<std::uint8_t>(i * 7));
    EXPECT_EQ(target.invoke(1, octets), octets);
    EXPECT_EQ(target.invoke(1, {}), std::vector<std::uint8_t>{});
}

TEST_P(Calls, SystemExceptionOfTheServantArrivesAsItself) {
    EXPECT_EQ(error_of([&] { target.invoke(2, {}); }),
              (SystemError{SystemErrorKind::no_permission, Completion::yes, 7}));
    EXPECT_THROW(target.invoke(2, {}), NO_PERMISSION);
    EXPECT_TRUE(log.empty());
}

TEST_P(Calls, AnyOtherExceptionIsUnknownAndAnEvent) {
    std::vector<Event> events;
    servant_orb().on_event([&](const Event& event) { events.push_back(event); });
    constexpr SystemError unknown{SystemErrorKind::unknown, Completion::maybe, 40};
    EXPECT_EQ(error_of([&] { target.invoke(3, {}); }), unknown);
    EXPECT_EQ(error_of([&] { target.invoke(4, {}); }), unknown);
    EXPECT_EQ(error_of([&] { target.invoke(9, {}); }), unknown);
    simulation.run_for(1ms);
    ASSERT_EQ(events.size(), 3U);
    EXPECT_EQ(events[0].kind, Event::Kind::servant_exception);
    EXPECT_THAT(events[0].text, testing::EndsWith(": operation 3 of object 1 raised a bug"));
    EXPECT_THAT(events[1].text, testing::HasSubstr("operation 4 of object 1"));
    EXPECT_THAT(events[2].text, testing::EndsWith("raised IDL:Test/Broken:1.0"));
    EXPECT_EQ(log.size(), 3U);
    target.invoke(0, {});  // the ORB lives
}

TEST_P(Calls, DeclaredExceptionArrivesWithItsMembers) {
    const OperationInfo operation{&lamp_interface, 5, "break_down"};
    ClientCall call{target, operation};
    call.write();
    try {
        call.invoke<TestException>();
        FAIL();
    } catch (const TestException& exception) {
        EXPECT_EQ(exception.code, 9);
    }
    // Not declared by this stub.
    const std::string text = what<UNKNOWN>([&] { target.invoke(5, {}); });
    EXPECT_THAT(text, testing::EndsWith("raised IDL:Test/Broken:1.0"));
    EXPECT_THAT(text, testing::StartsWith("UNKNOWN (completed MAYBE, minor 41): a user exception "
                                          "that the caller does not know: invoke on "));
}

TEST_P(Calls, WithoutGeneratedCodeTellUserExceptionsFromResults) {
    const std::vector<std::uint8_t> two{1, 2};
    const OperationInfo echoes{&lamp_interface, 1, "echo"};
    const InvokeResult answer = target.invoke(echoes, two);
    EXPECT_EQ(answer.exception_id, "");
    EXPECT_EQ(answer.body, two);

    const OperationInfo breaks{&lamp_interface, 5, "break_down"};
    const InvokeResult raised = target.invoke(breaks, {});
    EXPECT_EQ(raised.exception_id, "IDL:Test/Broken:1.0");
    EXPECT_EQ(raised.body, std::vector<std::uint8_t>{9});

    const OperationInfo refuses{&lamp_interface, 2, "refuse"};
    EXPECT_EQ(error_of([&] { target.invoke(refuses, {}); }),
              (SystemError{SystemErrorKind::no_permission, Completion::yes, 7}));

    const int before = servant.calls;
    EXPECT_EQ(target.invoke(ring_oneway, {}).body, std::vector<std::uint8_t>{});
    EXPECT_EQ(servant.calls, before);
    simulation.run_for(1ms);
    EXPECT_EQ(servant.calls, before + 1);
}

TEST_P(Calls, UnknownOperationIsBadOperation) {
    constexpr SystemError bad_operation{SystemErrorKind::bad_operation, Completion::no, 18};
    EXPECT_EQ(error_of([&] { target.invoke(200, {}); }), bad_operation);
    EXPECT_EQ(error_of([&] { target.invoke(0xF8, {}); }), bad_operation);
    EXPECT_EQ(error_of([&] { target.invoke(0xFC, {}); }), bad_operation);
}

TEST_P(Calls, UnknownObjectIsObjectNotExist) {
    constexpr SystemError not_exist{SystemErrorKind::object_not_exist, Completion::no, 16};
    const ObjectRef nobody = at(client, GetParam() ? 3 : 5, 2);
    EXPECT_EQ(error_of([&] { nobody.invoke(0, {}); }), not_exist);
    servant_orb().root_poa().deactivate_object(1);
    EXPECT_EQ(error_of([&] { target.invoke(0, {}); }), not_exist);
    EXPECT_EQ(servant.calls, 0);
    EXPECT_EQ(servant_orb().counters()[Counter::requests_refused], 2U);
}

TEST_P(Calls, ParametersThatDoNotDecodeAreMarshal) {
    constexpr SystemError marshal{SystemErrorKind::marshal, Completion::no, 20};
    const std::vector<std::uint8_t> two{1, 2};
    EXPECT_EQ(error_of([&] { target.invoke(7, {}); }), marshal);
    EXPECT_EQ(error_of([&] { target.invoke(7, two); }), marshal);
    EXPECT_EQ(target.invoke(7, Bytes{two}.first(1)), std::vector<std::uint8_t>{1});
}

TEST_P(Calls, ReplyThatDoesNotDecodeIsMarshalYes) {
    const std::vector<std::uint8_t> boolean{2};
    const OperationInfo operation{&lamp_interface, 1, "is_on"};
    ClientCall call{target, operation};
    call.write(RawOctets{boolean});
    call.invoke();
    bool result{};
    EXPECT_EQ(error_of([&] { call.read(result); }),
              (SystemError{SystemErrorKind::marshal, Completion::yes, 21}));
}

TEST_P(Calls, ReplyLongerThanAMessageIsImpLimit) {
    EXPECT_EQ(error_of([&] { target.invoke(8, {}); }),
              (SystemError{SystemErrorKind::imp_limit, Completion::yes, 33}));
}

TEST_P(Calls, ParametersLongerThanAMessageAreImpLimit) {
    const std::vector<std::uint8_t> octets(65538 - 8 + 1);
    EXPECT_EQ(error_of([&] { target.invoke(1, octets); }),
              (SystemError{SystemErrorKind::imp_limit, Completion::no, 30}));
}

TEST_P(Calls, LateReplyIsDropped) {
    const TimePoint start = simulation.now();
    EXPECT_EQ(error_of([&] { target.with_timeout(20ms).invoke(6, {}); }), timeout_maybe);
    EXPECT_EQ(client.counters()[Counter::calls_timed_out], 1U);
    // In a simulation the servant is on the caller's stack, and ends first.
    EXPECT_GE(simulation.now() - start, 30ms);
    EXPECT_LT(simulation.now() - start, 31ms);
    simulation.run_for(20ms);
    EXPECT_EQ(client.counters()[Counter::unmatched_replies], 1U);
    target.invoke(0, {});
}

TEST_P(Calls, OnewayReturnsBeforeItIsServed) {
    call_through(target, ring_oneway);
    EXPECT_EQ(servant.calls, 0);
    simulation.run_for(1ms);
    EXPECT_EQ(servant.calls, 1);
}

TEST_P(Calls, OrbAnswersItsOwnOperations) {
    EXPECT_TRUE(target._is_a("IDL:Test/Lamp:1.0"));
    EXPECT_TRUE(target._is_a("IDL:Test/Device:1.0"));
    EXPECT_TRUE(target._is_a("IDL:omg.org/CORBA/Object:1.0"));
    EXPECT_FALSE(target._is_a("IDL:Test/Horn:1.0"));
    EXPECT_EQ(target._interface_id(), "IDL:Test/Lamp:1.0");
    EXPECT_FALSE(target._non_existent());
    servant_orb().root_poa().deactivate_object(1);
    EXPECT_TRUE(target._non_existent());
}

class Deadlines : public World {};

TEST_F(Deadlines, NobodyAnswersMaybe) {
    Orb other{bus, node(1)};  // acknowledges
    OrbOptions options = node(2);
    options.default_timeout = 70ms;
    Orb orb{bus, options};
    const ObjectRef nobody = at(orb, 9, 1);
    TimePoint start = simulation.now();
    EXPECT_EQ(error_of([&] { nobody.invoke(0, {}); }), timeout_maybe);
    EXPECT_EQ(simulation.now() - start, 70ms);
    start = simulation.now();
    EXPECT_EQ(error_of([&] { nobody.with_timeout(20ms).invoke(0, {}); }), timeout_maybe);
    EXPECT_EQ(simulation.now() - start, 20ms);
    EXPECT_THROW(nobody.with_timeout(0ms), BAD_PARAM);
    EXPECT_THROW(nobody.with_timeout(-1ms), BAD_PARAM);
}

TEST_F(Deadlines, OfAnyLengthCanBeComputedWith) {
    Orb server{bus, node(1)};
    TestServant servant{{{0, nothing}}};
    server.root_poa().activate_object_with_id(1, servant);
    OrbOptions options = node(2);
    options.default_timeout = Duration::max();
    Orb orb{bus, options};
    at(orb, 1, 1).invoke(0, {});
    at(orb, 1, 1).with_timeout(Duration::max()).invoke(0, {});
    orb.every(Duration::max(), [] { FAIL(); });
    simulation.run_for(1h);
    EXPECT_EQ(servant.calls, 2);
}

// Alone on the bus nothing is acknowledged: what the controller has stays there.
TEST_F(Deadlines, MessageNotBegunIsWithdrawnNo) {
    Orb orb{bus, node(2)};
    bool sent = false;
    const auto note = [&] { sent = true; };
    call_through(group(orb, 1), ring);
    call_through(group(orb, 1), ring);  // both frames that the controller may have
    const TimePoint start = simulation.now();
    EXPECT_EQ(error_of([&] { at(orb, 9, 1).with_sent(note).with_timeout(20ms).invoke(0, {}); }),
              timeout_no);
    EXPECT_EQ(simulation.now() - start, 20ms);
    call_through(group(orb, 7).with_sent(note).with_timeout(20ms), ring);
    simulation.run_for(1s);
    EXPECT_EQ(orb.counters()[Counter::messages_expired], 2U);
    // Somebody comes: only what the controller had goes out.
    Orb other{bus, node(1)};
    simulation.run_for(1s);
    EXPECT_EQ(seen.size(), 2U);
    EXPECT_FALSE(sent);
}

TEST_F(Deadlines, FullQueueIsNoResourcesAtOnce) {
    OrbOptions options = node(2);
    options.max_queued_messages = 4;
    Orb orb{bus, options};
    for (int i = 0; i < 4; ++i) call_through(group(orb, 1), ring);
    bool sent = false;
    const auto note = [&] { sent = true; };
    constexpr SystemError no_resources{SystemErrorKind::no_resources, Completion::no, 10};
    EXPECT_EQ(error_of([&] { call_through(group(orb, 1).with_sent(note), ring); }), no_resources);
    EXPECT_EQ(error_of([&] { at(orb, 1, 1).with_sent(note).invoke(0, {}); }), no_resources);
    EXPECT_EQ(simulation.now(), TimePoint{});
    Orb other{bus, node(1)};
    simulation.run_for(2s);
    EXPECT_FALSE(sent);
    call_through(group(orb, 1), ring);  // there is room again
}

TEST_F(Deadlines, UrgentMessageWaitsForTwoFramesAtMost) {
    Orb other{bus, node(1)};
    Orb orb{bus, node(2)};
    const std::vector<std::uint8_t> octets(100);
    for (int i = 0; i < 5; ++i) call_through(at(orb, 1, 1), ring_oneway, octets);
    call_through(group(orb, 3), ring);
    simulation.run_for(100ms);
    ASSERT_GT(seen.size(), 70U);
    const auto group_frame = std::find_if(
        seen.begin(), seen.end(), [](const Seen& frame) { return (frame.frame.id & 0x400) == 0; });
    EXPECT_LE(group_frame - seen.begin(), 2);
}

TEST_F(Deadlines, ReceiverRefusesWhatIsAboveItsLimit) {
    OrbOptions options = node(1);
    options.max_message = 100;
    Orb server{bus, options};
    TestServant servant{{{1, echo}}};
    server.root_poa().activate_object_with_id(1, servant);
    OrbOptions small = node(2);
    small.max_message = 50;
    Orb client{bus, small};
    const std::vector<std::uint8_t> octets(93);
    // The Request is above the server's limit, then the Reply above the client's.
    EXPECT_EQ(error_of([&] { at(client, 1, 1).invoke(1, octets); }),
              (SystemError{SystemErrorKind::imp_limit, Completion::no, 31}));
    EXPECT_EQ(error_of([&] { at(client, 1, 1).invoke(1, Bytes{octets}.first(92)); }),
              (SystemError{SystemErrorKind::imp_limit, Completion::yes, 32}));
    EXPECT_EQ(servant.calls, 1);
    EXPECT_EQ(at(client, 1, 1).invoke(1, Bytes{octets}.first(44)).size(), 44U);
}

TEST_F(Deadlines, NodeWithoutANumberCallsNobody) {
    Orb server{bus, node(1)};
    TestServant servant{{{0, nothing}}};
    server.root_poa().activate_object_with_id(1, servant);
    Orb orb{bus, node(std::nullopt)};
    EXPECT_FALSE(orb.node());
    EXPECT_THAT(what<BAD_INV_ORDER>([&] { at(orb, 1, 1).invoke(0, {}); }),
                testing::HasSubstr("set_node() first"));
    EXPECT_THROW(call_through(group(orb, 1), ring), BAD_INV_ORDER);
    EXPECT_THROW(orb.root_poa().activate_object(servant), BAD_INV_ORDER);
    EXPECT_THAT(what<BAD_PARAM>([&] { orb.set_node(31); }), testing::HasSubstr("node 31"));
    orb.set_node(4);
    EXPECT_EQ(orb.node(), NodeId{4});
    at(orb, 1, 1).invoke(0, {});
    EXPECT_EQ(servant.calls, 1);
}

}  // namespace
}  // namespace canorb::test
