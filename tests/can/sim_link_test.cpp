// The client's side of sim: addresses, also with the daemon gone.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/can/bus_server_fixture.hpp"

namespace canorb::can::test {
namespace {

using testing::HasSubstr;

using SimLinkTest = BusServerTest;

TEST_F(SimLinkTest, SaysHowToStartABusWhereThereIsNone) {
    const auto link = open_link(address());
    ASSERT_FALSE(link);
    EXPECT_EQ(link.error(), "no bus at " + address() +
                                " (No such file or directory): start one with: canorb-bus "
                                "--listen " +
                                address());
}

TEST_F(SimLinkTest, SaysSoWhenTheDaemonIsDead) {
    start();
    const std::string dead = directory_.path() + "/dead";
    {
        const auto listener = listen_at(dead);
        ASSERT_TRUE(listener);
    }
    const auto link = open_link("sim:" + dead);
    ASSERT_FALSE(link);
    EXPECT_THAT(link.error(), HasSubstr("Connection refused"));
}

TEST_F(SimLinkTest, ReportsWhyItWasRefused) {
    const auto listener = listen_at(path());
    ASSERT_TRUE(listener);
    std::thread daemon{[&] {
        ASSERT_TRUE(readable(listener->get()));
        const Descriptor client{::accept(listener->get(), nullptr, nullptr)};
        ASSERT_TRUE(readable(client.get()));
        send_packet(client, sim::encode(sim::Refusal{2, "this bus is for version 2"}));
    }};
    const auto link = open_link(address());
    daemon.join();
    ASSERT_FALSE(link);
    EXPECT_EQ(link.error(), "the bus at " + address() + " refused: this bus is for version 2");
}

TEST_F(SimLinkTest, SaysSoWhenWhatListensThereIsNoBus) {
    const auto listener = listen_at(path());
    ASSERT_TRUE(listener);
    std::thread daemon{[&] {
        ASSERT_TRUE(readable(listener->get()));
        const Descriptor client{::accept(listener->get(), nullptr, nullptr)};
        ASSERT_TRUE(readable(client.get()));
        ::send(client.get(), "hello", 5, MSG_NOSIGNAL);
    }};
    const auto link = open_link(address());
    daemon.join();
    ASSERT_FALSE(link);
    EXPECT_THAT(link.error(), HasSubstr("no welcome"));
}

TEST_F(SimLinkTest, KnowsTheBusFromItsWelcome) {
    BusServerOptions with = options();
    with.bitrate = 125'000;
    with.controller.mailboxes = 3;
    with.controller.filter_list = 7;
    start(with);
    const Capabilities capabilities = attach()->capabilities();
    EXPECT_EQ(capabilities.bitrate, 125'000U);
    EXPECT_EQ(capabilities.mailboxes, 3U);
    EXPECT_EQ(capabilities.filter_list, 7U);
}

TEST_F(SimLinkTest, IsStoppedWhenTheDaemonGoes) {
    start();
    const auto controller = attach();
    const SendResult sent = controller->send(Frame::standard(0x100, {}));
    ASSERT_TRUE(std::holds_alternative<TransmitHandle>(sent));
    server_.reset();
    std::optional<StateChanged> change;
    do {
        change = next<StateChanged>(*controller);
        ASSERT_TRUE(change);
    } while (change->status.state != ControllerState::stopped);
    const auto result = next<TransmitResult>(*controller);
    ASSERT_TRUE(result);
    EXPECT_EQ(result->handle, std::get<TransmitHandle>(sent));
    EXPECT_EQ(result->outcome, TransmitOutcome::failed);
    EXPECT_EQ(controller->send(Frame::standard(0x100, {})), SendResult{SendError::stopped});
    EXPECT_EQ(controller->error_status().state, ControllerState::stopped);
    EXPECT_EQ(controller->poll(), std::nullopt);
}

TEST_F(SimLinkTest, RecoversWhenTheDaemonIsBack) {
    start();
    const auto controller = attach("phoenix");
    server_.reset();
    ASSERT_TRUE(next<StateChanged>(*controller));
    controller->recover();  // too early: it is kept until there is a daemon
    EXPECT_EQ(controller->poll(), std::nullopt);
    start();
    const auto change = next<StateChanged>(*controller);
    ASSERT_TRUE(change);
    EXPECT_EQ(change->status, ErrorStatus{});
    EXPECT_EQ(controller->error_status(), ErrorStatus{});
    // Its filters are those from before.
    const auto other = attach();
    ASSERT_TRUE(std::holds_alternative<TransmitHandle>(other->send(Frame::standard(0x123, {}))));
    const auto received = next<Received>(*controller);
    ASSERT_TRUE(received);
    EXPECT_EQ(received->frame.id, 0x123U);
    ASSERT_TRUE(
        std::holds_alternative<TransmitHandle>(controller->send(Frame::standard(0x124, {}))));
    EXPECT_TRUE(next<Received>(*other));
    EXPECT_THAT(server_->log(), HasSubstr("client \"phoenix\""));
}

TEST_F(SimLinkTest, RecoversAtOnceWhenTheDaemonIsBackAlready) {
    start();
    const auto controller = attach();
    server_.reset();
    start();
    ASSERT_TRUE(next<StateChanged>(*controller));
    EXPECT_EQ(controller->error_status().state, ControllerState::stopped);
    controller->recover();
    const auto change = next<StateChanged>(*controller);
    ASSERT_TRUE(change);
    EXPECT_EQ(change->status.state, ControllerState::error_active);
    EXPECT_EQ(controller->poll(), std::nullopt);
}

TEST_F(SimLinkTest, DoesNotComeBackUnasked) {
    start();
    const auto controller = attach();
    server_.reset();
    start();
    ASSERT_TRUE(next<StateChanged>(*controller));
    expect_working_bus();
    EXPECT_EQ(controller->poll(), std::nullopt);
    EXPECT_EQ(controller->error_status().state, ControllerState::stopped);
}

TEST_F(SimLinkTest, NeverBlocksOnADaemonThatDoesNotRead) {
    const auto listener = listen_at(path());
    ASSERT_TRUE(listener);
    Descriptor query;
    Descriptor connection;
    std::thread daemon{[&] {
        for (Descriptor* client : {&query, &connection}) {
            ASSERT_TRUE(readable(listener->get()));
            *client = Descriptor{::accept(listener->get(), nullptr, nullptr)};
            send_packet(*client, sim::encode(sim::Welcome{true, 500'000, 255, 32}));
        }
    }};
    const auto controller = attach();
    daemon.join();
    ASSERT_TRUE(controller);
    for (int i = 0; i < 2000; ++i) EXPECT_TRUE(controller->set_filters(accept_all));
    EXPECT_EQ(controller->send(Frame::standard(0x100, {})), SendResult{SendError::full});
    EXPECT_EQ(controller->poll(), std::nullopt);
}

}  // namespace
}  // namespace canorb::can::test
