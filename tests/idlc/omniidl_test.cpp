// What omniidl, another compiler of IDL, says of the files that this one accepts and refuses. A
// file that the two judge differently says why in a comment that begins with "omniidl:".

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/idlc/support.hpp"

namespace canorb::idlc::test {
namespace {

bool succeeds(const std::string& command) {
    return std::system((command + " >/dev/null 2>&1").c_str()) == 0;
}

bool omniidl_accepts(const std::string& files) {
    return succeeds("omniidl -bdump " + files);
}

/// The folder's files that omniidl is expected to accept, or those that it is not.
std::vector<std::string> files_of(const std::string& folder, bool accepted_there) {
    std::vector<std::string> files;
    for (const std::string& stem : idl_files(folder)) {
        const std::string file = stem + ".idl";
        const bool accepted_here = folder == "accepted";
        const bool differs = read_file(file).find("// omniidl:") != std::string::npos;
        if ((accepted_here != differs) == accepted_there) files.push_back(file);
    }
    return files;
}

class OmniidlTest : public testing::Test {
  protected:
    void SetUp() override {
        if (!succeeds("omniidl -V")) GTEST_SKIP() << "omniidl is not installed";
    }
};

TEST_F(OmniidlTest, JudgesFilesAsThisCompilerDoesOrAsTheySay) {
    std::string surprises;
    for (const std::string folder : {"accepted", "errors"}) {
        std::filesystem::current_path(data_directory / folder);
        const auto accepted = files_of(folder, true);
        // All at once takes a tenth of the time.
        std::string all;
        for (const std::string& file : accepted) all += ' ' + file;
        if (!omniidl_accepts(all)) {
            for (const std::string& file : accepted) {
                if (!omniidl_accepts(file)) surprises += folder + '/' + file + " is refused\n";
            }
        }
        for (const std::string& file : files_of(folder, false)) {
            if (omniidl_accepts(file)) surprises += folder + '/' + file + " is accepted\n";
        }
    }
    EXPECT_EQ(surprises, "");
}

}  // namespace
}  // namespace canorb::idlc::test
