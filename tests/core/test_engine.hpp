#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "orb/core/engine.hpp"
#include "orb/giop/message.hpp"
#include "tests/support/octets.hpp"

namespace canorb::core::test {

using canorb::test::hex;
using canorb::test::octets;
using namespace std::chrono_literals;

inline constexpr InterfaceInfo bell{"IDL:Test/Bell:1.0"};

/// Counters by name, those that are 0 left out.
using Counted = std::map<std::string, std::uint64_t>;
using Texts = std::vector<std::string>;

inline std::string describe(const SystemError& error) {
    std::string text{name(error.kind)};
    text += " ";
    text += name(error.completion);
    if (error.minor != 0) text += " " + std::to_string(error.minor);
    return text;
}

/// "NO_EXCEPTION 2A", "USER_EXCEPTION 0100", "TIMEOUT MAYBE 2": with the minor.
inline std::string describe(const CallResult& result) {
    if (const auto* error = std::get_if<SystemError>(&result)) return describe(*error);
    const auto& answer = std::get<CallAnswer>(result);
    const char* status = answer.status == giop::ReplyStatus::no_exception     ? "NO_EXCEPTION "
                         : answer.status == giop::ReplyStatus::user_exception ? "USER_EXCEPTION "
                                                                              : "SYSTEM_EXCEPTION ";
    return status + hex(answer.body);
}

/// "object 1 operation 7 2A", "group 7 key 4DDB operation 2 ".
inline std::string describe(const IncomingRequest& request) {
    std::string text = "object " + std::to_string(request.object);
    if (request.group) {
        const std::uint8_t key[] = {static_cast<std::uint8_t>(request.interface_key >> 8),
                                    static_cast<std::uint8_t>(request.interface_key)};
        text = "group " + std::to_string(request.group->value()) + " key " + hex(key);
    }
    return text + " operation " + std::to_string(request.operation) + " " + hex(request.parameters);
}

/// The octets of a Reply with a system exception, written down here once more:
/// "IDL:omg.org/CORBA/<exception>:1.0", minor and completion, one octet each in hex.
inline std::string system_exception_reply(std::string_view request_id, std::string_view exception,
                                          std::string_view minor, std::string_view completion) {
    const std::string id = "IDL:omg.org/CORBA/" + std::string{exception} + ":1.0";
    const Bytes id_octets{reinterpret_cast<const std::uint8_t*>(id.data()), id.size()};
    const std::uint8_t length[] = {static_cast<std::uint8_t>(id.size() + 1)};
    const std::uint8_t size[] = {0, static_cast<std::uint8_t>(3 + 1 + id.size() + 1 + 1 + 1)};
    return "11" + hex(size) + std::string{request_id} + "02" + hex(length) + hex(id_octets) + "00" +
           std::string{minor} + std::string{completion};
}

/// Cuts a message into frames, "4A3 1100..." each: by hand, to be independent of the segmenter.
inline Texts frames_of(std::string_view can_id, std::string_view message) {
    const std::string digits = hex(octets(message));
    Texts frames{std::string{can_id} + " " + digits.substr(0, 16)};
    for (std::size_t at = 16, n = 1; at < digits.size(); at += 14, ++n) {
        const std::uint8_t sequence[] = {static_cast<std::uint8_t>(0x80 + n % 128)};
        frames.push_back(std::string{can_id} + " " + hex(sequence) + digits.substr(at, 14));
    }
    return frames;
}

inline std::string text_of(const can::Frame& frame) {
    const std::uint8_t id[] = {static_cast<std::uint8_t>(frame.id >> 8),
                               static_cast<std::uint8_t>(frame.id)};
    return hex(id).substr(1) + " " + hex(frame.payload());
}

/// An engine, its clock, and its owner's part: node 5, whose first request id is ABCD.
///
/// Identifiers that occur often: 465 node 5 to 3, 4A3 node 3 to 5, 4A4 node 4 to 5, 0E5 and 0E3
/// nodes 5 and 3 to group 7.
class TestEngine {
  public:
    static EngineOptions options() {
        EngineOptions result;
        result.node = NodeId{5};
        result.first_request_id = 0xABCD;
        return result;
    }

    explicit TestEngine(const EngineOptions& engine_options = options()) : engine(engine_options) {}

    // ---- calls

    /// `key` and `parameters` are hex.
    Result<CallHandle, SystemError> try_call(std::string_view key, OperationId operation = 2,
                                             std::string_view parameters = "",
                                             Duration timeout = 1s) {
        auto message = request(parameters);
        return engine.call(object_key(key), operation, message, now + timeout);
    }
    CallHandle call(std::string_view key, OperationId operation = 2,
                    std::string_view parameters = "", Duration timeout = 1s) {
        const auto handle = try_call(key, operation, parameters, timeout);
        EXPECT_TRUE(handle.ok());
        return handle ? *handle : CallHandle{};
    }
    /// "queued", "own", or the error.
    std::string send(std::string_view key, OperationId operation = 2,
                     std::string_view parameters = "", Duration timeout = 1s) {
        auto message = request(parameters);
        return outcome(engine.send(object_key(key), operation, message, now + timeout));
    }
    std::string multicast(std::uint8_t group, std::uint16_t interface_key = 0x4DDB,
                          OperationId operation = 2, std::string_view parameters = "",
                          Duration timeout = 1s) {
        auto message = request(parameters);
        return outcome(
            engine.multicast(GroupId{group}, interface_key, operation, message, now + timeout));
    }
    /// What became of it, or "waiting". Fetched when it has ended.
    std::string result(CallHandle handle) {
        if (!engine.ended(handle)) {
            EXPECT_FALSE(engine.take_result(handle).has_value());
            return "waiting";
        }
        auto taken = engine.take_result(handle);
        EXPECT_TRUE(taken.has_value());
        if (!taken) return "";
        const std::string text = describe(*taken);
        if (auto* answer = std::get_if<CallAnswer>(&*taken)) {
            engine.buffers().release(std::move(answer->body));
        }
        return text;
    }

    // ---- requests

    /// All that wait for servants. The answer_to of the last is kept.
    Texts requests() {
        Texts texts;
        while (auto request = engine.next_request(now)) {
            texts.push_back(describe(*request));
            caller = request->answer_to;
            engine.buffers().release(std::move(request->parameters));
        }
        return texts;
    }
    void answer(std::string_view body = "",
                giop::ReplyStatus status = giop::ReplyStatus::no_exception) {
        std::vector<std::uint8_t> message(giop::reply_header_size);
        const auto octets_of_body = octets(body);
        message.insert(message.end(), octets_of_body.begin(), octets_of_body.end());
        engine.answer(caller, status, message, now);
    }

    // ---- the link

    void event(const can::ControllerEvent& what) { engine.on_event(what, now); }
    /// "4A3 110003ABCD00"
    void receive(std::string_view frame) {
        const auto id = octets("0" + std::string{frame.substr(0, 3)});
        const auto payload = octets(frame.substr(3));
        event(can::Received{can::Frame::standard(read_be16(id.data()), payload), now});
    }
    void receive(const Texts& frames) {
        for (const std::string& frame : frames) receive(frame);
    }
    void state(can::ControllerState state) { event(can::StateChanged{{state, 0, 0}, now}); }

    /// The frames that the engine hands over; they stay in the controller.
    Texts hand_over() {
        Texts frames;
        while (const auto abort = engine.next_abort()) aborted.push_back(*abort);
        while (const auto frame = engine.next_frame(now)) {
            frames.push_back(text_of(*frame));
            in_controller.push_back(can::TransmitHandle{++last_frame});
            engine.handed_over(in_controller.back());
        }
        return frames;
    }
    /// The fate of the oldest frame in the controller.
    void finish_frame(can::TransmitOutcome outcome = can::TransmitOutcome::sent) {
        ASSERT_FALSE(in_controller.empty());
        const can::TransmitHandle frame = in_controller.front();
        in_controller.pop_front();
        event(can::TransmitResult{frame, outcome, now});
    }
    /// All frames that the engine has, each confirmed at once.
    Texts transmit() {
        Texts all;
        for (;;) {
            const Texts frames = hand_over();
            all.insert(all.end(), frames.begin(), frames.end());
            if (in_controller.empty()) return all;
            finish_frame();
        }
    }

    // ---- time

    void advance(Duration by) {
        now += by;
        engine.on_time(now);
        // Else an owner that sleeps until then would never sleep.
        EXPECT_GT(engine.next_deadline(), now);
    }

    // ---- what happened

    /// What was counted since the last time.
    Counted counted() {
        Counted result;
        for (std::size_t i = 0; i < counter_count; ++i) {
            const auto counter = static_cast<Counter>(i);
            const std::uint64_t more = engine.counters()[counter] - seen_[counter];
            if (more != 0) result[std::string{name(counter)}] = more;
        }
        seen_ = engine.counters();
        return result;
    }

    Texts notices() {
        Texts texts;
        while (const auto notice = engine.next_notice()) {
            if (std::holds_alternative<MessageSent>(*notice)) {
                texts.emplace_back("sent");
            } else if (std::holds_alternative<MessageDropped>(*notice)) {
                texts.emplace_back("dropped");
            } else if (std::holds_alternative<DuplicateNodeSeen>(*notice)) {
                texts.emplace_back("duplicate node");
            } else if (const auto* change = std::get_if<ControllerChanged>(&*notice)) {
                texts.emplace_back(can::name(change->change.status.state));
            } else if (const auto* loss = std::get_if<LinkLostFrames>(&*notice)) {
                texts.push_back("lost " + std::to_string(loss->loss.count));
            } else {
                texts.emplace_back("?");
            }
        }
        return texts;
    }

    Engine engine;
    TimePoint now{1s};
    AnswerTo caller;
    std::deque<can::TransmitHandle> in_controller;
    std::vector<can::TransmitHandle> aborted;
    std::uint64_t last_frame = 0;

  private:
    static ObjectKey object_key(std::string_view key) {
        return ObjectKey{read_be16(octets(key).data())};
    }
    static std::vector<std::uint8_t> request(std::string_view parameters) {
        std::vector<std::uint8_t> message(giop::request_header_size);
        const auto more = octets(parameters);
        message.insert(message.end(), more.begin(), more.end());
        return message;
    }
    static std::string outcome(
        const Result<std::optional<caniop::MessageHandle>, SystemError>& sent) {
        if (!sent) return describe(sent.error());
        return sent->has_value() ? "queued" : "own";
    }

    Counters seen_;
};

}  // namespace canorb::core::test
