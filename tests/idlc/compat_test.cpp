// Each file of compat/ has an old version, a new one and what is said of them. They are called
// after the rule that they show.

#include "idlc/compat.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>

#include "tests/idlc/support.hpp"

namespace canorb::idlc::test {
namespace {

struct Case {
    std::string old_text;
    std::string new_text;
    std::string findings;
};

constexpr std::string_view new_mark = "=== new\n";
constexpr std::string_view findings_mark = "=== findings\n";

Case read_case(const std::string& name) {
    const std::string text = read_file(data_directory / "compat" / (name + ".txt"));
    const std::size_t new_begin = text.find(new_mark);
    const std::size_t findings_begin = text.find(findings_mark);
    EXPECT_LT(new_begin, findings_begin) << name;
    EXPECT_NE(findings_begin, std::string::npos) << name;
    Case result;
    result.old_text = text.substr(0, new_begin);
    result.new_text =
        text.substr(new_begin + new_mark.size(), findings_begin - new_begin - new_mark.size());
    result.findings = text.substr(findings_begin + findings_mark.size());
    return result;
}

struct Version {
    Version(const std::string& name, const std::string& text) : source(name, text) {
        model = compile(source, diagnostics);
        EXPECT_EQ(format(diagnostics, source), "");
    }

    Source source;
    Diagnostics diagnostics;
    model::Model model;
};

std::vector<compat::Finding> compare(const std::string& old_text, const std::string& new_text) {
    const Version old_version{"old.idl", old_text};
    const Version new_version{"new.idl", new_text};
    return compat::compare(old_version.model, new_version.model);
}

std::vector<std::string> cases() {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator{data_directory / "compat"}) {
        names.push_back(entry.path().stem());
    }
    std::sort(names.begin(), names.end());
    return names;
}

class CompatTest : public testing::TestWithParam<std::string> {};

TEST_P(CompatTest, SaysWhatIsExpected) {
    const Case each = read_case(GetParam());
    const std::string findings = compat::format(compare(each.old_text, each.new_text));
    if (updating()) {
        std::ofstream{data_directory / "compat" / (GetParam() + ".txt"), std::ios::binary}
            << each.old_text << new_mark << each.new_text << findings_mark << findings;
    }
    EXPECT_EQ(findings, read_case(GetParam()).findings);
}

TEST_P(CompatTest, SaysNothingOfTwiceTheSame) {
    const Case each = read_case(GetParam());
    EXPECT_EQ(compat::format(compare(each.old_text, each.old_text)),
              "nothing differs on the wire\n");
    EXPECT_EQ(compat::format(compare(each.new_text, each.new_text)),
              "nothing differs on the wire\n");
}

std::string name_of(const testing::TestParamInfo<std::string>& info) {
    std::string name = info.param;
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
}

INSTANTIATE_TEST_SUITE_P(Idl, CompatTest, testing::ValuesIn(cases()), name_of);

TEST(CompatRulesTest, AllHaveAFile) {
    for (const compat::Rule& rule : compat::rules()) {
        const Case each = read_case(std::string{rule.name});
        EXPECT_NE(each.findings.find('[' + std::string{rule.name} + "]\n"), std::string::npos)
            << rule.name;
    }
}

TEST(CompatRulesTest, AllAreDocumented) {
    const std::string page =
        read_file(data_directory.parent_path().parent_path() / "doc" / "evolution.md");
    static constexpr std::string_view severities[] = {"breaks", "careful", "safe"};
    for (const compat::Rule& rule : compat::rules()) {
        const std::string row = "| `" + std::string{rule.name} + "` | " +
                                std::string{severities[static_cast<std::size_t>(rule.severity)]} +
                                " |";
        EXPECT_NE(page.find(row), std::string::npos) << row;
    }
}

TEST(CompatRulesTest, OnlyWhatBreaksMakesTheExitCode) {
    EXPECT_FALSE(compat::any_breaks({}));
    EXPECT_FALSE(
        compat::any_breaks(compare("interface A { void f(); };", "interface A { void g(); };")));
    EXPECT_TRUE(
        compat::any_breaks(compare("interface A { void f(); };", "interface A { long f(); };")));
}

TEST(CompatTypesTest, RecursiveTypesEnd) {
    const std::string old_text =
        "struct Node; typedef sequence<Node> Nodes; struct Node { Nodes children; };"
        "interface A { void f(in Node root); };";
    const std::string new_text =
        "struct Tree; typedef sequence<Tree> Trees; struct Tree { Trees children; };"
        "interface A { void f(in Tree root); };";
    const auto findings = compare(old_text, new_text);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].rule, "type-replaced");
}

}  // namespace
}  // namespace canorb::idlc::test
