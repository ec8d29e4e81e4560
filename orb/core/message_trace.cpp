#include "orb/core/message_trace.hpp"

#include <algorithm>
#include <chrono>
#include <string_view>

namespace canorb::core {
namespace {

using Trace = MessageTrace;

std::string right(std::string text, std::size_t width) {
    return text.size() < width ? std::string(width - text.size(), ' ') + text : text;
}

std::string left(std::string text, std::size_t width) {
    if (text.size() < width) text.append(width - text.size(), ' ');
    return text;
}

std::string hex4(std::uint16_t value) {
    constexpr std::string_view digits = "0123456789ABCDEF";
    std::string text;
    for (int shift = 12; shift >= 0; shift -= 4) text += digits[value >> shift & 0xF];
    return text;
}

std::string seconds(TimePoint time) {
    const auto us =
        std::chrono::duration_cast<std::chrono::microseconds>(time.time_since_epoch()).count();
    std::string fraction = std::to_string(us % 1'000'000);
    fraction.insert(0, 6 - fraction.size(), '0');
    return std::to_string(us / 1'000'000) + "." + fraction;
}

std::string_view name(Trace::Direction direction) {
    switch (direction) {
        case Trace::Direction::out:
            return "out";
        case Trace::Direction::in:
            return "in";
        case Trace::Direction::local:
            break;
    }
    return "local";
}

std::string_view name(Trace::Type type) {
    switch (type) {
        case Trace::Type::request:
            return "Request";
        case Trace::Type::reply:
            return "Reply";
        case Trace::Type::message_error:
            return "MessageError";
        case Trace::Type::malformed:
            break;
    }
    return "malformed";
}

/// With a comma in front; empty for what went well.
std::string_view outcome(Trace::Fate fate) {
    switch (fate) {
        case Trace::Fate::done:
            break;
        case Trace::Fate::expired:
            return "NOT SENT: its deadline passed";
        case Trace::Fate::cancelled:
            return "NOT SENT: its call was cancelled";
        case Trace::Fate::stopped:
            return "STOPPED between two frames";
        case Trace::Fate::failed:
            return "FAILED with the link";
        case Trace::Fate::refused:
            return "REFUSED: above max_message";
    }
    return "";
}

std::string route(const Trace& trace) {
    const auto* group = std::get_if<GroupId>(&trace.to);
    return right(std::to_string(trace.from.value()), 2) + " -> " +
           (group != nullptr ? "group " + std::to_string(group->value())
                             : std::to_string(std::get<NodeId>(trace.to).value()));
}

std::string count(std::size_t n, std::string_view what, std::size_t width) {
    return right(std::to_string(n), width) + " " + std::string{what} + (n == 1 ? " " : "s");
}

std::string request_details(const Trace& trace) {
    std::string text = std::holds_alternative<GroupId>(trace.to)
                           ? "interface key " + hex4(trace.interface_key)
                           : "object " + std::to_string(trace.object);
    text += ", operation " + std::to_string(trace.operation);
    if (trace.oneway) text += ", oneway";
    if (!trace.interface.empty()) text += ", " + trace.interface;
    return text;
}

std::string reply_details(const Trace& trace) {
    if (!trace.status) return "unknown status";
    switch (*trace.status) {
        case giop::ReplyStatus::no_exception:
            break;
        case giop::ReplyStatus::user_exception:
            return "USER_EXCEPTION " + trace.exception;
        case giop::ReplyStatus::system_exception:
            return "SYSTEM_EXCEPTION " + std::string{canorb::name(trace.error.kind)} + " " +
                   std::string{canorb::name(trace.error.completion)} + ", minor " +
                   std::to_string(trace.error.minor);
    }
    return "NO_EXCEPTION";
}

}  // namespace

std::string to_string(const MessageTrace& trace) {
    const bool has_id = trace.direction != Trace::Direction::local &&
                        (trace.type == Trace::Type::request || trace.type == Trace::Type::reply);
    std::string text = right(seconds(trace.time), 16);
    text += " " + left(std::string{name(trace.direction)}, 5);
    text += " " + left(route(trace), 14);
    text += " " + left(std::string{name(trace.type)}, 12);
    text += " " + left(has_id ? hex4(trace.request_id) : std::string{}, 4);
    text += " " + count(trace.octets, "octet", 5);
    text += trace.frames == 0 ? std::string(12, ' ') : " " + count(trace.frames, "frame", 4);
    std::string details;
    if (trace.type == Trace::Type::request) details = request_details(trace);
    if (trace.type == Trace::Type::reply) details = reply_details(trace);
    if (const std::string_view end = outcome(trace.fate); !end.empty()) {
        if (!details.empty()) details += ", ";
        details += end;
    }
    text += "  " + details;
    text.erase(text.find_last_not_of(' ') + 1);
    return text;
}

}  // namespace canorb::core
