// One Request in, one answer out: what a skeleton, and the ORB in its place, make of it.

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "orb/poa/servant.hpp"
#include "tests/support/octets.hpp"

namespace canorb::poa {
namespace {

using canorb::test::hex;
using canorb::test::octets;
using Outcome = ServerCall::Outcome;

constexpr InterfaceInfo device_interface{"IDL:T/D:1.0"};
constexpr const InterfaceInfo* motor_bases[] = {&device_interface};
constexpr InterfaceInfo motor_interface{"IDL:T/M:1.0", motor_bases};

/// IDL: exception Stalled { unsigned short code; string where; };
struct Stalled {
    static constexpr std::string_view repository_id = "IDL:T/S:1.0";
    std::uint16_t code;
    std::string where;
};
void encode(ccdr::Encoder& out, const Stalled& value) {
    ccdr::encode(out, value.code);
    ccdr::encode(out, std::string_view{value.where});
}

class Motor final : public Servant {
  public:
    explicit Motor(std::function<void(ServerCall&)> skeleton) : skeleton_(std::move(skeleton)) {}
    const InterfaceInfo& _interface_info() const override { return motor_interface; }
    void _dispatch(ServerCall& call) override {
        ++dispatched;
        skeleton_(call);
    }
    int dispatched = 0;

  private:
    std::function<void(ServerCall&)> skeleton_;
};

/// What a call came to, as text: "NO_EXCEPTION 2A", "BAD_OPERATION NO 18", "nothing".
std::string describe(const ServerCall& call) {
    switch (call.outcome()) {
        case Outcome::none:
            return "nothing";
        case Outcome::no_exception:
            return "NO_EXCEPTION " + hex(call.body());
        case Outcome::user_exception:
            return "USER_EXCEPTION " + hex(call.body());
        case Outcome::system_exception:
            break;
    }
    EXPECT_TRUE(call.body().empty());
    const SystemError& error = call.system_error();
    return std::string{name(error.kind)} + " " + std::string{name(error.completion)} + " " +
           std::to_string(error.minor);
}

struct Call {
    OperationId operation = 3;
    std::string parameters = "";
    bool to_group = false;
    std::size_t room = 64;
};

std::string dispatched(Motor& motor, const Call& setup) {
    const auto parameters = octets(setup.parameters);
    std::array<std::uint8_t, 64> reply{};
    ServerCall call{setup.operation, ccdr::Decoder{parameters},
                    MutableBytes{reply}.first(setup.room)};
    if (setup.to_group) call.oneway();
    dispatch(motor, call);
    return describe(call);
}

std::string dispatched(const std::function<void(ServerCall&)>& skeleton, const Call& setup) {
    Motor motor{skeleton};
    return dispatched(motor, setup);
}

/// IDL: unsigned long sum(in unsigned short a, in unsigned short b);
void sum(ServerCall& call) {
    std::uint16_t a{};
    std::uint16_t b{};
    if (!call.read(a, b)) return;
    call.reply(static_cast<std::uint32_t>(a) + b);
}

TEST(ServerCall, ReadsAllParametersAndReplies) {
    EXPECT_EQ(dispatched(sum, {.parameters = "01 02"}), "NO_EXCEPTION 03");
    EXPECT_EQ(dispatched(sum, {.parameters = "7F 01"}), "NO_EXCEPTION 8080");
    EXPECT_EQ(dispatched(sum, {.parameters = "C0FFFF C0FFFF"}), "NO_EXCEPTION C1FFFE");
}

TEST(ServerCall, ParametersThatDoNotDecodeAreMarshal) {
    EXPECT_EQ(dispatched(sum, {.parameters = ""}), "MARSHAL NO 20");
    EXPECT_EQ(dispatched(sum, {.parameters = "01"}), "MARSHAL NO 20");
    EXPECT_EQ(dispatched(sum, {.parameters = "01 8001"}), "MARSHAL NO 20");    // not the shortest
    EXPECT_EQ(dispatched(sum, {.parameters = "01 C10000"}), "MARSHAL NO 20");  // above 65535
    EXPECT_EQ(dispatched(sum, {.parameters = "01 02 00"}), "MARSHAL NO 20");   // left over
    const auto nothing = [](ServerCall& call) {
        if (call.read()) call.reply();
    };
    EXPECT_EQ(dispatched(nothing, {.parameters = ""}), "NO_EXCEPTION ");
    EXPECT_EQ(dispatched(nothing, {.parameters = "00"}), "MARSHAL NO 20");
}

TEST(ServerCall, RepliesWithTheReturnValueThenTheOutParameters) {
    const auto skeleton = [](ServerCall& call) {
        std::uint16_t inout{};
        if (!call.read(inout)) return;
        call.reply(true, inout, std::string_view{"A"});
    };
    EXPECT_EQ(dispatched(skeleton, {.parameters = "80EA"}), "NO_EXCEPTION 0180EA024100");
}

TEST(ServerCall, AReplyTooLongForTheBufferIsImpLimit) {
    const auto skeleton = [](ServerCall& call) {
        if (call.read()) call.reply(std::string_view{"ABC"});
    };
    EXPECT_EQ(dispatched(skeleton, {.room = 5}), "NO_EXCEPTION 0441424300");
    EXPECT_EQ(dispatched(skeleton, {.room = 4}), "IMP_LIMIT YES 33");
    EXPECT_EQ(dispatched(skeleton, {.room = 0}), "IMP_LIMIT YES 33");
}

TEST(ServerCall, AResultThatIsNoValueOfItsTypeIsBadParam) {
    const auto skeleton = [](ServerCall& call) {
        if (call.read()) call.reply(std::string_view{"A\0B", 3});
    };
    EXPECT_EQ(dispatched(skeleton, {}), "BAD_PARAM YES 23");
}

TEST(ServerCall, RaisesAUserExceptionWithItsIdAndMembers) {
    const auto skeleton = [](ServerCall& call) {
        if (call.read()) call.raise(Stalled{234, "x"});
    };
    // "IDL:T/S:1.0", 234, "x"
    EXPECT_EQ(dispatched(skeleton, {}), "USER_EXCEPTION 0C49444C3A542F533A312E300080EA027800");
    EXPECT_EQ(dispatched(skeleton, {.room = 17}), "IMP_LIMIT YES 33");
}

TEST(ServerCall, TheLastAnswerCounts) {
    // A C++ exception after the reply: what is sent must not be half of each.
    const auto skeleton = [](ServerCall& call) {
        if (!call.read()) return;
        call.reply(std::string_view{"ABC"});
        call.fail({SystemErrorKind::unknown, Completion::maybe});
    };
    EXPECT_EQ(dispatched(skeleton, {}), "UNKNOWN MAYBE 0");
    const auto other_way = [](ServerCall& call) {
        call.fail({SystemErrorKind::unknown, Completion::maybe});
        call.reply(std::uint8_t{7});
    };
    EXPECT_EQ(dispatched(other_way, {}), "NO_EXCEPTION 07");
}

TEST(ServerCall, GivesItsParametersAsOctets) {
    const auto echo = [](ServerCall& call) { call.reply(RawOctets{call.remaining_parameters()}); };
    EXPECT_EQ(dispatched(echo, {.parameters = "0102FF"}), "NO_EXCEPTION 0102FF");
    EXPECT_EQ(dispatched(echo, {.parameters = ""}), "NO_EXCEPTION ");
}

TEST(Dispatch, AnswersIsAItself) {
    Motor motor{[](ServerCall&) {}};
    // "IDL:T/M:1.0", "IDL:T/D:1.0", "IDL:T/X:1.0", each 11 octets and the NUL.
    EXPECT_EQ(dispatched(motor, {0xFF, "0C 49444C3A542F4D3A312E30 00"}), "NO_EXCEPTION 01");
    EXPECT_EQ(dispatched(motor, {0xFF, "0C 49444C3A542F443A312E30 00"}), "NO_EXCEPTION 01");
    EXPECT_EQ(dispatched(motor, {0xFF, "0C 49444C3A542F583A312E30 00"}), "NO_EXCEPTION 00");
    // "IDL:omg.org/CORBA/Object:1.0": 28 octets and the NUL.
    EXPECT_EQ(
        dispatched(motor, {0xFF, "1D 49444C3A6F6D672E6F72672F434F5242412F4F626A6563743A312E30 00"}),
        "NO_EXCEPTION 01");
    EXPECT_EQ(dispatched(motor, {0xFF, "0100"}), "NO_EXCEPTION 00");
    EXPECT_EQ(dispatched(motor, {0xFF, ""}), "MARSHAL NO 20");
    EXPECT_EQ(dispatched(motor, {0xFF, "0100 00"}), "MARSHAL NO 20");
    EXPECT_EQ(motor.dispatched, 0);
}

TEST(Dispatch, AnswersNonExistentAndInterfaceItself) {
    Motor motor{[](ServerCall&) {}};
    EXPECT_EQ(dispatched(motor, {0xFE, ""}), "NO_EXCEPTION 00");
    EXPECT_EQ(dispatched(motor, {0xFE, "00"}), "MARSHAL NO 20");
    EXPECT_EQ(dispatched(motor, {0xFD, ""}), "NO_EXCEPTION 0C49444C3A542F4D3A312E3000");
    EXPECT_EQ(dispatched(motor, {0xFD, "00"}), "MARSHAL NO 20");
    EXPECT_EQ(motor.dispatched, 0);
}

TEST(Dispatch, TheOrbsOtherOperationsAreBadOperationWhateverTheServantWouldDo) {
    Motor motor{[](ServerCall& call) { call.reply(); }};
    for (const OperationId operation :
         std::initializer_list<OperationId>{0xF8, 0xF9, 0xFA, 0xFB, 0xFC}) {
        EXPECT_EQ(dispatched(motor, {operation, ""}), "BAD_OPERATION NO 18") << int{operation};
    }
    EXPECT_EQ(motor.dispatched, 0);
    EXPECT_EQ(dispatched(motor, {0xF7, ""}), "NO_EXCEPTION ");
    EXPECT_EQ(dispatched(motor, {0x00, ""}), "NO_EXCEPTION ");
    EXPECT_EQ(motor.dispatched, 2);
}

TEST(Dispatch, WhatTheServantDoesNotAnswerIsBadOperation) {
    const auto unhandled = [](ServerCall&) {};
    EXPECT_EQ(dispatched(unhandled, {.parameters = ""}), "BAD_OPERATION NO 18");
    EXPECT_EQ(dispatched(unhandled, {.parameters = "01"}), "BAD_OPERATION NO 18");
    // One that reads and then forgets to answer, too: the caller must not wait.
    const auto forgetful = [](ServerCall& call) { EXPECT_TRUE(call.read()); };
    EXPECT_EQ(dispatched(forgetful, {}), "BAD_OPERATION NO 18");
}

TEST(Dispatch, AOnewayOperationNeedsNoAnswer) {
    const auto oneway = [](ServerCall& call) {
        call.oneway();
        std::uint8_t value{};
        if (!call.read(value)) return;
    };
    EXPECT_EQ(dispatched(oneway, {.parameters = "01"}), "nothing");
    EXPECT_EQ(dispatched(oneway, {.parameters = "01", .to_group = true}), "nothing");
    // Its faults are known all the same, to be counted.
    EXPECT_EQ(dispatched(oneway, {.parameters = ""}), "MARSHAL NO 20");
    const auto parameterless = [](ServerCall& call) { call.oneway(); };
    EXPECT_EQ(dispatched(parameterless, {}), "nothing");
}

TEST(Dispatch, AGroupsUnknownOperationIsBadOperationToo) {
    EXPECT_EQ(dispatched([](ServerCall&) {}, {.to_group = true}), "BAD_OPERATION NO 18");
    EXPECT_EQ(dispatched(sum, {.operation = 0xF8, .to_group = true}), "BAD_OPERATION NO 18");
    EXPECT_EQ(dispatched(sum, {.parameters = "01 02", .to_group = true}), "NO_EXCEPTION 03");
}

}  // namespace
}  // namespace canorb::poa
