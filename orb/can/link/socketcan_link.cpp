#include "orb/can/link/socketcan_link.hpp"

#include "orb/can/link/socketcan_controller.hpp"

namespace canorb::can {
namespace {

class SocketCanLink final : public Link {
  public:
    explicit SocketCanLink(std::string interface) : interface_(std::move(interface)) {}

    Result<std::unique_ptr<Controller>, std::string> attach(std::string_view) override {
        auto controller = SocketCanController::open(interface_);
        if (!controller) return Failure{controller.error()};
        return std::unique_ptr<Controller>{std::move(*controller)};
    }

    TimePoint now() const override { return monotonic_now(); }

  private:
    std::string interface_;
};

}  // namespace

Result<std::unique_ptr<Link>, std::string> open_socketcan_link(const SocketCanAddress& address) {
    const auto possible = SocketCanController::open(address.interface);
    if (!possible) return Failure{possible.error()};
    return std::unique_ptr<Link>{std::make_unique<SocketCanLink>(address.interface)};
}

}  // namespace canorb::can
