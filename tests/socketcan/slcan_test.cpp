// Our serial link and the kernel's own (the slcan line discipline), at the two ends of one line.
// Both are used to talk to an adapter: each takes what the other sends for received frames, and
// nobody answers commands.

#include <linux/tty.h>

#include <atomic>

#include "orb/can/link/descriptor.hpp"
#include "tests/can/pseudo_terminal.hpp"
#include "tests/socketcan/can_test.hpp"
#include "tests/support/octets.hpp"

namespace canorb::test {
namespace {

using can::test::PseudoTerminal;

/// Two serial lines whose other ends are connected to each other, for as long as this lives.
class NullModem {
  public:
    NullModem() : thread_([this] { relay(); }) {}
    ~NullModem() {
        ended_.raise();
        thread_.join();
    }
    NullModem(const NullModem&) = delete;
    NullModem& operator=(const NullModem&) = delete;

    const std::string& first() const { return first_.device(); }
    const std::string& second() const { return second_.device(); }

  private:
    void relay() {
        pollfd sources[3] = {
            {first_.peer(), POLLIN, 0}, {second_.peer(), POLLIN, 0}, {ended_.fd(), POLLIN, 0}};
        while (::poll(sources, 3, -1) > 0 && sources[2].revents == 0) {
            if (sources[0].revents != 0) pass(first_, second_);
            if (sources[1].revents != 0) pass(second_, first_);
        }
    }
    static void pass(const PseudoTerminal& from, const PseudoTerminal& to) {
        char buffer[4096];
        const ssize_t count = ::read(from.peer(), buffer, sizeof buffer);
        if (count > 0) to.write({buffer, static_cast<std::size_t>(count)});
    }

    PseudoTerminal first_;
    PseudoTerminal second_;
    can::Signal ended_;
    std::thread thread_;
};

/// The kernel's network interface behind a serial line, as slcan_attach makes it.
class KernelSlcan {
  public:
    explicit KernelSlcan(const std::string& device)
        : line_(::open(device.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC)) {
        const int discipline = N_SLCAN;
        ifreq request{};
        if (::ioctl(line_.get(), TIOCSETD, &discipline) != 0 ||
            ::ioctl(line_.get(), SIOCGIFNAME, &request) != 0) {
            throw std::system_error(errno, std::generic_category(), "the kernel's slcan");
        }
        interface_ = request.ifr_name;
        set_up(interface_, true);
    }

    const std::string& interface() const { return interface_; }

  private:
    can::Descriptor line_;
    std::string interface_;
};

class KernelSlcanTest : public VcanTest {
  protected:
    void SetUp() override {
        VcanTest::SetUp();
        if (IsSkipped()) return;
        if (::geteuid() != 0) GTEST_SKIP() << "makes an interface, which only root may do";
        kernel_.emplace(modem_.first());
    }
    /// Our end of the line.
    std::string ours() const { return "slcan:" + modem_.second() + "?answers=no"; }
    const std::string& theirs() const { return kernel_->interface(); }

  private:
    NullModem modem_;
    std::optional<KernelSlcan> kernel_;
};

TEST_F(KernelSlcanTest, UnderstandsOurFramesAndWeItsOwn) {
    const auto link = can::open_link(ours());
    ASSERT_TRUE(link.ok()) << link.error();
    const auto controller = (*link)->attach("test");
    ASSERT_TRUE(controller.ok()) << controller.error();
    const can::Filter everything{};
    ASSERT_TRUE((*controller)->set_filters({&everything, 1}));
    RawSocket socket{theirs()};

    const auto next_event = [&] {
        std::optional<can::ControllerEvent> event;
        EXPECT_TRUE(wait_until([&] { return (event = (*controller)->poll()).has_value(); }));
        return event.value_or(can::FramesLost{});
    };

    const std::vector<std::uint8_t> data = octets("00 0D 07 7F 80 FF 55 AA");
    for (std::uint32_t length = 0; length <= 8; ++length) {
        const Bytes payload{data.data(), length};
        const auto sent = (*controller)->send(can::Frame::standard(0x7F7 + length, payload));
        ASSERT_TRUE(std::holds_alternative<can::TransmitHandle>(sent));
        const can::ControllerEvent result = next_event();
        ASSERT_TRUE(std::holds_alternative<can::TransmitResult>(result));
        const auto frame = socket.receive_within(20s);
        ASSERT_TRUE(frame);
        EXPECT_EQ(frame->can_id, 0x7F7 + length);
        EXPECT_EQ(hex(Bytes{frame->data, frame->can_dlc}), hex(payload));

        socket.send(length, payload);
        const can::ControllerEvent event = next_event();
        ASSERT_TRUE(std::holds_alternative<can::Received>(event));
        EXPECT_EQ(std::get<can::Received>(event).frame, can::Frame::standard(length, payload));
    }
}

TEST_F(KernelSlcanTest, CarriesCallsBothWays) {
    Node kernel_side{"socketcan:" + theirs(), 3};
    Node our_side{ours(), 5};
    TestServant servants[2] = {TestServant{{{7, nothing}, {8, echo}}},
                               TestServant{{{7, nothing}, {8, echo}}}};
    kernel_side->root_poa().activate_object_with_id(1, servants[0]);
    our_side->root_poa().activate_object_with_id(1, servants[1]);
    const std::vector<std::uint8_t> octets(300, 0x0D);
    for (int i = 0; i < 3; ++i) {
        EXPECT_TRUE(our_side.object_on(3).invoke(7, {}).empty());
        EXPECT_EQ(our_side.object_on(3).invoke(8, octets), octets);
        EXPECT_TRUE(kernel_side.object_on(5).invoke(7, {}).empty());
        EXPECT_EQ(kernel_side.object_on(5).invoke(8, octets), octets);
    }
}

}  // namespace
}  // namespace canorb::test
