#include "idlc/emit/text.hpp"

#include <gtest/gtest.h>

namespace canorb::idlc::emit {
namespace {

TEST(FillTest, PutsValuesInTheirPlaces) {
    EXPECT_EQ(fill("$a$ and $b$", {{"a", "one"}, {"b", "$a$"}}), "one and $a$");
}

TEST(FillTest, KeepsTheIndentationOfThePlace) {
    EXPECT_EQ(fill("{\n    $lines$\n}\n", {{"lines", "a;\nb;\n"}}), "{\n    a;\n    b;\n}\n");
}

TEST(FillTest, LeavesOutLinesOfNothing) {
    EXPECT_EQ(fill("a\n$nothing$\n\nb\n", {{"nothing", ""}}), "a\n\nb\n");
}

TEST(FillTest, DropsTheFirstLineEnd) {
    EXPECT_EQ(fill("\na\n", {}), "a\n");
}

TEST(TextTest, Joins) {
    EXPECT_EQ(join({}, ", "), "");
    EXPECT_EQ(join({"a", "b"}, ", "), "a, b");
}

TEST(TextTest, Indents) {
    EXPECT_EQ(indent("a\n\nb\n"), "    a\n\n    b\n");
}

TEST(TextTest, PutsLongRemarksAbove) {
    EXPECT_EQ(remarked("f();", "why"), "f();  // why\n");
    const std::string wide(90, 'x');
    EXPECT_EQ(remarked(wide, "a remark"), "// a remark\n" + wide + '\n');
}

}  // namespace
}  // namespace canorb::idlc::emit
