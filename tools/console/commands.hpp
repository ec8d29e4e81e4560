#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "orb/base/ids.hpp"
#include "orb/base/time.hpp"
#include "tools/console/idl_files.hpp"

namespace canorb::console {

/// Exit codes, for scripts; doc/console.md.
inline constexpr int success = 0;
inline constexpr int call_failed = 1;      ///< an exception, or nobody answered
inline constexpr int usage_error = 2;      ///< what was asked for cannot be asked
inline constexpr int bus_unreachable = 3;  ///< there is no bus, or it went away
inline constexpr int interrupted = 130;    ///< Ctrl-C

/// Node numbers are given away from below: the highest is least likely to be another's.
inline constexpr int console_node = NodeId::highest;

/// What all commands take.
struct CommonOptions {
    std::string bus;
    int node = console_node;
    Duration timeout{};
    bool json = false;
};

struct CallOptions {
    IdlFiles idl;
    std::string reference;
    std::string operation;
    std::vector<std::string> arguments;
    std::string interface;  ///< a scoped name or repository id; empty: the reference's
};

struct WatchOptions {
    IdlFiles idl;
    GroupId group{1};
    std::uint64_t count = 0;  ///< messages after which it ends; 0: no limit
    std::optional<Duration> duration;
};

// Each returns the exit code.
int nodes(const CommonOptions& common);
int show(const CommonOptions& common, int number);
int groups(const CommonOptions& common);
int counters(const CommonOptions& common, int number);
int restart(const CommonOptions& common, int number);
int call(const CommonOptions& common, const CallOptions& options);
int watch(const CommonOptions& common, const WatchOptions& options);

/// On standard error, one line.
void say(std::string_view sentence);
/// The same, and gives the exit code.
int fail(std::string_view sentence, int exit_code);
/// A line on standard output, seen at once.
void print(std::string_view line);

}  // namespace canorb::console
