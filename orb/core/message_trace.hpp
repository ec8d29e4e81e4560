#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "orb/base/ids.hpp"
#include "orb/base/system_error.hpp"
#include "orb/base/time.hpp"
#include "orb/giop/format.hpp"

namespace canorb::core {

/// One message that a node sent or received, with its header decoded. A plain value.
struct MessageTrace {
    enum class Direction : std::uint8_t {
        out,    ///< sent over the bus, or given up
        in,     ///< received from the bus
        local,  ///< between objects of this node: never on the bus
    };
    enum class Type : std::uint8_t { request, reply, message_error, malformed };
    /// What became of it. Only what goes out can be anything but `done` or `refused`.
    enum class Fate : std::uint8_t {
        done,       ///< sent to the last frame, received, or handed over locally
        expired,    ///< its deadline came before it was begun: no frame of it was sent
        cancelled,  ///< its call was cancelled before it was begun: no frame of it was sent
        stopped,    ///< given up between two frames
        failed,     ///< bus-off, or the link went down
        refused,    ///< in: above max_message; only its first frame was looked at
    };

    /// When this node learned of it, on the Orb's clock: for what goes out, when its last frame was
    /// confirmed or it was given up.
    TimePoint time{};
    Direction direction = Direction::out;
    Type type = Type::request;
    Fate fate = Fate::done;
    NodeId from{0};
    /// A node (0..30), or a group (1..31).
    std::variant<NodeId, GroupId> to{NodeId{0}};
    /// Of Requests and Replies; 0 for local ones.
    RequestId request_id = 0;

    // Of Requests.
    ObjectIndex object = 0;           ///< to a node
    std::uint16_t interface_key = 0;  ///< to a group; 0: unchecked
    OperationId operation = 0;
    /// Sent, or called locally, as oneway. The message does not tell it to the receiver.
    bool oneway = false;
    /// The repository id of the object's interface, where the object is active at this node.
    std::string interface{};

    // Of Replies.
    std::optional<giop::ReplyStatus> status{};  ///< nothing: one that is unknown
    SystemError error{};                        ///< where status is system_exception
    std::string
        exception{};  ///< repository id, where status is user_exception; 64 characters at most

    std::size_t octets = 0;  ///< header included, as the header tells it
    std::size_t frames = 0;  ///< that so many octets take; 0 for local ones
};

/// One line, without an end of line. Its columns keep their places; doc/tracing.md explains them:
///
///     1.000246 in     3 -> 5        Reply        ABCD     6 octets    1 frame   NO_EXCEPTION
std::string to_string(const MessageTrace& trace);

}  // namespace canorb::core
