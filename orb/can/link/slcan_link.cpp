#include "orb/can/link/slcan_link.hpp"

#include <utility>

#include "orb/can/link/serial_port.hpp"
#include "orb/can/link/slcan_controller.hpp"

namespace canorb::can {
namespace {

class SlcanLink final : public Link {
  public:
    explicit SlcanLink(SlcanAddress address) : address_(std::move(address)) {}

    Result<std::unique_ptr<Controller>, std::string> attach(std::string_view) override {
        auto controller = SlcanController::open(address_);
        if (!controller) return Failure{controller.error()};
        return std::unique_ptr<Controller>{std::move(*controller)};
    }

    TimePoint now() const override { return monotonic_now(); }

  private:
    SlcanAddress address_;
};

}  // namespace

Result<std::unique_ptr<Link>, std::string> open_slcan_link(const SlcanAddress& address) {
    const auto port = SerialPort::open(address.device, address.baud);
    if (!port) return Failure{port.error()};
    return std::unique_ptr<Link>{std::make_unique<SlcanLink>(address)};
}

}  // namespace canorb::can
