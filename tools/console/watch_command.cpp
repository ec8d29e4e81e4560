// canorb watch GROUP

#include <time.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <map>
#include <optional>
#include <string>

#include "orb/base/counters.hpp"
#include "orb/can/controller.hpp"
#include "orb/can/link/link.hpp"
#include "orb/caniop/filters.hpp"
#include "orb/caniop/reassembler.hpp"
#include "orb/giop/format.hpp"
#include "orb/giop/message.hpp"
#include "tools/console/commands.hpp"
#include "tools/console/signals.hpp"
#include "tools/console/values.hpp"

namespace canorb::console {
namespace {

/// From the bus's clock to Unix time.
Duration unix_time_offset() {
    timespec time{};
    ::clock_gettime(CLOCK_REALTIME, &time);
    const Duration unix_time = std::chrono::seconds{time.tv_sec} + Duration{time.tv_nsec};
    return unix_time - can::monotonic_now().time_since_epoch();
}

constexpr Duration second = std::chrono::seconds{1};

/// "14:03:07.123456", local time.
std::string clock_text(Duration unix_time) {
    const std::time_t seconds = unix_time / second;
    std::tm local{};
    ::localtime_r(&seconds, &local);
    std::array<char, 32> text{};
    const auto microseconds = static_cast<long>(unix_time % second / std::chrono::microseconds{1});
    std::snprintf(text.data(), text.size(), "%02d:%02d:%02d.%06ld", local.tm_hour, local.tm_min,
                  local.tm_sec, microseconds);
    return text.data();
}

/// Puts the frames of one group together and prints its messages. It only listens.
class Watcher {
  public:
    Watcher(const CommonOptions& common, const WatchOptions& options, const Model& model)
        : common_(common), options_(options), model_(model) {}

    std::uint64_t messages() const { return messages_; }

    void take(const can::Received& received) {
        const auto admitted = caniop::admit(received.frame, std::nullopt, groups_);
        const auto* const from = std::get_if<caniop::Identifier>(&admitted);
        if (from == nullptr) return;
        const auto reception = reassembler_.accept(*from, received.frame.payload(), received.time);
        if (const auto* const message = std::get_if<caniop::Message>(&reception)) {
            show(*from, message->octets, received.time);
        } else if (const auto* const bad = std::get_if<caniop::Malformed>(&reception)) {
            show_octets(*from, "malformed message", bad->first_frame, received.time);
        }
    }

    void frames_lost() { reassembler_.drop_all(); }

    /// What was no whole message, so that nobody takes the list for complete.
    void tell_dropped() const {
        std::uint64_t dropped = 0;
        for (const Counter cause :
             {Counter::sequence_errors, Counter::continuations_without_message,
              Counter::interrupted_messages}) {
            dropped += counters_[cause];
        }
        if (dropped > 0) {
            say(std::to_string(dropped) +
                (dropped == 1 ? " message was not whole" : " messages or parts were not whole") +
                ", and left out");
        }
    }

  private:
    void show(const caniop::Identifier& from, Bytes octets, TimePoint time) {
        const auto parsed = giop::parse(octets);
        const auto* const request = parsed ? std::get_if<giop::Request>(&*parsed) : nullptr;
        if (request == nullptr) return show_octets(from, "no Request", octets, time);
        // As members do: CAN may deliver a message twice.
        const auto [last, first_of_sender] = last_ids_.try_emplace(from.sender, request->id);
        if (!first_of_sender && last->second == request->id) return;
        last->second = request->id;

        const Interface* const interface = model_.find_interface(request->object_key);
        const Operation* operation =
            interface == nullptr ? nullptr : interface->find(request->operation);
        // A key is the CRC of an id: another interface may have the same.
        if (operation != nullptr && operation->declared_in != interface->name) operation = nullptr;
        std::string arguments = "octets " + hex(request->parameters);
        Json json{{"interface_key", request->object_key}, {"operation_id", request->operation}};
        if (operation == nullptr) {
            std::array<char, 64> key{};
            std::snprintf(key.data(), key.size(),
                          "interface %04X, operation %d: ", unsigned{request->object_key},
                          int{request->operation});
            json["octets"] = hex(request->parameters);
            return line(from, key.data() + arguments, std::move(json), time);
        }
        json["interface"] = interface->name;
        json["operation"] = operation->name;
        const auto values = decode_arguments(*operation, request->parameters, model_);
        if (values) {
            json["arguments"] = Json::object();
            arguments.clear();
            for (const auto& [name, value] : *values) {
                json["arguments"][name] = value;
                arguments += (arguments.empty() ? "" : ", ") + name + ": " + to_text(value);
            }
        } else {
            json["octets"] = hex(request->parameters);
            arguments += "; not as in the IDL: " + values.error();
        }
        line(from, interface->name + '.' + operation->name + '(' + arguments + ')', std::move(json),
             time);
    }

    void show_octets(const caniop::Identifier& from, const std::string& what, Bytes octets,
                     TimePoint time) {
        line(from, what + ": octets " + hex(octets), {{"error", what}, {"octets", hex(octets)}},
             time);
    }

    void line(const caniop::Identifier& from, const std::string& text, Json json, TimePoint time) {
        if (options_.count != 0 && messages_ == options_.count) return;
        ++messages_;
        const Duration unix_time = time.time_since_epoch() + offset_;
        if (!common_.json) {
            return print(clock_text(unix_time) + " node " + std::to_string(from.sender) + ' ' +
                         text);
        }
        const double seconds = std::chrono::duration<double>(unix_time).count();
        Json all{{"time", seconds}, {"node", from.sender}, {"group", from.receiver}};
        all.update(json);
        print(to_text(all));
    }

    const CommonOptions& common_;
    const WatchOptions& options_;
    const Model& model_;
    const std::array<GroupId, 1> groups_{options_.group};
    const Duration offset_ = unix_time_offset();
    Counters counters_;
    caniop::Reassembler reassembler_{
        {.max_message = giop::max_message}, {giop::header_size, giop::message_length}, counters_};
    std::map<std::uint8_t, RequestId> last_ids_;
    std::uint64_t messages_ = 0;
};

/// False: the bus is gone, which was said.
bool take_all(can::Controller& controller, Watcher& watcher) {
    while (const auto event = controller.poll()) {
        if (const auto* const received = std::get_if<can::Received>(&*event)) {
            watcher.take(*received);
        } else if (const auto* const lost = std::get_if<can::FramesLost>(&*event)) {
            if (lost->count > 0) {
                say("at least " + std::to_string(lost->count) + " frames were lost");
            }
            watcher.frames_lost();
        } else if (const auto* const changed = std::get_if<can::StateChanged>(&*event)) {
            if (changed->status.state != can::ControllerState::stopped) continue;
            say("the bus is gone. " + controller.explanation());
            return false;
        }
    }
    return true;
}

}  // namespace

int watch(const CommonOptions& common, const WatchOptions& options) {
    const auto model = load(options.idl);
    if (!model) return fail(model.error(), usage_error);
    const StopSignals signals;
    const auto link = can::open_link(common.bus);
    if (!link) return fail(link.error(), bus_unreachable);
    const auto controller = (*link)->attach("canorb watch");
    if (!controller) return fail(controller.error(), bus_unreachable);
    can::Controller& listener = **controller;
    // Silent where the link can be: not even an acknowledgment then comes from here.
    static_cast<void>(listener.set_listen_only(true));
    const std::array<GroupId, 1> groups{options.group};
    if (!listener.set_filters(caniop::exact_filters(std::nullopt, groups).span()))
        return fail("the controller does not take the filter of a group", call_failed);

    say("watching group " + std::to_string(options.group.value()) + " on " + common.bus +
        "; Ctrl-C ends it");
    Watcher watcher{common, options, **model};
    const TimePoint end = options.duration ? (*link)->now() + *options.duration : never;
    bool stopped = false;
    bool there = true;
    while (there && !stopped && (options.count == 0 || watcher.messages() < options.count)) {
        const Duration left = end - (*link)->now();
        if (end != never && left <= Duration::zero()) break;
        constexpr Duration longest = std::chrono::hours{1};
        const auto wait = std::chrono::ceil<std::chrono::milliseconds>(std::min(left, longest));
        stopped = signals.wait(listener.event_fd(), static_cast<int>(wait.count())) ==
                  StopSignals::Woken::by_signal;
        there = take_all(listener, watcher);
        if (std::ferror(stdout) != 0) break;  // nobody reads on
    }
    watcher.tell_dropped();
    return there ? success : bus_unreachable;
}

}  // namespace canorb::console
