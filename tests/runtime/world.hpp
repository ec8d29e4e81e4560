#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "canorb/orb.hpp"
#include "canorb/simulation.hpp"
#include "canorb/stub.hpp"

namespace canorb::test {

using namespace std::chrono_literals;

inline constexpr InterfaceInfo device_interface{"IDL:Test/Device:1.0"};
inline constexpr const InterfaceInfo* device_bases[] = {&device_interface};
inline constexpr InterfaceInfo lamp_interface{"IDL:Test/Lamp:1.0", device_bases};
inline constexpr InterfaceInfo horn_interface{"IDL:Test/Horn:1.0", device_bases};
inline constexpr InterfaceInfo other_interface{"IDL:Test/Other:1.0"};

/// A servant made of functions, by operation id.
class TestServant final : public Servant {
  public:
    using Operation = std::function<void(ServerCall&)>;

    explicit TestServant(std::map<OperationId, Operation> operations = {},
                         const InterfaceInfo& interface = lamp_interface)
        : operations_(std::move(operations)), interface_(interface) {}

    const InterfaceInfo& _interface_info() const override { return interface_; }
    void _dispatch(ServerCall& call) override {
        const auto found = operations_.find(call.operation());
        if (found == operations_.end()) return;
        ++calls;
        found->second(call);
    }

    std::atomic<int> calls = 0;  ///< worker threads may call at the same time

  private:
    std::map<OperationId, Operation> operations_;
    const InterfaceInfo& interface_;
};

/// Answers without a result.
inline void nothing(ServerCall& call) {
    if (call.read()) call.reply();
}

/// Answers the parameters.
inline void echo(ServerCall& call) {
    const Bytes parameters = call.remaining_parameters();
    const std::vector<std::uint8_t> copy{parameters.begin(), parameters.end()};
    call.reply(RawOctets{copy});
}

/// The error with which `call` ends; UNKNOWN with minor 99 when it ends well.
template <typename Call>
SystemError error_of(Call call) {
    try {
        call();
    } catch (const SystemException& exception) {
        return exception.error();
    }
    ADD_FAILURE() << "nothing was thrown";
    return {SystemErrorKind::unknown, Completion::maybe, 99};
}

/// What the exception E says that `call` throws.
template <typename E, typename Call>
std::string what(Call call) {
    try {
        call();
    } catch (const E& exception) {
        return exception.what();
    }
    ADD_FAILURE() << "nothing was thrown";
    return {};
}

/// A call as a stub makes it.
inline void call_through(const ObjectRef& target, const OperationInfo& operation,
                         Bytes parameters = {}) {
    ClientCall call{target, operation};
    call.write(RawOctets{parameters});
    call.invoke();
    call.read();
}

/// One bus on virtual time, and what was on it.
class World : public testing::Test {
  protected:
    struct Seen {
        can::Frame frame;
        TimePoint end;
    };

    explicit World(const SimulatedBusOptions& options = {}) : bus(simulation.add_bus(options)) {
        bus.on_frame(
            [this](const can::Frame& frame, TimePoint end) { seen.push_back({frame, end}); });
    }

    /// Options of a node that logs into `log`.
    OrbOptions node(std::optional<int> number) {
        OrbOptions options;
        options.node = number;
        options.log = [this](std::string_view line) { log.emplace_back(line); };
        return options;
    }

    static ObjectRef at(Orb& orb, int node, int index) {
        return orb.string_to_object("corbaloc:caniop:" + std::to_string(node) + "/" +
                                    std::to_string(index));
    }
    static ObjectRef group(Orb& orb, int number) {
        return orb.string_to_object("corbaloc:caniop:group/" + std::to_string(number));
    }

    Simulation simulation;
    SimulatedBus& bus;
    std::vector<Seen> seen;
    std::vector<std::string> log;
};

inline constexpr OperationInfo ring{&lamp_interface, 0, "ring", false, true};
inline constexpr OperationInfo ring_oneway{&lamp_interface, 0, "ring", true, true};

}  // namespace canorb::test
