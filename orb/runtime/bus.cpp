#include "canorb/bus.hpp"

#include <charconv>
#include <cstdlib>

#include "canorb/exceptions.hpp"
#include "orb/can/link/address.hpp"
#include "orb/can/link/link.hpp"

namespace canorb {
namespace {

/// A Bus on the machine's own clock.
class LinkBus final : public Bus {
  public:
    explicit LinkBus(std::unique_ptr<can::Link> link) : link_(std::move(link)) {}

    std::unique_ptr<can::Controller> attach(std::string_view name) override {
        auto controller = link_->attach(name);
        if (!controller) throw_system_exception(cause::bus_refused, controller.error());
        return std::move(*controller);
    }

    TimePoint now() const override { return link_->now(); }

  private:
    std::unique_ptr<can::Link> link_;
};

}  // namespace

std::unique_ptr<Bus> open_bus(std::string_view address) {
    if (const auto parsed = can::parse_bus_address(address); !parsed) {
        throw_system_exception(cause::bad_argument, parsed.error());
    }
    auto link = can::open_link(address);
    if (!link) throw_system_exception(cause::bus_refused, link.error());
    return std::make_unique<LinkBus>(std::move(*link));
}

std::string default_bus_address() {
    const char* address = std::getenv("CANORB_BUS");
    if (address != nullptr && *address != '\0') return address;
    return std::string{can::default_bus_address()};
}

int parse_node_id(std::string_view text) {
    int value = -1;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool is_number = error == std::errc{} && end == text.data() + text.size();
    if (!is_number || !NodeId::from(value)) {
        throw_system_exception(
            cause::bad_argument,
            "'" + std::string{text} + "' is no node id: a number from 0 to 30 is");
    }
    return value;
}

}  // namespace canorb
