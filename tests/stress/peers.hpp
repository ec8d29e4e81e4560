#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "canorb/orb.hpp"
#include "stress.hpp"
#include "tests/stress/ledger.hpp"

namespace canorb::test::stress {

using namespace std::chrono_literals;
using Random = std::mt19937;

inline std::uint32_t below(Random& random, std::uint32_t limit) {
    return static_cast<std::uint32_t>(random() % limit);
}

/// Whether a call is answered.
enum class Manner : std::uint8_t { two_way, queued };

/// Objects of one node that have no other purpose than to be called. A call that may have been
/// executed uses one up, so that what each of them must have seen is known. Any thread.
class Doors {
  public:
    Doors(Poa& poa, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) {
            doors_.push_back(std::make_unique<Door>());
            doors_.back()->index = *poa.activate_object(*doors_.back()).index();
            closed_.push_back(doors_.back().get());
        }
    }

    class Door final : public Stress::DoorServant {
      public:
        void knock() override { ++knocks; }

        ObjectIndex index = 0;
        std::atomic<std::uint64_t> knocks = 0;
        std::uint64_t sure = 0;   ///< calls that were executed
        std::uint64_t maybe = 0;  ///< calls that may have been
        std::uint64_t never = 0;  ///< calls that were not
    };

    /// One that nobody calls; null when all are in use or used up.
    Door* take() {
        const std::lock_guard lock{mutex_};
        if (closed_.empty()) return nullptr;
        Door* door = closed_.front();
        closed_.pop_front();
        return door;
    }
    void give_back(Door& door, Fate fate) {
        const std::lock_guard lock{mutex_};
        if (fate == Fate::once) ++door.sure;
        if (fate == Fate::maybe) ++door.maybe;
        if (fate == Fate::never) ++door.never;
        if (door.maybe == 0) closed_.push_back(&door);
    }

    /// Knocks that are too many or too few, at most twenty sentences. Not while calls are under
    /// way.
    std::vector<std::string> contradictions() const {
        std::vector<std::string> found;
        for (const auto& door : doors_) {
            const std::uint64_t most = door->sure + door->maybe;
            if (door->knocks >= door->sure && door->knocks <= most) continue;
            found.push_back("object " + std::to_string(door->index) + " was called " +
                            std::to_string(door->knocks) + " times, not " +
                            std::to_string(door->sure) + " to " + std::to_string(most) + ", and " +
                            std::to_string(door->never) + " calls were refused");
            if (found.size() == 20) break;
        }
        return found;
    }

  private:
    std::mutex mutex_;
    std::vector<std::unique_ptr<Door>> doors_;
    std::deque<Door*> closed_;
};

/// Everything that all nodes of a run share. Any thread.
class Run {
  public:
    explicit Run(std::size_t calls) : ledger(calls) {}
    virtual ~Run() = default;
    Run(const Run&) = delete;
    Run& operator=(const Run&) = delete;

    /// The longest that a call may take that has this timeout. `nested`: made by a servant.
    virtual Duration longest(Duration timeout, bool nested) const = 0;
    /// The timeout for a call that would like this one; 0: it is not to be made.
    virtual Duration shortened(Duration timeout) const { return timeout; }
    virtual void begin_call(TimePoint /*deadline*/) {}
    virtual void end_call() {}

    void complain(const std::string& complaint) {
        const std::lock_guard lock{mutex_};
        if (complaints_.size() < 20) complaints_.push_back(complaint);
    }
    std::vector<std::string> complaints() const {
        const std::lock_guard lock{mutex_};
        return complaints_;
    }

    void count(const std::string& what) {
        const std::lock_guard lock{mutex_};
        ++counted_[what];
    }
    std::map<std::string, std::uint64_t> counted() const {
        const std::lock_guard lock{mutex_};
        return counted_;
    }

    Ledger ledger;
    std::map<int, Doors*> doors;           ///< by node
    std::atomic<std::uint64_t> right = 0;  ///< calls that ended as the operation says

  private:
    mutable std::mutex mutex_;
    std::vector<std::string> complaints_;
    std::map<std::string, std::uint64_t> counted_;
};

/// One node: an Orb, an object with index 1 that is a member of group 5, and calls to its peers,
/// itself among them, which are nodes 1 to `nodes`.
class Node final : private Stress::PeerServant {
  public:
    static constexpr int nodes = 4;
    static constexpr GroupId group{5};

    Node(Run& run, Bus& bus, OrbOptions options)
        : run_(run), number_(options.node.value()), orb_(bus, std::move(options)) {
        for (int peer = 1; peer <= nodes; ++peer) {
            peers_[static_cast<std::size_t>(peer)] =
                orb_.string_to_object("corbaloc:caniop:" + std::to_string(peer) + "/1")
                    .unchecked_narrow<Stress::Peer>();
        }
        all_ = orb_.group_reference(group).unchecked_narrow<Stress::Peer>();
        run_.doors[number_] = &doors_;
        orb_.object_join(orb_.root_poa().activate_object_with_id(1, *this), group);
        // From the loop, as a program would.
        orb_.on_event([this](const Event& event) {
            if (event.kind == Event::Kind::controller_state &&
                orb_.error_status().state == can::ControllerState::bus_off) {
                ++bus_offs;
                orb_.recover();
            }
        });
    }

    Orb& orb() { return orb_; }

    /// Any operation of any peer.
    void call_anyone(Random& random, Duration timeout) {
        const int peer = 1 + static_cast<int>(below(random, nodes));
        switch (below(random, 16)) {
            case 0:
                refuse_at(peer, timeout);
                break;
            case 1:
                fail_at(peer, timeout);
                break;
            case 2:
            case 3:
                relay_to(random, peer, timeout);
                break;
            case 4:
            case 5:
                reflect_at(random, peer, timeout);
                break;
            case 6:
                tell(peer, timeout);
                break;
            case 7:
                announce(timeout);
                break;
            case 8:
            case 9:
            case 10:
                knock_at(peer, timeout);
                break;
            case 11:
            case 12:
                two_at_once(peer, timeout);
                break;
            case 13:
                cancel_at(peer, timeout);
                break;
            default:
                answer_at(peer, timeout);
                break;
        }
    }

    /// Those that return at once.
    void tell(int peer, Duration timeout) {
        perform(Manner::queued, bit(peer), timeout,
                [&](Token token, Duration time) { to(peer, time).tell(token); });
    }
    void announce(Duration timeout) {
        perform(Manner::queued, (1U << (nodes + 1)) - 2, timeout, [&](Token token, Duration time) {
            all_.with_timeout(time).unchecked_narrow<Stress::Peer>().announce(token);
        });
    }

    void answer_at(int peer, Duration timeout) {
        perform(Manner::two_way, bit(peer), timeout, [&](Token token, Duration time) {
            expect_answer(to(peer, time).answer(token), token);
        });
    }

    const Doors& doors() const { return doors_; }

    std::atomic<std::uint64_t> bus_offs = 0;

  private:
    static unsigned bit(int node) { return 1U << node; }

    Stress::Peer to(int peer, Duration timeout) const {
        return peers_[static_cast<std::size_t>(peer)]
            .with_timeout(timeout)
            .unchecked_narrow<Stress::Peer>();
    }

    void knock_at(int peer, Duration timeout) {
        Doors& doors = *run_.doors.at(peer);
        Doors::Door* door = doors.take();
        if (door == nullptr) return;
        const auto target = orb_.string_to_object("corbaloc:caniop:" + std::to_string(peer) + "/" +
                                                  std::to_string(door->index));
        const Fate fate = perform(Manner::two_way, 0, timeout, [&](Token, Duration time) {
            target.with_timeout(time).unchecked_narrow<Stress::Door>().knock();
        });
        doors.give_back(*door, fate);
    }
    void reflect_at(Random& random, int peer, Duration timeout) {
        Stress::Load sent;
        sent.resize(below(random, 61));
        for (std::uint8_t& octet : sent) octet = static_cast<std::uint8_t>(random());
        perform(Manner::two_way, bit(peer), timeout, [&](Token token, Duration time) {
            const Stress::Load received = to(peer, time).reflect(token, sent);
            expect(
                std::equal(received.begin(), received.end(), std::make_reverse_iterator(sent.end()),
                           std::make_reverse_iterator(sent.begin())),
                token, "another's load");
        });
    }
    /// The second ends, or is waited for, before the first is asked for.
    void two_at_once(int peer, Duration timeout) {
        const auto asynchronously = [&](Token first, Duration first_time) {
            auto early = to(peer, first_time).sendp_answer(first);
            answer_later(peer, timeout);
            expect_answer(early.get(), first);
        };
        perform(Manner::two_way, bit(peer), timeout, asynchronously, true);
    }
    void answer_later(int peer, Duration timeout) {
        perform(Manner::two_way, bit(peer), timeout, [&](Token token, Duration time) {
            expect_answer(to(peer, time).sendp_answer(token).get(), token);
        });
    }
    /// Its end is never heard of.
    void cancel_at(int peer, Duration timeout) {
        perform(Manner::queued, bit(peer), timeout,
                [&](Token token, Duration time) { to(peer, time).sendp_answer(token).cancel(); });
    }
    void refuse_at(int peer, Duration timeout) {
        perform(Manner::two_way, bit(peer), timeout, [&](Token token, Duration time) {
            try {
                to(peer, time).refuse(token);
                expect(false, token, "no exception");
            } catch (const Stress::Refused& refused) {
                expect(refused.token == token, token,
                       "the exception of call " + std::to_string(refused.token));
            }
        });
    }
    void fail_at(int peer, Duration timeout) {
        perform(Manner::two_way, bit(peer), timeout, [&](Token token, Duration time) {
            try {
                to(peer, time).fail(token);
                expect(false, token, "no exception");
            } catch (const NO_PERMISSION& exception) {
                expect(exception.completed() == Completion::yes, token, exception.what());
            }
        });
    }
    void relay_to(Random& random, int peer, Duration timeout) {
        Stress::Route route;
        route.resize(1 + below(random, 3));
        for (std::uint8_t& node : route) node = static_cast<std::uint8_t>(1 + below(random, nodes));
        relay_along(peer, route, timeout, false);
    }
    /// True: to the end of the route and back.
    bool relay_along(int peer, const Stress::Route& route, Duration timeout, bool nested) {
        bool whole = false;
        perform(
            Manner::two_way, bit(peer), timeout,
            [&](Token token, Duration time) {
                try {
                    expect_answer(to(peer, time).relay(token, route), token);
                    whole = true;
                } catch (const Stress::Broken& broken) {
                    expect(broken.token == token, token,
                           "the exception of call " + std::to_string(broken.token));
                    run_.count("broken");
                }
            },
            nested);
        return whole;
    }

    // ---- the servant

    std::uint32_t answer(std::uint32_t token) override {
        execute(token);
        return answer_to(token);
    }
    Stress::Load reflect(std::uint32_t token, const Stress::Load& sent) override {
        execute(token);
        Stress::Load answer = sent;
        std::reverse(answer.begin(), answer.end());
        return answer;
    }
    void refuse(std::uint32_t token) override {
        execute(token);
        throw Stress::Refused{token};
    }
    void fail(std::uint32_t token) override {
        execute(token);
        throw NO_PERMISSION("as always", Completion::yes);
    }
    std::uint32_t relay(std::uint32_t token, const Stress::Route& route) override {
        execute(token);
        if (route.empty()) return answer_to(token);
        const Stress::Route rest = tail(route);
        if (!relay_along(route[0], rest, nested_timeout, true)) throw Stress::Broken{token};
        return answer_to(token);
    }
    void tell(std::uint32_t token) override { execute(token); }
    void announce(std::uint32_t token) override { execute(token); }

    static Stress::Route tail(const Stress::Route& route) {
        Stress::Route rest;
        for (std::size_t i = 1; i < route.size(); ++i) rest.push_back(route[i]);
        return rest;
    }

    void execute(Token token) {
        if (!run_.ledger.execute(token, number_)) {
            run_.complain("node " + std::to_string(number_) + " was called with token " +
                          std::to_string(token) + ", which nobody has made");
        }
    }

    // ---- what must hold for every call

    void expect(bool holds, Token token, std::string_view otherwise) {
        if (holds) return;
        run_.complain("call " + std::to_string(token) + " of node " + std::to_string(number_) +
                      " got " + std::string{otherwise});
    }

    void expect_answer(std::uint32_t answer, Token token) {
        if (answer == answer_to(token)) return;
        expect(false, token, "the answer to call " + std::to_string(token_of(answer)));
    }

    /// The exceptions of doc/errors.md that these calls can end with, when all the objects are
    /// there and both sides have the same IDL.
    static bool is_documented(Manner manner, const SystemError& error) {
        switch (error.kind) {
            case SystemErrorKind::no_resources:
            case SystemErrorKind::transient:
                return error.completion == Completion::no;
            case SystemErrorKind::comm_failure:
                return error.completion == Completion::no ||
                       (manner == Manner::two_way && error.completion == Completion::maybe);
            case SystemErrorKind::timeout:
                return manner == Manner::two_way && error.completion != Completion::yes;
            default:
                return false;
        }
    }

    /// What is known of the call at its end.
    template <typename Call>
    Fate perform(Manner manner, unsigned targets, Duration timeout, Call call,
                 bool nested = false) {
        timeout = run_.shortened(timeout);
        if (timeout <= Duration::zero()) return Fate::never;
        const Token token = run_.ledger.begin(targets);
        Fate fate = manner == Manner::two_way ? Fate::once : Fate::maybe;
        const TimePoint begin = orb_.now();
        run_.begin_call(begin + timeout);
        try {
            call(token, timeout);
            ++run_.right;
        } catch (const SystemException& exception) {
            const Completion completed = exception.completed();
            fate = completed == Completion::no      ? Fate::never
                   : completed == Completion::maybe ? Fate::maybe
                                                    : Fate::once;
            run_.count(std::string{name(exception.error().kind)} + " " +
                       std::string{name(completed)});
            if (!is_documented(manner, exception.error())) expect(false, token, exception.what());
        } catch (const std::exception& exception) {
            expect(false, token, exception.what());
        }
        run_.end_call();
        const Duration took = orb_.now() - begin;
        run_.ledger.end(token, fate);
        if (took > run_.longest(timeout, nested)) {
            run_.complain("call " + std::to_string(token) + " of node " + std::to_string(number_) +
                          " took " + std::to_string(took / 1us) + " us with a timeout of " +
                          std::to_string(timeout / 1us) + " us");
        }
        return fate;
    }

    static constexpr Duration nested_timeout = 60ms;

    Run& run_;
    const int number_;
    std::array<Stress::Peer, nodes + 1> peers_;
    Stress::Peer all_;
    Orb orb_;
    Doors doors_{orb_.root_poa(), 900};
};

/// What goes wrong on the bus of a run: noise, loose plugs, transmitters that stick, frames that
/// some nodes get twice and others not at all, and nodes that are driven to bus-off; in about so
/// many frames of each node. No node is cut off for the time of two frames: it would be beyond what
/// CANIOP can tell (doc/wire/caniop.md, "What it gives, and what not").
inline std::string fault_script(std::uint32_t frames, std::uint32_t seed) {
    std::string script = "seed " + std::to_string(seed) +
                         "\n"
                         "bit-error-rate 1e-5 wire\n"
                         "bit-error-rate 2e-5 each-node\n"
                         "at 13ms every 97ms cut-off node-2 for 10 bits\n"
                         "at 57ms every 131ms cut-off node-3 for 10 bits\n"
                         "at 71ms every 211ms stuck-dominant node-4 for 300us\n"
                         "at 91ms every 307ms stuck-dominant wire for 200us\n";
    Random random{seed};
    // Each line costs time at each frame.
    const std::uint32_t longest_step = std::max(20U, frames / 1000);
    for (std::uint32_t attempt = 20; attempt < frames; attempt += 1 + below(random, longest_step)) {
        const std::uint32_t sender = 1 + below(random, Node::nodes);
        const std::uint32_t victim = 1 + (sender + below(random, Node::nodes - 1)) % Node::nodes;
        const std::string frame =
            "frame from node-" + std::to_string(sender) + " attempt " + std::to_string(attempt);
        switch (below(random, 60)) {
            case 0:  // bus-off
                script += frame + ".." + std::to_string(attempt + 40) + " at crc.3 flip wire\n";
                break;
            case 1:
            case 2:  // as if the sender died in its last bit, for a moment
                script += frame + " at eof.6 dominant node-" + std::to_string(victim) + "\n" +
                          frame + " at eof.7 cut-off node-" + std::to_string(sender) +
                          " for 10 bits\n";
                break;
            case 3:  // everybody has it, but the sender does not know
            case 4:
            case 5:
                script += frame + " at eof.7 dominant node-" + std::to_string(sender) + "\n";
                break;
            default:  // twice for all but the victim
                script += frame + " at eof.6 dominant node-" + std::to_string(victim) + "\n";
                break;
        }
    }
    return script;
}

}  // namespace canorb::test::stress
