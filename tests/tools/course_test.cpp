// The course in doc/bus.md prints what it says that it prints.

#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "tests/support/shell.hpp"

namespace canorb::test {
namespace {

struct Example {
    std::string command;
    std::string output;
};

/// The console blocks of the page: a line with a "$ " is a command, what follows is its output.
std::vector<Example> examples(const std::string& path) {
    std::ifstream page{path};
    std::vector<Example> examples;
    bool in_block = false;
    for (std::string line; std::getline(page, line);) {
        if (line.starts_with("```")) {
            in_block = line == "```console";
        } else if (in_block && line.starts_with("$ ")) {
            examples.push_back({line.substr(2), ""});
        } else if (in_block && !examples.empty()) {
            examples.back().output += line + '\n';
        }
    }
    return examples;
}

TEST(Course, PrintsWhatItSays) {
    const std::vector<Example> course = examples(CANORB_SOURCE "/doc/bus.md");
    EXPECT_GE(course.size(), 9U);
    for (const Example& example : course) {
        const ShellResult result =
            shell("cd '" CANORB_SOURCE "' && PATH='" CANORB_PROGRAMS "':$PATH && (" +
                  example.command + ") 2>&1");
        EXPECT_EQ(result.output.substr(0, result.output.find_last_not_of('\n') + 1) + '\n',
                  example.output)
            << example.command;
        EXPECT_EQ(result.exit_code, 0) << example.command;
    }
}

}  // namespace
}  // namespace canorb::test
