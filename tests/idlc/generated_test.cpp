// What the golden files do when they run: types to octets and back, skeletons, stubs.

#include <canorb/orb.hpp>
#include <canorb/simulation.hpp>

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "devices.hpp"
#include "includes.hpp"
#include "interfaces.hpp"
#include "tests/support/octets.hpp"
#include "types.hpp"

namespace canorb::test {
namespace {

using ccdr::EncodeError;

template <typename T>
std::string encoded(const T& value) {
    std::array<std::uint8_t, 8192> buffer{};
    ccdr::Encoder out{buffer};
    encode(out, value);
    if (out.error() == EncodeError::bad_value) return "bad value";
    return hex(out.octets());
}

template <typename T>
bool decoded(std::string_view text, T& value) {
    const std::vector<std::uint8_t> in_octets = octets(text);
    ccdr::Decoder in{in_octets};
    decode(in, value);
    return in.finished();
}

TEST(GeneratedTypesTest, AScalarOfEachKind) {
    Types::Scalars scalars;
    scalars.b = true;
    scalars.c = 'A';
    scalars.o = 1;
    scalars.i8 = -1;
    scalars.u8 = 2;
    scalars.s = -1;
    scalars.i16 = 63;
    scalars.us = 127;
    scalars.u16 = 128;
    scalars.l = -64;
    scalars.i32 = 64;
    scalars.ul = 118;
    scalars.u32 = 234;
    scalars.ll = 1;
    scalars.i64 = -1;
    scalars.ull = 2;
    scalars.u64 = 3;
    scalars.f = 1.0F;
    scalars.d = -2.0;
    scalars.shade = Types::Colour::BLUE;
    const std::string golden =
        "01"
        "41"
        "01"
        "FF"
        "02"
        "7F"
        "3F"
        "7F"
        "8080"
        "40"
        "8040"
        "76"
        "80EA"
        "0000000000000001"
        "FFFFFFFFFFFFFFFF"
        "0000000000000002"
        "0000000000000003"
        "3F800000"
        "C000000000000000"
        "02";
    EXPECT_EQ(encoded(scalars), golden);
    Types::Scalars back;
    EXPECT_TRUE(decoded(golden, back));
    EXPECT_EQ(back, scalars);
}

TEST(GeneratedTypesTest, EverythingComesBack) {
    Types::Compounds value;
    value.words = "text";
    value.fits = std::string(255, 'f');
    value.does_not = std::string(256, 'n');
    value.called = "name";
    value.long_text = "long";
    value.octets = {1, 2, 3};
    value.few_octets = {4, 5};
    value.many_octets = std::vector<std::uint8_t>(257, 7);
    value.few_colours = {Types::Colour::GREEN, Types::Colour::RED};
    value.texts = {"a", "", "c"};
    value.long_texts = {std::string(300, 'x')};
    value.names = {"p", "q"};
    value.measured = {300, 2};
    value.list.resize(2);
    value.cells[1][3] = -5;
    value.texts_in_array = {"one", "two"};
    value.second[2].l = 9;
    value.sent = {{1}, {2, 3}};
    value.flags = {true, false, true};
    const std::string golden = encoded(value);
    Types::Compounds back;
    ASSERT_TRUE(decoded(golden, back));
    EXPECT_EQ(back, value);
}

TEST(GeneratedTypesTest, BoundsHoldOnBothSides) {
    Types::Compounds value;
    value.does_not = std::string(257, 'n');
    EXPECT_EQ(encoded(value), "bad value");
    value = {};
    value.fits = std::string(256, 'n');
    EXPECT_EQ(encoded(value), "bad value");
    value = {};
    value.many_octets.resize(258);
    EXPECT_EQ(encoded(value), "bad value");
    value = {};
    value.long_texts = {std::string(301, 'x')};
    EXPECT_EQ(encoded(value), "bad value");
    value = {};
    value.texts.resize(4);
    EXPECT_EQ(encoded(value), "bad value");

    Types::Name name;
    EXPECT_TRUE(decoded("11 30303030303030303030303030303030 00", name));
    EXPECT_FALSE(decoded("12 3030303030303030303030303030303030 00", name));
}

TEST(GeneratedTypesTest, EnumsHaveNoOtherValues) {
    Types::Colour colour{};
    EXPECT_TRUE(decoded("02", colour));
    EXPECT_EQ(colour, Types::Colour::BLUE);
    EXPECT_FALSE(decoded("03", colour));
    EXPECT_EQ(encoded(static_cast<Types::Colour>(3)), "bad value");
}

TEST(GeneratedTypesTest, ExceptionsCarryTheirMembers) {
    const Types::Failed failed{"hot", -1};
    EXPECT_EQ(encoded(failed), "04686F74007F");
    EXPECT_EQ(failed._repository_id(), "IDL:Types/Failed:1.0");
    EXPECT_EQ(encoded(Types::Stopped{}), "");
    Types::Failed back;
    EXPECT_TRUE(decoded("04 686F7400 7F", back));
    EXPECT_EQ(back.reason, "hot");
    EXPECT_EQ(back.code, -1);
}

TEST(GeneratedTypesTest, ConstantsAreConstant) {
    static_assert(Types::max_channels == 8);
    static_assert(Types::inverted == 0xFFFFFFFF);
    static_assert(Types::favourite == Types::Colour::BLUE);
    static_assert(Types::greeting ==
                  "say \"hello\"\x7f"
                  "1");
    static_assert(Plant::Device::limit == 100);
}

class Pump final : public Plant::LoggingPumpServant {
  public:
    using State = Plant::Device::State;
    using Info = Plant::Device::Info;

    State current() override { return state_; }
    Info description() override { throw Plant::Device::Broken{State::ON}; }
    void power(State wanted) override {
        if (wanted == State::OFF) throw Plant::Refused{"no"};
        state_ = wanted;
    }
    void changed(const Plant::Device& which, State state) override {
        heard_nil_ = which.is_nil();
        state_ = state;
    }
    void text(const std::string& message, const std::string&) override { label_ = message; }
    std::string label() override { return label_; }
    void label(const std::string& value) override { label_ = value; }
    std::string get(std::int32_t key, std::vector<std::string>& others,
                    canorb::BoundedString<20>& hint) override {
        others = {"x", std::to_string(key)};
        hint = std::string{hint.view()} + "!";
        return "got";
    }
    canorb::ObjectRef lookup(const std::string&, canorb::ObjectRef&) override { return {}; }
    std::int32_t fill(const Plant::Listeners& listeners) override {
        return static_cast<std::int32_t>(listeners.size());
    }
    State cycle(State from, Info& info) override {
        info.now = from;
        return State::ON;
    }
    Plant::Pump self() override { return {}; }

    State state_ = State::OFF;
    std::string label_;
    bool heard_nil_ = false;
};

/// Dispatches one Request's parameters; the answer as "reply HEX", "raise HEX", ...
std::string dispatched(canorb::Servant& servant, OperationId operation, std::string_view text) {
    std::array<std::uint8_t, 1024> buffer{};
    const std::vector<std::uint8_t> parameters = octets(text);
    canorb::ServerCall call{operation, ccdr::Decoder{parameters}, buffer};
    servant._dispatch(call);
    const std::string oneway = call.is_oneway() ? "oneway " : "";
    switch (call.outcome()) {
        case canorb::ServerCall::Outcome::none:
            return oneway + "none";
        case canorb::ServerCall::Outcome::no_exception:
            return oneway + "reply " + hex(call.body());
        case canorb::ServerCall::Outcome::user_exception:
            return "raise " + hex(call.body());
        case canorb::ServerCall::Outcome::system_exception:
            break;
    }
    return oneway + std::string{name(call.system_error().kind)};
}

TEST(GeneratedServantTest, DispatchesItsOwnOperations) {
    Pump pump;
    EXPECT_EQ(dispatched(pump, 37, ""), "reply 0100FF");  // self: nil
    EXPECT_EQ(dispatched(pump, 37, "00"), "MARSHAL");
    EXPECT_EQ(dispatched(pump, 99, ""), "none");
}

TEST(GeneratedServantTest, DispatchesWhatItInherits) {
    Pump pump;
    EXPECT_EQ(dispatched(pump, 0, ""), "reply 00");
    EXPECT_EQ(dispatched(pump, 2, "01"), "reply ");
    EXPECT_EQ(dispatched(pump, 0, ""), "reply 01");
    EXPECT_EQ(dispatched(pump, 2, "02"), "MARSHAL");
    // cycle(ON, {{}, OFF}): ON, {{}, ON}
    EXPECT_EQ(dispatched(pump, 18, "01 00 00"), "reply 010001");
    // get(5, others, "hi"): "got", others {"x", "5"}, hint "hi!"
    EXPECT_EQ(dispatched(pump, 34, "05 03 686900"),
              "reply 04676F740002027800023500"
              "0468692100");
    EXPECT_EQ(dispatched(pump, 33, "03 616200"), "reply ");
    EXPECT_EQ(pump.label_, "ab");
    EXPECT_EQ(dispatched(pump, 36, "02 0100FF 0100FF"), "reply 02");
}

TEST(GeneratedServantTest, RaisesDeclaredExceptions) {
    Pump pump;
    // "IDL:Plant/Refused:1.0" and its NUL are 22 octets; then "no".
    EXPECT_EQ(dispatched(pump, 2, "00"),
              "raise 16"
              "49444C3A506C616E742F526566757365643A312E3000"
              "036E6F00");
    // "IDL:Plant/Device/Broken:1.0" and its NUL are 28 octets; then ON.
    EXPECT_EQ(dispatched(pump, 1, ""),
              "raise 1C"
              "49444C3A506C616E742F4465766963652F42726F6B656E3A312E3000"
              "01");
}

TEST(GeneratedServantTest, SaysWhatIsOneway) {
    Pump pump;
    EXPECT_EQ(dispatched(pump, 16, "0100FF 01"), "oneway none");
    EXPECT_TRUE(pump.heard_nil_);
    EXPECT_EQ(pump.state_, Plant::Device::State::ON);
    EXPECT_EQ(dispatched(pump, 16, "0100FF 05"), "oneway MARSHAL");
}

TEST(GeneratedServantTest, KnowsItsInterfaces) {
    Pump pump;
    const canorb::InterfaceInfo& info = pump._interface_info();
    EXPECT_EQ(info.repository_id, "IDL:Plant/LoggingPump:1.0");
    for (const char* id : {"IDL:Plant/Pump:1.0", "IDL:Plant/Device:1.0", "IDL:Plant/Listener:1.0",
                           "IDL:Plant/Store:1.0"}) {
        EXPECT_TRUE(info.is_a(id)) << id;
    }
    EXPECT_FALSE(info.is_a("IDL:Plant/Nothing:1.0"));
}

class Motor final : public Devices::MotorServant {
  public:
    std::string model() override { return "M1"; }
    float speed(std::uint16_t channel) override { return static_cast<float>(channel) / 2; }
    void start() override { throw Devices::MotorStartException{"too hot"}; }
    void stop() override { ++stops_; }
    std::uint32_t ramp() override { return ramp_; }
    void ramp(std::uint32_t value) override { ramp_ = value; }
    Devices::State sample(std::int32_t& range, Devices::Samples& samples) override {
        samples = {1, 500};
        range *= 2;
        return Devices::State::RUNNING;
    }
    void follow(const Devices::Motor& leader) override { leader_ = leader; }

    std::uint32_t ramp_ = 7;
    int stops_ = 0;
    Devices::Motor leader_;
};

class GeneratedStubTest : public testing::Test {
  protected:
    canorb::Simulation simulation_;
    canorb::Bus& bus_ = simulation_.add_bus();
    canorb::Orb server_{bus_, {.node = 3}};
    canorb::Orb client_{bus_, {.node = 1}};
    Motor motor_;
    canorb::ObjectRef object_ = server_.root_poa().activate_object_with_id(1, motor_);

    Devices::Motor stub() {
        return client_.string_to_object(server_.object_to_string(object_)).narrow<Devices::Motor>();
    }
};

TEST_F(GeneratedStubTest, CallsEveryKindOfOperation) {
    const Devices::Motor motor = stub();
    ASSERT_FALSE(motor.is_nil());
    EXPECT_EQ(motor.model(), "M1");
    EXPECT_EQ(motor.speed(5), 2.5F);
    motor.ramp(9);
    EXPECT_EQ(motor.ramp(), 9U);
    std::int32_t range = 21;
    Devices::Samples samples;
    EXPECT_EQ(motor.sample(range, samples), Devices::State::RUNNING);
    EXPECT_EQ(range, 42);
    EXPECT_EQ(samples, (Devices::Samples{1, 500}));
    EXPECT_EQ(motor.with_timeout(std::chrono::milliseconds{50}).speed(2), 1.0F);
}

TEST_F(GeneratedStubTest, ThrowsWhatTheServantRaises) {
    try {
        stub().start();
        FAIL() << "nothing was thrown";
    } catch (const Devices::MotorStartException& exception) {
        EXPECT_EQ(exception.reason, "too hot");
    }
}

TEST_F(GeneratedStubTest, SendsOnewayOperations) {
    stub().stop();
    simulation_.run_for(std::chrono::milliseconds{10});
    EXPECT_EQ(motor_.stops_, 1);
}

TEST_F(GeneratedStubTest, PassesReferences) {
    Motor other;
    other.ramp_ = 40;
    const canorb::ObjectRef object = client_.root_poa().activate_object(other);
    stub().follow(object.narrow<Devices::Motor>());
    EXPECT_EQ(motor_.leader_.ramp(), 40U);
}

TEST_F(GeneratedStubTest, SendsToGroupsWhatGroupsCanGet) {
    server_.object_join(object_, canorb::GroupId{5});
    const auto all = client_.string_to_object("corbaloc:caniop:group/5").narrow<Devices::Motor>();
    all.ramp(77);
    simulation_.run_for(std::chrono::milliseconds{10});
    EXPECT_EQ(motor_.ramp_, 77U);
    EXPECT_THROW(static_cast<void>(all.ramp()), canorb::BAD_OPERATION);
    EXPECT_THROW(all.start(), canorb::BAD_OPERATION);
}

/// Answers what the test wants, whatever the IDL says.
class AnyAnswer final : public canorb::Servant {
  public:
    using Operation = std::function<void(canorb::ServerCall&)>;
    explicit AnyAnswer(Operation operation) : operation_(std::move(operation)) {}
    const canorb::InterfaceInfo& _interface_info() const override { return Plant::StoreInterface; }
    void _dispatch(canorb::ServerCall& call) override { operation_(call); }

  private:
    Operation operation_;
};

TEST_F(GeneratedStubTest, AsynchronousCallsOfEveryKindOfOperation) {
    const Devices::Motor motor = stub();
    EXPECT_EQ(motor.sendp_get_model().get(), "M1");
    EXPECT_EQ(motor.sendp_speed(5).get(), 2.5F);
    motor.sendp_set_ramp(9).get();
    EXPECT_EQ(motor.sendp_get_ramp().get(), 9U);
    EXPECT_EQ(motor.sendp_sample(21).get(),
              std::tuple(Devices::State::RUNNING, 42, Devices::Samples{1, 500}));
    int called = 0;
    motor.sendc_get_ramp([&](canorb::Future<std::uint32_t> ramp) { called += ramp.get() == 9; });
    motor.sendc_sample([&](auto sampled) { called += std::get<1>(sampled.get()) == 2; }, 1);
    simulation_.run_for(std::chrono::seconds{1});
    EXPECT_EQ(called, 2);
}

// Bounds that the C++ type does not have hold for what a future decodes, and for what is sent.
TEST_F(GeneratedStubTest, AsynchronousCallsKnowTheBounds) {
    std::size_t length = 300;
    AnyAnswer servant{[&](canorb::ServerCall& call) {
        if (call.read()) call.reply(std::string(length, 'x'));
    }};
    server_.root_poa().activate_object_with_id(2, servant);
    const auto store =
        client_.string_to_object("corbaloc:caniop:3/2").unchecked_narrow<Plant::Store>();
    EXPECT_EQ(store.sendp_get_label().get(), std::string(300, 'x'));
    length = 301;
    EXPECT_THROW(store.sendp_get_label().get(), canorb::MARSHAL);
    EXPECT_THROW(static_cast<void>(store.sendp_set_label(std::string(301, 'x'))),
                 canorb::BAD_PARAM);
}

TEST_F(GeneratedStubTest, AsynchronousCallsThrowWhatIsDeclared) {
    AnyAnswer servant{[](canorb::ServerCall& call) { call.raise(Plant::Refused{"full"}); }};
    server_.root_poa().activate_object_with_id(2, servant);
    const auto store =
        client_.string_to_object("corbaloc:caniop:3/2").unchecked_narrow<Plant::Store>();
    EXPECT_THROW(store.sendp_get_label().get(), Plant::Refused);
    EXPECT_THROW(store.sendp_set_label("x").get(), Plant::Refused);
    EXPECT_THROW(store.sendp_get(1, canorb::BoundedString<20>{}).get(), canorb::UNKNOWN);
}

// `plain` and its neighbour `sendp_plain`, the attribute `level` and the operation `get_level`.
TEST_F(GeneratedStubTest, AsynchronousCallsWithNamesThatAreTaken) {
    std::vector<int> operations;
    AnyAnswer servant{[&](canorb::ServerCall& call) {
        operations.push_back(call.operation());
        call.reply(std::int32_t{5});
    }};
    server_.root_poa().activate_object_with_id(2, servant);
    const auto later =
        client_.string_to_object("corbaloc:caniop:3/2").unchecked_narrow<Asynchronous::Later>();
    EXPECT_THROW(later.sendp_ami_plain().get(), canorb::MARSHAL);       // 0, has no result
    EXPECT_THROW(later.sendp_plain(), canorb::MARSHAL);                 // 1
    EXPECT_THROW(later.sendp_sendp_plain().get(), canorb::MARSHAL);     // 1
    EXPECT_THROW(later.sendp_ami_typed().get(), canorb::MARSHAL);       // 2
    EXPECT_EQ(later.sendp_get_level().get(), 5);                        // 5
    EXPECT_EQ(later.sendp_ami_get_level().get(), 5);                    // 7
    EXPECT_THROW(later.sendp_set_level(1).get(), canorb::MARSHAL);      // 6
    EXPECT_THROW(later.sendp_ami_set_level(1).get(), canorb::MARSHAL);  // 16
    EXPECT_THROW(later.sendp_ami_ami_plain().get(), canorb::MARSHAL);   // 17
    EXPECT_EQ(operations, (std::vector<int>{0, 1, 1, 2, 5, 7, 6, 16, 17}));
}

}  // namespace
}  // namespace canorb::test
