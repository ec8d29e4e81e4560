// How values print: orb/ccdr/print.hpp.
#include "orb/ccdr/print.hpp"

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "orb/ccdr/any.hpp"

namespace canorb::print_test {

enum class Mode : std::uint8_t { idle = 1, fast = 4 };
BitmaskBits<4> bitmask_bits(const Mode*);

// As generated.
template <OutputStream Stream>
Stream& operator<<(Stream& out, Mode value) {
    return print_flags(out, value, {{Mode::idle, "idle"}, {Mode::fast, "fast"}});
}

struct Status {
    std::uint8_t speed{};
    std::string name;
};
template <OutputStream Stream>
Stream& operator<<(Stream& out, const Status& value) {
    return print_members(out, "speed", value.speed, "name", value.name);
}

struct Empty {};
template <OutputStream Stream>
Stream& operator<<(Stream& out, const Empty&) {
    return print_members(out);
}

namespace {

template <typename T>
std::string printed(const T& value) {
    std::ostringstream out;
    print(out, value);
    return out.str();
}

TEST(Print, BasicTypes) {
    EXPECT_EQ(printed(true), "true");
    EXPECT_EQ(printed('A'), "'A'");
    EXPECT_EQ(printed('\''), "'\\''");
    EXPECT_EQ(printed('\0'), "'\\x00'");
    EXPECT_EQ(printed(u'A'), "'A'");
    EXPECT_EQ(printed(u'\u20AC'), "'\\u20AC'");
    EXPECT_EQ(printed(std::uint8_t{65}), "65");
    EXPECT_EQ(printed(std::int8_t{-65}), "-65");
    EXPECT_EQ(printed(std::int64_t{-1}), "-1");
    EXPECT_EQ(printed(1.5), "1.5");
    EXPECT_EQ(printed(1.5L), "1.5");
    EXPECT_EQ((printed(Fixed<4, 2>{"-1.5"})), "-1.50");
}

TEST(Print, Texts) {
    EXPECT_EQ(printed(std::string{"a \"b\" \\ \n \x1F\xE4"}), R"("a \"b\" \\ \n \x1F\xE4")");
    EXPECT_EQ(printed(BoundedString<4>{"ab"}), "\"ab\"");
    EXPECT_EQ(printed(std::u16string{u"a\u00E4"}), R"("a\u00E4")");
}

TEST(Print, SequencesArraysAndMaps) {
    EXPECT_EQ(printed(std::vector<std::string>{"a", "b"}), R"(["a", "b"])");
    EXPECT_EQ(printed(std::vector<bool>{true, false}), "[true, false]");
    EXPECT_EQ(printed(std::vector<int>{}), "[]");
    EXPECT_EQ((printed(std::array<std::array<std::uint8_t, 2>, 2>{{{1, 2}, {3, 4}}})),
              "[[1, 2], [3, 4]]");
    EXPECT_EQ((printed(BoundedVector<char, 3>{'a', 'b'})), "['a', 'b']");
    EXPECT_EQ((printed(std::map<std::string, std::vector<int>>{{"a", {1}}, {"b", {}}})),
              R"({"a": [1], "b": []})");
}

TEST(Print, GeneratedTypes) {
    EXPECT_EQ(printed(Status{.speed = 3, .name = "left"}), R"({speed: 3, name: "left"})");
    EXPECT_EQ(printed(std::vector<Empty>(2)), "[{}, {}]");
    EXPECT_EQ(printed(static_cast<Mode>(0)), "0");
    EXPECT_EQ(printed(static_cast<Mode>(5)), "idle|fast");
    EXPECT_EQ(printed(static_cast<Mode>(12)), "fast|8");
    EXPECT_EQ(printed(static_cast<Mode>(8)), "8");
    std::ostringstream out;
    out << "now " << Status{} << ' ' << Mode::idle;
    EXPECT_EQ(out.str(), R"(now {speed: 0, name: ""} idle)");
}

TEST(Print, Pointers) {
    EXPECT_EQ(printed(std::shared_ptr<int>{}), "nil");
    EXPECT_EQ(printed(std::make_shared<int>(3)), "3");
}

TEST(Print, AnyAndTypeCode) {
    Any any;
    EXPECT_EQ(printed(any), "any(kind 0: )");
    any <<= std::uint16_t{128};
    EXPECT_EQ(printed(any), "any(kind 4: 8080)");
    EXPECT_EQ(printed(type_code<std::vector<bool>>()), "typecode 130800");
}

}  // namespace
}  // namespace canorb::print_test
