#pragma once

/// The ORB: one node on a bus.
///
///     auto bus = canorb::open_bus("sim:/tmp/canorb-bus");
///     canorb::Orb orb{*bus, {.node = 3, .name = "pump-3"}};
///     MotorImpl motor;                                     // derives from Devices::MotorServant
///     canorb::ObjectRef self = orb.root_poa().activate_object_with_id(1, motor);
///     orb.object_join(self, canorb::GroupId{5});
///     std::cout << orb.object_to_string(self) << '\n';
///     orb.run();                                           // until orb.shutdown()

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "canorb/bus.hpp"
#include "canorb/exceptions.hpp"
#include "canorb/object_ref.hpp"
#include "canorb/poa.hpp"
#include "canorb/servant.hpp"
#include "orb/base/counters.hpp"
#include "orb/core/message_trace.hpp"

namespace canorb {

/// What happened to the node that is no call's business. `text` is one line for people.
struct Event {
    enum class Kind : std::uint8_t {
        duplicate_node,     ///< another node uses this node's id
        controller_state,   ///< error active, error passive, bus-off, stopped
        frames_lost,        ///< the link lost received frames; partial messages were dropped
        servant_exception,  ///< a servant or callback raised what nobody could be told
    };
    Kind kind;
    TimePoint time;
    std::string text;
};

/// One message in or out with its header decoded; `to_string(trace)` is its line. doc/tracing.md.
using MessageTrace = core::MessageTrace;

struct OrbOptions {
    /// This node's number, 0..30. Unset: it may receive nothing and call nobody until set_node().
    std::optional<int> node{};
    /// 1 to 16 characters, for people; "node-N" when empty.
    std::string name{};
    /// What the management object tells of the device besides its name, for people; at most 32
    /// characters each.
    std::string vendor{};
    std::string product{};
    std::string software_version{};
    /// The device's serial number; 0: none.
    std::uint64_t serial = 0;
    /// How often the device was started, where the application counts it; else 0.
    std::uint32_t boot_count = 0;
    /// Object index 0 of this node is its canorb::Node (<canorb/node.idl>): identity, what runs
    /// here, counters. False: there is no such object.
    bool management_object = true;
    /// The deadline of calls that have none of their own; there is no infinite one.
    Duration default_timeout = std::chrono::seconds{1};
    /// Received messages above this many octets are skipped and answered IMP_LIMIT; 8..65538.
    std::size_t max_message = 4096;
    /// Messages that may wait in the transmit queue; a call beyond gets NO_RESOURCES.
    std::size_t max_queued_messages = 64;
    /// Two-way calls that may be outstanding: not ended, ended and not fetched from their Future,
    /// or cancelled and not yet answered.
    std::size_t max_outstanding_calls = 64;
    /// Frames in the controller at once: an urgent message waits for no more than these. They are
    /// not taken back: a node with urgent messages beside others on a busy bus wants as many as it
    /// has streams of messages (doc/benchmarks.md).
    std::size_t frames_in_controller = 2;
    /// A partial message that gets no frame for so long is dropped.
    Duration inter_frame_timeout = std::chrono::milliseconds{100};
    /// Threads of the ORB's own that run the event loop, from its making until shutdown(), 0 to
    /// 256; so many servant calls are served at a time. 0: none, one call at a time is served by
    /// threads that lend themselves to the ORB. Not in a Simulation.
    std::size_t worker_threads = 0;
    /// The least gap between two frames of one message, for slow receivers.
    Duration continuation_gap{0};
    /// Gives `log` a line for each message in and out. The environment can ask for it, too:
    /// CANORB_TRACE=1.
    bool trace = false;
    /// Gets each event's line. Unset: they go to standard error.
    std::function<void(std::string_view line)> log{};
};

/// Names a timer of one ORB.
enum class TimerId : std::uint64_t {};

/// One node. All functions may be called from any thread, unless they say otherwise. Servants,
/// timers and callbacks run one at a time, in whichever thread runs the event loop or waits for a
/// reply; with worker threads, servants run in as many threads at once as there are workers.
class Orb {
  public:
    /// Throws BAD_PARAM for options out of range, COMM_FAILURE when the bus refuses.
    explicit Orb(Bus& bus, OrbOptions options = {});
    /// Sends what is still queued, for as long as options().default_timeout at most, without
    /// serving anybody meanwhile; then detaches. In a simulation, whose time stands still, it only
    /// detaches. Other threads leave run(), and their calls throw BAD_INV_ORDER. Not to be
    /// destroyed from its own servants and callbacks.
    ~Orb();
    Orb(const Orb&) = delete;
    Orb& operator=(const Orb&) = delete;

    std::optional<NodeId> node() const;
    /// Changes this node's number; references made before keep the old one. Throws BAD_PARAM.
    void set_node(int node);
    const OrbOptions& options() const;

    Poa& root_poa();

    /// "CAN_IOR:..." in hex, or "corbaloc:caniop:NODE/INDEX" or "corbaloc:caniop:group/GROUP".
    /// Throws BAD_PARAM for an unknown prefix or a number out of range, INV_OBJREF for bad hex or
    /// octets; what() says why.
    ObjectRef string_to_object(std::string_view text);
    std::string object_to_string(const ObjectRef& reference) const;
    /// The group as seen from here: with the most derived interface common to its local members.
    std::string group_to_string(GroupId group) const;
    ObjectRef group_reference(GroupId group) const;

    /// Makes a local object a member of a group. Throws BAD_PARAM when it is none of this ORB's,
    /// when the group is not 1..31, or when it shares no interface with the members there.
    void object_join(const ObjectRef& object, GroupId group);
    void object_leave(const ObjectRef& object, GroupId group);
    bool object_is_member(const ObjectRef& object, GroupId group) const;
    std::vector<ObjectRef> group_members(GroupId group) const;

    /// Runs the event loop until shutdown(). Several threads may; one call is served at a time.
    void run();
    /// Runs the event loop for that long; false when shutdown() ended it.
    bool run_for(Duration duration);
    /// Does what is due now and returns without waiting.
    void poll();
    /// A descriptor that is readable when poll() has something to do, for a program with an event
    /// loop of its own: wait for it, then call poll(). Valid as long as the Orb; do not read from
    /// it. Throws BAD_INV_ORDER in a Simulation, whose time does not pass by itself.
    int event_fd();
    /// Runs the event loop until what was begun is done: no request waits for its servant or is in
    /// it, no call of this ORB waits for its answer, no message waits for the bus. False when that
    /// took longer than `limit`. Requests that come meanwhile are served: PoaManager's
    /// discard_requests() keeps them out. Works after shutdown(), too. Throws BAD_INV_ORDER from
    /// servants and callbacks.
    bool drain(Duration limit);
    /// Ends run() and run_for(), now and later. Safe from servants, other threads and, as the only
    /// function, from signal handlers.
    void shutdown() noexcept;

    TimePoint now() const;
    /// Runs `callback` from the event loop at that time.
    TimerId at(TimePoint time, std::function<void()> callback);
    /// Runs `callback` every `period`, first one period from now. Times keep to the grid; what
    /// could not run in its whole period is skipped, not made up for.
    TimerId every(Duration period, std::function<void()> callback);
    /// No effect on timers that ran or were cancelled. The callback may still be running, in
    /// another thread.
    void cancel(TimerId timer);

    /// Replaces the callback for events; called from the event loop.
    void on_event(std::function<void(const Event&)> callback);
    /// Lets others restart this node through its management object: the callback is called from
    /// the event loop when the answer to them is on the bus, or could not be sent within
    /// options().default_timeout. It makes the program begin anew, in whatever way that does:
    ///
    ///     orb.on_restart([&] { restart = true; orb.shutdown(); });
    ///
    /// Requests until then are one. An empty callback, as at first: they get NO_PERMISSION.
    void on_restart(std::function<void()> callback);
    /// Replaces the callback for each message that this node sends, receives or makes within
    /// itself; called from the event loop. An empty one ends it. Tracing costs next to nothing
    /// until the first callback is set. What the event loop does not fetch in time is counted:
    /// traces_lost.
    void on_message(std::function<void(const MessageTrace&)> callback);
    Counters counters() const;
    can::ErrorStatus error_status() const;
    can::Capabilities link_capabilities() const;
    /// Asks the controller to leave bus-off, or a link that is down to come up again; an event
    /// tells when it has. Throws NO_PERMISSION where this program may not ask; what() says who may.
    void recover();

  private:
    std::shared_ptr<runtime::OrbImpl> impl_;
};

}  // namespace canorb
