// canorb: the console. Asks nodes who they are, calls objects, and listens to groups.

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <functional>
#include <string>
#include <vector>

#include "canorb/bus.hpp"
#include "canorb/exceptions.hpp"
#include "tools/console/commands.hpp"
#include "tools/scenario.hpp"

namespace {

using namespace canorb;
using namespace canorb::console;

/// What cannot be asked; a sentence for people.
struct UsageError {
    std::string reason;
};

Duration parse_time(const std::string& option, const std::string& text) {
    const auto time = tools::parse_duration(text);
    if (time && *time > Duration::zero()) return *time;
    throw UsageError{option + " takes a time such as 200ms or 1.5s, not " + text};
}

/// What the user said, as text, before it is checked.
struct Arguments {
    std::string bus = default_bus_address();
    std::string node = std::to_string(console_node);
    std::string timeout;
    bool json = false;
    IdlFiles idl;
    std::string target;
    std::string interface;
    std::uint64_t count = 0;
    std::string seconds;

    CommonOptions common() const {
        return {bus, parse_node_id(node), parse_time("--timeout", timeout), json};
    }
};

class CommandLine {
  public:
    CommandLine() {
        app_.set_version_flag("--version", std::string{"canorb "} + CANORB_VERSION);
        app_.require_subcommand(1);
        app_.footer(
            "Options stand behind the command: canorb nodes --bus socketcan:can0\n"
            "canorb COMMAND --help tells more. Exit codes: 0 all went well; 1 an exception, or\n"
            "nobody answered; 2 what was asked for cannot be asked; 3 there is no bus; 130 "
            "Ctrl-C.");
        add_node_commands();
        add_call();
        add_watch();
    }

    int run(int argc, char** argv) {
        try {
            app_.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            return app_.exit(error) == 0 ? success : usage_error;
        }
        try {
            return command_();
        } catch (const UsageError& error) {
            return fail(error.reason, usage_error);
        } catch (const SystemException& exception) {
            return fail(exception.what(), usage_error);  // a node's number that is none
        }
    }

  private:
    CLI::App* add(const std::string& name, const std::string& description,
                  const std::string& timeout, const std::string& footer) {
        CLI::App* const command = app_.add_subcommand(name, description);
        command
            ->add_option("--bus", arguments_.bus, "address of the bus (CANORB_BUS; doc/links.md)")
            ->capture_default_str();
        command->add_flag("--json", arguments_.json, "print JSON, for scripts");
        command->footer(footer);
        if (timeout.empty()) {
            command->preparse_callback([this](std::size_t) { arguments_.timeout = "1s"; });
            return command;
        }
        // Each command has its own default: known when it is chosen.
        command->preparse_callback([this, timeout](std::size_t) { arguments_.timeout = timeout; });
        command
            ->add_option("--node", arguments_.node,
                         "number that this program takes on the bus, 0 to 30")
            ->envname("CANORB_NODE")
            ->capture_default_str();
        command->add_option("--timeout", arguments_.timeout,
                            "how long to wait for each answer, " + timeout + " where not said");
        return command;
    }

    void add_idl_options(CLI::App& command) {
        command.add_option("--idl", arguments_.idl.idl, "IDL file, compiled with canorb-idlc")
            ->allow_extra_args(false);
        command
            .add_option("-I", arguments_.idl.directories, "where IDL files find what they include")
            ->allow_extra_args(false);
        command.add_option("--idl-json", arguments_.idl.json, "what canorb-idlc --emit json wrote")
            ->allow_extra_args(false);
    }

    void on_nodes(const std::string& name, const std::string& description,
                  const std::string& timeout, int (*command)(const CommonOptions&)) {
        add(name, description, timeout, "")->callback([this, command] {
            command_ = [this, command] { return command(arguments_.common()); };
        });
    }

    void on_node(const std::string& name, const std::string& description,
                 int (*command)(const CommonOptions&, int)) {
        CLI::App* const added = add(name, description, "1s", "");
        added->add_option("NODE", arguments_.target, "number of the node, 0 to 30")->required();
        added->callback([this, command] {
            command_ = [this, command] {
                return command(arguments_.common(), parse_node_id(arguments_.target));
            };
        });
    }

    void add_node_commands() {
        on_nodes("nodes", "list the nodes that answer", "500ms", nodes);
        on_node("show", "tell all that a node says of itself", show);
        on_nodes("groups", "list the groups and their members", "500ms", groups);
        on_node("counters", "print the counters of a node (doc/events-and-counters.md)", counters);
        on_node("restart", "ask a node to restart", restart);
    }

    void add_call() {
        CLI::App* const command = add(
            "call", "call an operation: call [OPTIONS] REF OPERATION ARGS...", "1s",
            "REF is CAN_IOR:..., corbaloc:caniop:NODE/INDEX or corbaloc:caniop:group/GROUP. All\n"
            "that stands behind it is taken as it is. An attribute is read by its name, and set "
            "by\n"
            "its name and a value. doc/console.md tells how values are written.\n\n"
            "Examples:\n"
            "  canorb call corbaloc:caniop:3/0 identity\n"
            "  canorb call --idl devices.idl corbaloc:caniop:3/1 speed 1\n"
            "  canorb call --idl devices.idl corbaloc:caniop:3/1 adjust "
            "'{\"speed\": 70, \"mode\": \"fast\"}'\n"
            "  canorb call --idl devices.idl --interface Devices::Motor "
            "corbaloc:caniop:group/5 stop");
        add_idl_options(*command);
        command->add_option("--interface", arguments_.interface,
                            "the interface to call, by name or repository id, where the reference "
                            "does not say it or says another");
        // So that -5 is an argument.
        command->prefix_command();
        command->callback([this, command] {
            const std::vector<std::string> words = command->remaining();
            command_ = [this, words] { return run_call(words); };
        });
    }

    int run_call(const std::vector<std::string>& words) {
        if (words.size() < 2 || words.front().starts_with('-')) {
            throw UsageError{words.empty() || !words.front().starts_with('-')
                                 ? "call needs a REF and an OPERATION: canorb call --help"
                                 : "call has no option " + words.front()};
        }
        CallOptions options{arguments_.idl,
                            words[0],
                            words[1],
                            {words.begin() + 2, words.end()},
                            arguments_.interface};
        return call(arguments_.common(), options);
    }

    void add_watch() {
        CLI::App* const command =
            add("watch", "print every message to a group, until Ctrl-C", "",
                "It takes no number on the bus and sends nothing.\n\nExample:\n"
                "  canorb watch --idl devices.idl --count 10 5");
        add_idl_options(*command);
        command->add_option("GROUP", arguments_.target, "number of the group, 1 to 31")->required();
        command->add_option("--count", arguments_.count, "end after so many messages")
            ->check(CLI::Range(std::uint64_t{1}, ~std::uint64_t{0}).description(""));
        command->add_option("--seconds", arguments_.seconds,
                            "end after this time: 10, or such as 500ms");
        command->callback([this] { command_ = [this] { return run_watch(); }; });
    }

    int run_watch() {
        WatchOptions options;
        options.idl = arguments_.idl;
        // Digits only, and a value in range.
        const std::string& text = arguments_.target;
        const bool is_number = text.find_first_not_of("0123456789") == std::string::npos &&
                               text.size() <= 2 && !text.empty();
        const auto group = is_number ? GroupId::from(std::stoi(text)) : std::nullopt;
        if (!group) throw UsageError{"'" + text + "' is no group: a number from 1 to 31 is"};
        options.group = *group;
        options.count = arguments_.count;
        if (!arguments_.seconds.empty()) {
            const bool has_unit = arguments_.seconds.find('s') != std::string::npos;
            options.duration = parse_time("--seconds", arguments_.seconds + (has_unit ? "" : "s"));
        }
        return watch(arguments_.common(), options);
    }

    CLI::App app_{
        "Looks after the nodes of a canorb bus: who is there, what is in which group, what it "
        "counts; calls any operation, and shows what groups are told.",
        "canorb"};
    Arguments arguments_;
    std::function<int()> command_;
};

}  // namespace

int main(int argc, char** argv) {
    // Whoever reads the output may go: then this program ends, too, but as if it had written all.
    std::signal(SIGPIPE, SIG_IGN);
    return CommandLine{}.run(argc, argv);
}
