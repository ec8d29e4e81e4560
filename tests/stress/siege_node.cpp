// One of the processes that siege_test.cpp kills.
//
//     stress_siege_node BUS NODE PEERS
//         Serves object 1, and calls the nodes 1 to PEERS without end, each from a thread of its
//         own. PEERS 0: it calls nobody. It ends with its parent.

#include <signal.h>
#include <sys/prctl.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <exception>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "canorb/orb.hpp"
#include "siege.hpp"
#include "tests/stress/ledger.hpp"

namespace {

using namespace canorb;
using namespace std::chrono_literals;
using canorb::test::stress::answer_to;

constexpr std::size_t most_nodes = 8;
/// Long enough for a busy machine, where the peer lives.
constexpr Duration patience = 2s;
/// For a call within a call. A servant's call ends after those that are nested in it, so eight of
/// these, to nodes that are dead, must fit into the patience of the one whose call came first.
constexpr Duration nested_patience = 240ms;

class Node final : public Siege::PeerServant {
  public:
    Node(Bus& bus, int number)
        : number_(number),
          orb_(bus,
               {.node = number, .inter_frame_timeout = patience, .log = [](std::string_view) {}}) {}

    Orb& orb() { return orb_; }

    void serve() {
        // A little later than it is on the bus: to those who call now there is no such object.
        orb_.at(orb_.now() + 2ms, [this] { orb_.root_poa().activate_object_with_id(1, *this); });
        orb_.run();
    }

    /// Calls of all kinds to one node, without end.
    void besiege(int node) {
        const Siege::Peer target =
            peer(node).with_timeout(patience).unchecked_narrow<Siege::Peer>();
        const auto index = static_cast<std::size_t>(node);
        Siege::Text text(60);
        for (std::uint32_t token = 0;; ++token) {
            try {
                bool right = false;
                switch (token % 3) {
                    case 0:
                        right = target.answer(token) == answer_to(token);
                        break;
                    case 1:
                        text[0] = static_cast<std::uint8_t>(token);
                        right = target.reflect(text) == text;
                        break;
                    default:
                        right = target.callback(token, static_cast<std::uint8_t>(number_)) ==
                                answer_to(token);
                        break;
                }
                ++answered_[index];
                if (!right) complain("a wrong answer of node " + std::to_string(node));
            } catch (const TIMEOUT&) {
                ++failed_[index];
            } catch (const OBJECT_NOT_EXIST&) {
                ++failed_[index];
            } catch (const TRANSIENT&) {
                // Its calls are nested too deep, to nodes that are dead: to be tried again.
            } catch (const Siege::Broken&) {  // the call back to this node took too long
                ++failed_[index];
            } catch (const std::exception& exception) {
                complain(exception.what());
            }
            orb_.run_for(10ms);  // else the highest nodes never win an arbitration
        }
    }

  private:
    Siege::Peer peer(int node) {
        return orb_.string_to_object("corbaloc:caniop:" + std::to_string(node) + "/1")
            .unchecked_narrow<Siege::Peer>();
    }

    std::uint32_t answer(std::uint32_t token) override { return answer_to(token); }
    Siege::Text reflect(const Siege::Text& octets) override { return octets; }
    void enter(const Siege::Gate& way) override { way.pass(); }
    void send(std::uint8_t node, const Siege::Gate& way) override {
        try {
            peer(node).with_timeout(nested_patience).unchecked_narrow<Siege::Peer>().enter(way);
        } catch (const SystemException& exception) {
            throw Siege::Broken{exception._repository_id()};
        }
    }
    std::uint32_t callback(std::uint32_t token, std::uint8_t node) override {
        try {
            return peer(node)
                .with_timeout(nested_patience)
                .unchecked_narrow<Siege::Peer>()
                .answer(token);
        } catch (const SystemException& exception) {
            throw Siege::Broken{exception._repository_id()};
        }
    }
    Siege::Report look() override {
        Siege::Report report;
        for (std::size_t i = 0; i < most_nodes; ++i) {
            report.answered.push_back(answered_[i]);
            report.failed.push_back(failed_[i]);
        }
        const std::lock_guard lock{mutex_};
        report.complaint = complaint_;
        return report;
    }

    void complain(std::string complaint) {
        const std::lock_guard lock{mutex_};
        if (complaint_.empty()) complaint_ = complaint.substr(0, 200);
    }

    const int number_;
    std::array<std::atomic<std::uint32_t>, most_nodes> answered_{};
    std::array<std::atomic<std::uint32_t>, most_nodes> failed_{};
    std::mutex mutex_;
    std::string complaint_;
    Orb orb_;
};

}  // namespace

int main(int argc, char** argv) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    try {
        if (argc != 4) throw std::invalid_argument("see the source for its arguments");
        const auto bus = open_bus(argv[1]);
        const int number = std::stoi(argv[2]);
        Node node{*bus, number};
        std::vector<std::thread> callers;
        for (int peer = 1; peer <= std::stoi(argv[3]); ++peer) {
            if (peer != number) callers.emplace_back([&node, peer] { node.besiege(peer); });
        }
        node.serve();
    } catch (const std::exception& exception) {
        std::fprintf(stderr, "%s\n", exception.what());
        return 1;
    }
}
