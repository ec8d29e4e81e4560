// main() of a program that prints one JSON object.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "child_process.hpp"

namespace peers {

/// What is asked for cannot be measured on this machine, and that is nobody's mistake.
class Skipped : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

inline int report(const std::string& program, int status, const std::string& message) {
    std::fprintf(stderr, "%s: %s\n", program.c_str(), message.c_str());
    return status;
}

/// The status to end with. An exception that is neither of these is left to the caller.
template <typename Run>
int run_program(CLI::App& app, int argc, char** argv, Run run) {
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    const std::string name = app.get_name();
    try {
        const nlohmann::ordered_json result = run();
        if (!result.is_null()) std::printf("%s\n", result.dump(2).c_str());
        return 0;
    } catch (const Skipped& skipped) {
        std::fprintf(stderr, "SKIPPED: %s\n", skipped.what());
        return 77;
    } catch (const Interrupted& stopped) {
        return report(name, 130, stopped.what());
    } catch (const std::exception& error) {
        return report(name, 1, error.what());
    }
}

}  // namespace peers
