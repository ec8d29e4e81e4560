// canorb nodes, show, groups, counters, restart: what the management objects of nodes tell.

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "canorb/node.hpp"
#include "tools/console/commands.hpp"
#include "tools/console/session.hpp"
#include "tools/console/table.hpp"
#include "tools/console/values.hpp"

namespace canorb::console {
namespace {

/// What a node says of itself in a text: what could give orders to a terminal is escaped.
std::string plain(std::string_view text) {
    const std::string quoted = to_text(Json(std::string{text}));
    return quoted.substr(1, quoted.size() - 2);
}
template <typename Text>
std::string plain(const Text& text) {
    return plain(std::string_view{text.data(), text.size()});
}
template <typename Text>
std::string string_of(const Text& text) {
    return {text.data(), text.size()};
}

std::string or_dash(std::string text) {
    return text.empty() ? "-" : text;
}

std::string state_text(Node::ControllerState state) {
    static constexpr std::string_view names[] = {"error active", "error passive", "bus-off",
                                                 "stopped"};
    return std::string{names[static_cast<std::size_t>(state)]};
}

std::string uptime_text(std::uint64_t milliseconds) {
    const std::uint64_t seconds = milliseconds / 1000;
    const std::uint64_t minutes = seconds / 60;
    const std::uint64_t hours = minutes / 60;
    if (hours >= 24) return fmt::format("{}d {:02}h", hours / 24, hours % 24);
    if (hours > 0) return fmt::format("{}h {:02}min", hours, minutes % 60);
    if (minutes > 0) return fmt::format("{}min {:02}s", minutes, seconds % 60);
    return fmt::format("{}.{}s", seconds, milliseconds % 1000 / 100);
}

Node management_object(Session& session, int node) {
    return session.object("corbaloc:caniop:" + std::to_string(node) + "/0")
        .unchecked_narrow<Node>();
}

/// All pages of a list. `read(first)` gives a page, `number(entry)` what the list is ordered by.
template <typename Read, typename NumberOf>
auto all_pages(Read read, NumberOf number) {
    using Entry = std::decay_t<decltype(*read(0).begin())>;
    std::vector<Entry> all;
    constexpr std::uint32_t end = 0x10000;
    for (std::uint32_t first = 0; first < end;) {
        const auto page = read(static_cast<std::uint16_t>(first));
        if (page.empty()) break;
        all.insert(all.end(), page.begin(), page.end());
        // A node that does not keep to the order would keep us for ever.
        const std::uint32_t next = number(all.back()) + std::uint32_t{1};
        if (next <= first) throw MARSHAL("the node's list is not in order", Completion::yes);
        first = next;
    }
    return all;
}

struct GroupAtNode {
    int number = 0;
    std::string type_id;
    std::vector<ObjectIndex> objects;
};

std::vector<GroupAtNode> local_groups(const Node& node) {
    const auto entries = all_pages(
        [&](std::uint16_t first) {
            // Beyond the last number of an octet there is no further page.
            if (first > 0xFF) return Node::LocalGroups{};
            return node.local_groups(static_cast<std::uint8_t>(first), Node::GROUPS_PER_PAGE);
        },
        [](const Node::LocalGroup& each) { return each.number; });
    std::vector<GroupAtNode> result;
    for (const Node::LocalGroup& entry : entries) {
        GroupAtNode group{
            entry.number, string_of(entry.type_id), {entry.members.begin(), entry.members.end()}};
        if (group.objects.size() < entry.member_count) {
            group.objects = all_pages(
                [&](std::uint16_t first) {
                    return node.group_members(entry.number, first, Node::MEMBERS_PER_PAGE);
                },
                [](ObjectIndex each) { return each; });
        }
        result.push_back(std::move(group));
    }
    return result;
}

std::string list_of(const std::vector<ObjectIndex>& objects) {
    return fmt::format("{}", fmt::join(objects, ", "));
}

/// Asks all nodes but ourselves at once, each in a thread of its own: they wait at the same time.
/// `ask` may throw; what is no TIMEOUT goes to `failed`. Both are called by one thread at a time.
class AllNodes {
  public:
    AllNodes(Session& session, int own) : session_(session), own_(own) {}

    /// Calls `ask(node, number)` without the lock, and keeps what it returns, by number.
    template <typename Ask>
    auto ask(Ask ask) {
        std::map<int, decltype(ask(Node{}, 0))> answers;
        const auto ask_one = [&](int number) {
            try {
                auto answer = ask(management_object(session_, number), number);
                const std::lock_guard lock{mutex_};
                answers.emplace(number, std::move(answer));
            } catch (const TIMEOUT&) {
                // Nobody is there.
            } catch (const SystemException& exception) {
                const std::lock_guard lock{mutex_};
                failures_.emplace(number, exception.what());
            }
        };
        std::vector<std::jthread> threads;
        for (int number = 0; number <= NodeId::highest; ++number) {
            if (number != own_) threads.emplace_back(ask_one, number);
        }
        threads.clear();
        return answers;
    }

    const std::map<int, std::string>& failures() const { return failures_; }
    /// The calls did not get onto the bus: that nobody answers says nothing.
    bool is_bus_gone() const { return session_.is_bus_gone(); }
    bool is_interrupted() const { return session_.is_closed(); }

  private:
    Session& session_;
    int own_;
    std::mutex mutex_;
    std::map<int, std::string> failures_;
};

struct NodeFacts {
    Node::NodeIdentity identity;
    std::uint64_t uptime_ms = 0;
    Node::ControllerStatus controller;
};

NodeFacts facts_of(const Node& node) {
    return {node.identity(), node.uptime_ms(), node.controller()};
}

Json json_of(const NodeFacts& facts, int number) {
    const Node::NodeIdentity& identity = facts.identity;
    return {{"node", number},
            {"name", string_of(identity.name)},
            {"vendor", string_of(identity.vendor)},
            {"product", string_of(identity.product)},
            {"serial", identity.serial},
            {"software_version", string_of(identity.software_version)},
            {"boot_count", identity.boot_count},
            {"uptime_ms", facts.uptime_ms},
            {"state", state_text(facts.controller.state)},
            {"tec", facts.controller.transmit_errors},
            {"rec", facts.controller.receive_errors}};
}

std::string serial_text(std::uint64_t serial) {
    return serial == 0 ? "-" : fmt::format("{}", serial);
}

/// What was said by some nodes that did not tell what they were asked for.
int finish(const AllNodes& all, bool any, const CommonOptions& common) {
    if (all.is_interrupted()) return interrupted;
    for (const auto& [number, failure] : all.failures()) {
        say("node " + std::to_string(number) + ": " + failure);
        if (all.is_bus_gone()) break;  // all for the same reason
    }
    if (any) return success;
    if (all.failures().empty()) {
        say(fmt::format("no node answered within {} ms (--timeout)",
                        std::chrono::ceil<std::chrono::milliseconds>(common.timeout).count()));
    }
    return all.is_bus_gone() ? bus_unreachable : call_failed;
}

/// Runs `work` with the management object of one node.
int with_node(const CommonOptions& common, int number,
              const std::function<int(const Node&)>& work) {
    if (number == common.node) {
        return fail(fmt::format("{} is the number that this program takes itself: give it another "
                                "one with --node",
                                number),
                    usage_error);
    }
    return Session::run(common,
                        [&](Session& session) { return work(management_object(session, number)); });
}

}  // namespace

int nodes(const CommonOptions& common) {
    return Session::run(common, [&](Session& session) {
        AllNodes all{session, common.node};
        const auto answers = all.ask([](const Node& node, int) { return facts_of(node); });
        if (common.json) {
            Json list = Json::array();
            for (const auto& [number, facts] : answers) list.push_back(json_of(facts, number));
            print(to_text(Json{{"nodes", std::move(list)}}));
            return finish(all, !answers.empty(), common);
        }
        Table table{{"NODE", "NAME", "VENDOR", "PRODUCT", "SERIAL", "VERSION", "UPTIME", "STATE"}};
        for (const auto& [number, facts] : answers) {
            const Node::NodeIdentity& identity = facts.identity;
            table.add({std::to_string(number), plain(identity.name),
                       or_dash(plain(identity.vendor)), or_dash(plain(identity.product)),
                       serial_text(identity.serial), or_dash(plain(identity.software_version)),
                       uptime_text(facts.uptime_ms), state_text(facts.controller.state)});
        }
        if (!answers.empty()) table.print();
        return finish(all, !answers.empty(), common);
    });
}

int show(const CommonOptions& common, int number) {
    return with_node(common, number, [&](const Node& node) {
        const NodeFacts facts = facts_of(node);
        const auto objects = all_pages(
            [&](std::uint16_t first) { return node.active_objects(first, Node::OBJECTS_PER_PAGE); },
            [](const Node::ActiveObject& each) { return each.index; });
        const auto at_groups = local_groups(node);
        if (common.json) {
            Json json = json_of(facts, number);
            json["objects"] = Json::array();
            for (const Node::ActiveObject& each : objects) {
                json["objects"].push_back({{"index", each.index},
                                           {"type_id", string_of(each.type_id)},
                                           {"structural_hash", each.structural_hash}});
            }
            json["groups"] = Json::array();
            for (const GroupAtNode& each : at_groups) {
                json["groups"].push_back(
                    {{"group", each.number}, {"type_id", each.type_id}, {"objects", each.objects}});
            }
            print(to_text(json));
            return success;
        }
        const Node::NodeIdentity& identity = facts.identity;
        print(fmt::format("node        {}", number));
        print("name        " + plain(identity.name));
        print("vendor      " + or_dash(plain(identity.vendor)));
        print("product     " + or_dash(plain(identity.product)));
        print("serial      " + serial_text(identity.serial));
        print("version     " + or_dash(plain(identity.software_version)));
        print("boot count  " +
              (identity.boot_count == 0 ? "-" : std::to_string(identity.boot_count)));
        print("uptime      " + uptime_text(facts.uptime_ms));
        print(fmt::format("controller  {}, TEC {}, REC {}", state_text(facts.controller.state),
                          facts.controller.transmit_errors, facts.controller.receive_errors));
        Table table{{"OBJECT", "INTERFACE", "HASH"}};
        for (const Node::ActiveObject& each : objects) {
            table.add(
                {std::to_string(each.index), or_dash(plain(each.type_id)),
                 each.structural_hash == 0 ? "-" : fmt::format("{:08X}", each.structural_hash)});
        }
        print("");
        table.print();
        if (at_groups.empty()) return success;
        Table group_table{{"GROUP", "OBJECTS", "INTERFACE"}};
        for (const GroupAtNode& each : at_groups) {
            group_table.add(
                {std::to_string(each.number), list_of(each.objects), or_dash(plain(each.type_id))});
        }
        print("");
        group_table.print();
        return success;
    });
}

int groups(const CommonOptions& common) {
    return Session::run(common, [&](Session& session) {
        AllNodes all{session, common.node};
        const auto answers = all.ask([](const Node& node, int) { return local_groups(node); });
        struct AtNode {
            int node;
            GroupAtNode at;
        };
        std::map<int, std::vector<AtNode>> by_group;
        for (const auto& [number, at_node] : answers) {
            for (const GroupAtNode& each : at_node) by_group[each.number].push_back({number, each});
        }
        if (common.json) {
            Json list = Json::array();
            for (const auto& [number, members] : by_group) {
                Json nodes_json = Json::array();
                for (const AtNode& each : members) {
                    nodes_json.push_back({{"node", each.node},
                                          {"objects", each.at.objects},
                                          {"type_id", each.at.type_id}});
                }
                list.push_back({{"group", number}, {"members", std::move(nodes_json)}});
            }
            print(to_text(Json{{"groups", std::move(list)}}));
            return finish(all, !answers.empty(), common);
        }
        Table table{{"GROUP", "NODE", "OBJECTS", "INTERFACE"}};
        for (const auto& [number, members] : by_group) {
            for (const AtNode& each : members) {
                table.add({std::to_string(number), std::to_string(each.node),
                           list_of(each.at.objects), or_dash(plain(each.at.type_id))});
            }
        }
        if (!by_group.empty()) table.print();
        if (!answers.empty() && by_group.empty())
            say(fmt::format("{} nodes answered; none has members of a group", answers.size()));
        return finish(all, !answers.empty(), common);
    });
}

int counters(const CommonOptions& common, int number) {
    return with_node(common, number, [&](const Node& node) {
        const auto all = all_pages(
            [&](std::uint16_t first) { return node.counters(first, Node::COUNTERS_PER_PAGE); },
            [](const Node::NamedCounter& each) { return each.position; });
        if (common.json) {
            Json json = Json::object();
            for (const Node::NamedCounter& each : all) json[string_of(each.name)] = each.value;
            print(to_text(json));
            return success;
        }
        Table table{{"COUNTER", "VALUE"}};
        for (const Node::NamedCounter& each : all) {
            table.add({plain(each.name), std::to_string(each.value)});
        }
        table.print();
        return success;
    });
}

int restart(const CommonOptions& common, int number) {
    return with_node(common, number, [&](const Node& node) {
        try {
            node.restart();
        } catch (const NO_PERMISSION& exception) {
            return fail(fmt::format("node {} does not restart when others ask it to: its "
                                    "application allows that with Orb::on_restart(). {}",
                                    number, exception.what()),
                        call_failed);
        }
        if (common.json) {
            print(Json{{"node", number}, {"restarting", true}}.dump());
        } else {
            print(fmt::format("node {} restarts", number));
        }
        return success;
    });
}

}  // namespace canorb::console
