#include "tests/layering/include_rules.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace canorb::layering {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

struct Sample {
    const char* name;
    const char* path;
    const char* text;
};

std::string name_of(const testing::TestParamInfo<Sample>& info) {
    return info.param.name;
}
void PrintTo(const Sample& sample, std::ostream* out) {
    *out << sample.path << ": " << sample.text;
}

class Forbidden : public testing::TestWithParam<Sample> {};

TEST_P(Forbidden, IsReported) {
    EXPECT_EQ(violations(GetParam().path, GetParam().text).size(), 1U);
}

INSTANTIATE_TEST_SUITE_P(
    Samples, Forbidden,
    testing::Values(
        Sample{"base_includes_nothing", "orb/base/x.hpp", "#include \"orb/ccdr/encoder.hpp\""},
        Sample{"giop_not_can", "orb/giop/x.cpp", "#include \"orb/can/frame.hpp\""},
        Sample{"giop_not_caniop", "orb/giop/x.cpp", "#include \"orb/caniop/segmenter.hpp\""},
        Sample{"caniop_not_giop", "orb/caniop/x.cpp", "#include \"orb/giop/format.hpp\""},
        Sample{"caniop_not_ccdr", "orb/caniop/x.cpp", "#include \"orb/ccdr/decoder.hpp\""},
        Sample{"can_not_its_simulation", "orb/can/x.cpp", "#include \"orb/can/sim/bus.hpp\""},
        Sample{"simulation_not_links", "orb/can/sim/x.cpp", "#include \"orb/can/link/socket.hpp\""},
        Sample{"records_not_links", "orb/can/record/x.cpp", "#include \"orb/can/link/link.hpp\""},
        Sample{"simulation_not_records", "orb/can/sim/x.cpp",
               "#include \"orb/can/record/vcd_writer.hpp\""},
        Sample{"poa_not_core", "orb/poa/x.hpp", "#include \"orb/core/engine.hpp\""},
        Sample{"poa_not_mca", "orb/poa/x.hpp", "#include \"orb/mca/agent.hpp\""},
        Sample{"core_not_runtime", "orb/core/x.cpp", "#include \"orb/runtime/loop.hpp\""},
        Sample{"core_not_public_headers", "orb/core/x.cpp", "#include <canorb/orb.hpp>"},
        Sample{"core_not_simulation", "orb/core/x.cpp", "#include \"orb/can/sim/bus.hpp\""},
        Sample{"runtime_not_services", "orb/runtime/x.cpp",
               "#include \"orb/services/node_object.hpp\""},
        Sample{"runtime_not_hosted", "orb/runtime/x.cpp", "#include \"orb/hosted/x.hpp\""},
        Sample{"services_not_hosted", "orb/services/x.cpp", "#include \"orb/hosted/x.hpp\""},
        Sample{"services_not_links", "orb/services/x.cpp", "#include \"orb/can/link/link.hpp\""},
        Sample{"idlc_not_orb", "idlc/emit/x.cpp", "#include \"orb/base/ids.hpp\""},
        Sample{"idlc_not_public_headers", "idlc/x.cpp", "#include <canorb/types.hpp>"},
        Sample{"examples_not_orb", "examples/tank/x.cpp", "#include \"orb/base/ids.hpp\""},
        Sample{"examples_not_unknown_orb", "examples/x.cpp", "#include \"orb/later/ids.hpp\""},
        Sample{"orb_not_tests", "orb/core/x.cpp", "#include \"tests/support/octets.hpp\""},
        Sample{"relative_path", "orb/giop/x.cpp", "#include \"../base/ids.hpp\""},
        Sample{"blanks_around", "orb/giop/x.cpp", "  #  include  \"orb/can/frame.hpp\"  // why"},
        Sample{"no_thread", "orb/core/x.hpp", "#include <thread>"},
        Sample{"no_socket", "orb/can/x.cpp", "#include <sys/socket.h>"},
        Sample{"no_output", "orb/base/x.cpp", "#include <iostream>"},
        Sample{"no_clock", "orb/core/x.cpp", "auto t = std::chrono::steady_clock::now();"},
        Sample{"no_sleep", "orb/can/sim/x.cpp", "std::this_thread::sleep_for(1ms);"},
        Sample{"code_after_a_comment", "orb/core/x.cpp", "/* now */ auto t = Clock::now();"}),
    name_of);

class Allowed : public testing::TestWithParam<Sample> {};

TEST_P(Allowed, IsNotReported) {
    EXPECT_THAT(violations(GetParam().path, GetParam().text), IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(
    Samples, Allowed,
    testing::Values(
        Sample{"its_own_folder", "orb/giop/x.cpp", "#include \"orb/giop/format.hpp\""},
        Sample{"a_lower_layer", "orb/mca/x.cpp", "#include \"orb/ccdr/encoder.hpp\""},
        Sample{"core_joins_both", "orb/core/x.cpp",
               "#include \"orb/giop/format.hpp\"\n#include \"orb/caniop/segmenter.hpp\""},
        Sample{"runtime_and_links", "orb/runtime/x.cpp",
               "#include <thread>\n#include \"orb/can/link/open.hpp\"\n#include <canorb/orb.hpp>"},
        Sample{"services_use_the_runtime", "orb/services/x.hpp",
               "#include <canorb/node.hpp>\n#include \"orb/runtime/orb_impl.hpp\""},
        Sample{"hosted_joins_all", "orb/hosted/x.cpp",
               "#include \"orb/services/node_object.hpp\"\n#include \"orb/runtime/orb_impl.hpp\""},
        Sample{"links_call_the_system", "orb/can/link/x.cpp",
               "#include <sys/socket.h>\nauto t = std::chrono::steady_clock::now();"},
        Sample{"examples_public_and_generated", "examples/tank/x.cpp",
               "#include <canorb/orb.hpp>\n#include \"tank.hpp\"\n#include <iostream>"},
        Sample{"comments_do_not_count", "orb/core/x.cpp",
               "// #include <thread>\n/* a\n#include <mutex>\n*/ int x;  // Clock::now()"},
        Sample{"tests_are_free", "tests/x.cpp", "#include \"orb/core/engine.hpp\""}),
    name_of);

TEST(Violation, NamesFileLineAndRule) {
    EXPECT_THAT(violations("orb/giop/x.cpp", "\n#include \"orb/can/frame.hpp\"\n"),
                ElementsAre("orb/giop/x.cpp:2: orb/giop may not include orb/can/frame.hpp"));
}

TEST(SourceTree, KeepsItsLayers) {
    const std::filesystem::path top = CANORB_SOURCE_DIR;
    std::vector<std::string> found;
    std::size_t files = 0;
    for (const char* folder : {"orb", "idlc", "tools", "examples"}) {
        for (const auto& entry : std::filesystem::recursive_directory_iterator(top / folder)) {
            const auto extension = entry.path().extension();
            if (extension != ".hpp" && extension != ".cpp") continue;
            std::ifstream file(entry.path());
            const std::string text{std::istreambuf_iterator<char>(file), {}};
            const auto path = entry.path().lexically_relative(top).generic_string();
            const auto more = violations(path, text);
            found.insert(found.end(), more.begin(), more.end());
            ++files;
        }
    }
    EXPECT_THAT(found, IsEmpty());
    EXPECT_GT(files, 10U);
}

}  // namespace
}  // namespace canorb::layering
