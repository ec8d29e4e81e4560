#include "idlc/source.hpp"

#include <gtest/gtest.h>

#include <string>

namespace canorb::idlc {
namespace {

Location find(const Source& source, std::string_view text) {
    return {static_cast<std::uint32_t>(source.text().find(text))};
}

TEST(SourceTest, CountsLinesAndColumnsFromOne) {
    const Source source{"a.idl", "first\n  second\n"};
    const Position position = source.position(find(source, "second"));
    EXPECT_EQ(position.file, "a.idl");
    EXPECT_EQ(position.line, 2U);
    EXPECT_EQ(position.column, 3U);
    EXPECT_EQ(position.source_line, "  second");
}

TEST(SourceTest, FollowsLinemarkers) {
    const Source source{"a.idl",
                        "# 1 \"a.idl\"\n"
                        "#include \"dir/b.idl\"\n"
                        "# 1 \"./dir/b.idl\" 1\n"
                        "in_b\n"
                        "#include \"c.idl\"\n"
                        "# 1 \"./dir/c.idl\" 1\n"
                        "in_c\n"
                        "# 2 \"./dir/b.idl\" 2\n"
                        "# 2 \"a.idl\" 2\n"
                        "\n"
                        "in_a\n"
                        "#line 70 \"a.idl\"\n"
                        "later\n"};
    EXPECT_EQ(source.position(find(source, "in_b")).file, "./dir/b.idl");
    EXPECT_EQ(source.position(find(source, "in_b")).line, 1U);
    EXPECT_FALSE(source.in_main_file(find(source, "in_c")));
    EXPECT_TRUE(source.in_main_file(find(source, "in_a")));
    EXPECT_EQ(source.position(find(source, "in_a")).line, 3U);
    EXPECT_EQ(source.position(find(source, "later")).line, 70U);
    EXPECT_EQ(source.includes(), std::vector<std::string>{"dir/b.idl"});
    EXPECT_EQ(source.files(), (std::vector<std::string>{"a.idl", "./dir/b.idl", "./dir/c.idl"}));
}

TEST(SourceTest, KnowsWhoIncludedAFile) {
    const Source source{"a.idl",
                        "# 1 \"a.idl\"\n"
                        "\n"
                        "#include \"b.idl\"\n"
                        "# 1 \"b.idl\" 1\n"
                        "in_b\n"
                        "#include <c.idl>\n"
                        "# 1 \"c.idl\" 1\n"
                        "in_c\n"
                        "# 3 \"b.idl\" 2\n"
                        "b_again\n"
                        "# 3 \"a.idl\" 2\n"
                        "in_a\n"};
    const auto in_b = source.included_from(find(source, "in_c"));
    ASSERT_TRUE(in_b.has_value());
    EXPECT_EQ(source.file(*in_b), "b.idl");
    EXPECT_EQ(source.line(*in_b), 2U);
    const auto in_a = source.included_from(*in_b);
    ASSERT_TRUE(in_a.has_value());
    EXPECT_EQ(source.file(*in_a), "a.idl");
    EXPECT_EQ(source.line(*in_a), 2U);
    EXPECT_FALSE(source.included_from(*in_a).has_value());
    EXPECT_EQ(source.included_from(find(source, "b_again")), in_a);
    EXPECT_FALSE(source.included_from(find(source, "in_a")).has_value());
}

TEST(SourceTest, DoesNotListWhatTheCompilerItselfBrings) {
    const Source source{"a.idl",
                        "# 1 \"a.idl\"\n"
                        "#include <orb.idl>\n"
                        "# 1 \"<orb.idl>\" 1\n"
                        "# 2 \"a.idl\" 2\n"
                        "#include <b.idl>\n"
                        "# 1 \"b.idl\" 1\n"
                        "# 3 \"a.idl\" 2\n"};
    EXPECT_EQ(source.includes(), std::vector<std::string>{"b.idl"});
}

TEST(SourceTest, LeavesCommentsAlone) {
    const Source source{"a.idl", "/* text\n# 7 \"b.idl\"\n*/ here // \"\n# 9 \"a.idl\"\nthere\n"};
    EXPECT_EQ(source.position(find(source, "here")).line, 3U);
    EXPECT_EQ(source.position(find(source, "there")).line, 9U);
    EXPECT_EQ(source.files().size(), 1U);
}

TEST(SourceTest, ShowsTheColumnBeforeThePreprocessorFoldedIt) {
    Source source{"a.idl", " typedef sequence<long, 10> x;\n"};
    source.add_original("a.idl", "\ttypedef   sequence<long,   MAX>  x;\n");
    const Position element = source.position(find(source, "long"));
    EXPECT_EQ(element.column, 21U);
    EXPECT_EQ(element.source_line, "\ttypedef   sequence<long,   MAX>  x;");
    // Behind a macro the folded column is all there is.
    EXPECT_EQ(source.position(find(source, "x;")).column, 29U);
}

TEST(SourceTest, CountsNoByteOrderMark) {
    Source source{"a.idl", "typedef long x;\n"};
    source.add_original("a.idl", "\xEF\xBB\xBFtypedef long  x;\n");
    EXPECT_EQ(source.position(find(source, "x;")).column, 15U);
    EXPECT_EQ(source.position(find(source, "x;")).source_line, "typedef long  x;");
}

TEST(SourceTest, HasAPositionForTheEnd) {
    const Source empty{"a.idl", ""};
    EXPECT_EQ(empty.position({0}).line, 1U);
    EXPECT_EQ(empty.position({0}).column, 1U);
    const Source source{"a.idl", "x\n"};
    EXPECT_EQ(source.position({2}).line, 2U);
}

}  // namespace
}  // namespace canorb::idlc
