// Generated code over the whole ORB, on virtual time.

#include "devices.hpp"
#include "tests/runtime/world.hpp"
#include "tests/support/octets.hpp"

namespace canorb::test {
namespace {

class MotorImpl final : public Devices::MotorServant {
  public:
    std::string model() override { return "M-1"; }
    float speed(std::uint16_t channel) override { return static_cast<float>(channel) + 0.5F; }
    void start() override {
        if (broken) throw Devices::MotorStartException{"no current"};
        running = true;
    }
    void stop() override { running = false; }
    std::uint32_t ramp() override { return ramp_; }
    void ramp(std::uint32_t value) override { ramp_ = value; }
    Devices::State sample(std::int32_t& range, Devices::Samples& samples) override {
        samples = {1, 200, 30000};
        range = -range;
        return running ? Devices::State::RUNNING : Devices::State::STOPPED;
    }
    void follow(const Devices::Motor& leader) override { leader_ = leader; }
    Devices::Motor leader() override { return leader_; }
    void SetAttributeValueUL(const std::string& name, std::uint32_t index,
                             std::uint32_t value) override {
        attribute = name + "[" + std::to_string(index) + "]=" + std::to_string(value);
    }

    bool broken = false;
    bool running = false;
    std::string attribute;

  private:
    std::uint32_t ramp_ = 10;
    Devices::Motor leader_;
};

class PumpImpl final : public Devices::PumpServant {
  public:
    std::string model() override { return "P-1"; }
    void prime() override { ++primed; }
    int primed = 0;
};

class Generated : public World {
  protected:
    Generated() {
        server.root_poa().activate_object_with_id(1, motor_servant);
        motor = at(client, 3, 1).narrow<Devices::Motor>();
        simulation.run_for(1ms);
        seen.clear();
    }

    Orb server{bus, node(3)};
    Orb client{bus, node(5)};
    MotorImpl motor_servant;
    Devices::Motor motor;
};

TEST_F(Generated, ValuesBothWays) {
    EXPECT_EQ(motor.model(), "M-1");
    EXPECT_EQ(motor.speed(1000), 1000.5F);
    motor.ramp(4'000'000'000U);
    EXPECT_EQ(motor.ramp(), 4'000'000'000U);
    std::int32_t range = 77;
    Devices::Samples samples;
    EXPECT_EQ(motor.sample(range, samples), Devices::State::STOPPED);
    EXPECT_EQ(range, -77);
    EXPECT_EQ(samples, (Devices::Samples{1, 200, 30000}));
}

TEST_F(Generated, DeclaredException) {
    motor_servant.broken = true;
    try {
        motor.start();
        FAIL();
    } catch (const Devices::MotorStartException& exception) {
        EXPECT_EQ(exception.reason, "no current");
    }
    motor_servant.broken = false;
    motor.start();
    EXPECT_TRUE(motor_servant.running);
}

TEST_F(Generated, OnewayGetsNoReply) {
    motor.start();
    seen.clear();
    motor.stop();
    EXPECT_TRUE(motor_servant.running);
    simulation.run_for(1ms);
    EXPECT_FALSE(motor_servant.running);
    EXPECT_EQ(seen.size(), 1U);
}

// A call with a name, an index and a value: four frames with 31 octets of payload.
TEST_F(Generated, LongerCallIsCutIntoFrames) {
    motor.SetAttributeValueUL("max_acceleration", 3, 42);
    EXPECT_EQ(motor_servant.attribute, "max_acceleration[3]=42");
    ASSERT_EQ(seen.size(), 5U);
    const auto payload = [&](std::size_t i) { return hex(seen[i].frame.payload()); };
    const std::string request_id = payload(0).substr(6, 4);
    EXPECT_EQ(payload(0),
              "10"    // Request, version 1.0
              "0019"  // message_size: 25
                  + request_id +
                  "1801"  // node 3, index 1
                  "09");  // operation
    EXPECT_EQ(payload(1),
              "81"
              "11"
              "6D61785F6163");  // 17 octets with the NUL: "max_ac"
    EXPECT_EQ(payload(2),
              "82"
              "63656C65726174");  // "celerat"
    EXPECT_EQ(payload(3),
              "83"
              "696F6E"
              "00"
              "03"
              "2A");  // "ion", NUL, 3, 42
    EXPECT_EQ(payload(4),
              "11"
              "0003" +
                  request_id + "00");
    std::size_t octets = 0;
    for (std::size_t i = 0; i < 4; ++i) octets += seen[i].frame.length;
    EXPECT_EQ(octets, 31U);
}

TEST_F(Generated, ReferencesAsParametersBelongToTheReceiver) {
    MotorImpl here;
    const auto local = client.root_poa().activate_object(here).narrow<Devices::Motor>();
    motor.follow(local);
    const Devices::Motor back = motor.leader();
    EXPECT_EQ(back, local);
    here.ramp(77);
    EXPECT_EQ(back.ramp(), 77U);
    // The server's copy calls from the server: over the bus.
    seen.clear();
    EXPECT_EQ(motor_servant.leader().ramp(), 77U);
    EXPECT_EQ(seen.at(0).frame.id, 0b1'00101'00011U);
    motor.follow(Devices::Motor{});
    EXPECT_TRUE(motor.leader().is_nil());
    EXPECT_THROW(motor.leader().stop(), INV_OBJREF);
}

TEST_F(Generated, CopiesWithTimeoutAndSent) {
    std::vector<TimePoint> sent;
    motor.with_timeout(5ms).with_sent([&] { sent.push_back(simulation.now()); }).start();
    EXPECT_EQ(sent, std::vector<TimePoint>{seen.at(0).end});
    server.root_poa().deactivate_object(1);
    EXPECT_THROW(motor.start(), OBJECT_NOT_EXIST);
}

TEST_F(Generated, ThroughABaseInterface) {
    PumpImpl pump;
    server.root_poa().activate_object_with_id(2, pump);
    const auto base = at(client, 3, 2).narrow<Devices::Base>();
    EXPECT_EQ(base.model(), "P-1");
    EXPECT_TRUE(base.narrow<Devices::Motor>().is_nil());
    EXPECT_FALSE(base.narrow<Devices::Pump>().is_nil());
    const Devices::Base as_base = motor;
    EXPECT_EQ(as_base.model(), "M-1");
    // An operation of another interface.
    EXPECT_THROW(base.unchecked_narrow<Devices::Motor>().ramp(), BAD_OPERATION);
}

TEST_F(Generated, Groups) {
    PumpImpl pump;
    MotorImpl second;
    const GroupId five{5};
    server.object_join(server.root_poa().activate_object(pump), five);
    server.object_join(server.root_poa().activate_object(second), five);
    const auto bases = client.string_to_object(server.group_to_string(five));
    EXPECT_EQ(bases.type_id(), "IDL:Devices/Base:1.0");

    const auto pumps = group(client, 5).narrow<Devices::Pump>();
    pumps.prime();
    const auto motors = group(client, 5).narrow<Devices::Motor>();
    motors.ramp(123);                            // an attribute can be set...
    EXPECT_THROW(motors.ramp(), BAD_OPERATION);  // ...but not read
    EXPECT_THROW(motors.start(), BAD_OPERATION);
    simulation.run_for(10ms);
    EXPECT_EQ(pump.primed, 1);
    EXPECT_EQ(second.ramp(), 123U);
    EXPECT_EQ(server.counters()[Counter::group_interface_mismatches], 2U);
}

TEST_F(Generated, OwnNodeIsNoDifferent) {
    MotorImpl here;
    const auto local = client.root_poa().activate_object(here).narrow<Devices::Motor>();
    here.broken = true;
    EXPECT_THROW(local.start(), Devices::MotorStartException);
    EXPECT_EQ(local.speed(2), 2.5F);
    here.running = true;
    local.stop();
    EXPECT_TRUE(here.running);
    simulation.run_for(1ms);
    EXPECT_FALSE(here.running);
    EXPECT_TRUE(seen.empty());
}

}  // namespace
}  // namespace canorb::test
