#include "idlc/emit/json.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tests/idlc/support.hpp"

namespace canorb::idlc::test {
namespace {

std::string json_of(const std::string& text) {
    const TextCompilation compilation{text};
    EXPECT_EQ(compilation.messages(), "");
    return emit::json(compilation.model);
}

TEST(JsonTest, AnInterface) {
    EXPECT_EQ(json_of(R"(exception Broken { string why; };
/// An electric motor.
interface Motor {
  oneway void stop();
  attribute long ramp;
  float sample(in string<8> name, out Motor leader) raises (Broken);
};
)"),
              R"({
  "format": "canorb-idl",
  "format_version": 1,
  "main_file": "test.idl",
  "interfaces": [
    {
      "name": "Motor",
      "repository_id": "IDL:Motor:1.0",
      "kind": "plain",
      "defined": true,
      "structural_hash": 1669764604,
      "group_key": 5235,
      "bases": [],
      "operations": [
        {
          "id": 0,
          "name": "stop",
          "kind": "operation",
          "declared_in": "Motor",
          "oneway": true,
          "groupable": true,
          "result": null,
          "parameters": [],
          "raises": [],
          "file": "test.idl",
          "line": 4
        },
        {
          "id": 1,
          "name": "_get_ramp",
          "kind": "get",
          "declared_in": "Motor",
          "oneway": false,
          "groupable": false,
          "result": {
            "kind": "long"
          },
          "parameters": [],
          "raises": [],
          "file": "test.idl",
          "line": 5
        },
        {
          "id": 2,
          "name": "_set_ramp",
          "kind": "set",
          "declared_in": "Motor",
          "oneway": false,
          "groupable": true,
          "result": null,
          "parameters": [
            {
              "name": "value",
              "direction": "in",
              "type": {
                "kind": "long"
              }
            }
          ],
          "raises": [],
          "file": "test.idl",
          "line": 5
        },
        {
          "id": 3,
          "name": "sample",
          "kind": "operation",
          "declared_in": "Motor",
          "oneway": false,
          "groupable": false,
          "result": {
            "kind": "float"
          },
          "parameters": [
            {
              "name": "name",
              "direction": "in",
              "type": {
                "kind": "string",
                "bound": 8
              }
            },
            {
              "name": "leader",
              "direction": "out",
              "type": {
                "kind": "interface",
                "name": "Motor"
              }
            }
          ],
          "raises": [
            "Broken"
          ],
          "file": "test.idl",
          "line": 6
        }
      ],
      "comment": [
        "/// An electric motor."
      ],
      "file": "test.idl",
      "line": 3,
      "in_main_file": true
    }
  ],
  "types": [],
  "exceptions": [
    {
      "name": "Broken",
      "repository_id": "IDL:Broken:1.0",
      "members": [
        {
          "name": "why",
          "type": {
            "kind": "string"
          }
        }
      ],
      "file": "test.idl",
      "line": 1,
      "in_main_file": true
    }
  ],
  "constants": []
}
)");
}

/// Without line ends and indentation: the layout is shown above.
std::string dense(const std::string& text) {
    std::string result;
    bool at_begin = true;
    for (const char c : text) {
        if (c == '\n') {
            at_begin = true;
        } else if (!at_begin || c != ' ') {
            at_begin = false;
            result += c;
        }
    }
    return result;
}

/// One of the four lists.
std::string list_of(const std::string& json, const std::string& name) {
    const std::string head = "  \"" + name + "\": ";
    const std::size_t begin = json.find('\n' + head);
    if (begin == std::string::npos) return "no " + name;
    const std::size_t first = begin + 1 + head.size();
    if (json[first + 1] == ']') return "[]";
    return dense(json.substr(first, json.find("\n  ]", first) + 4 - first));
}

TEST(JsonTest, EveryKindOfType) {
    const std::string json = json_of(R"(enum State {
  OFF,  // off
  @value(4) @default_literal ON
};
@bit_bound(16) bitmask Faults { HOT, @position(7) WET };
struct Point { long x; };
struct Line : Point { @default(3) short to; };
union Value switch (State) {
  case OFF: fixed<5,2> number;
  default: wstring<9> text;
};
typedef sequence<Line, 4> Lines;
typedef short Grid[2][3];
typedef map<string, any, 8> Table;
native Handle;
)");
    EXPECT_EQ(list_of(json, "types"), dense(R"([
{"name": "State","repository_id": "IDL:State:1.0","kind": "enum",
 "enumerators": [{"name": "OFF","number": 0},{"name": "ON","number": 4}],
 "default": "ON","file": "test.idl","line": 1,"in_main_file": true},
{"name": "Faults","repository_id": "IDL:Faults:1.0","kind": "bitmask","bit_bound": 16,
 "flags": [{"name": "HOT","position": 0},{"name": "WET","position": 7}],
 "file": "test.idl","line": 5,"in_main_file": true},
{"name": "Point","repository_id": "IDL:Point:1.0","kind": "struct",
 "members": [{"name": "x","type": {"kind": "long"}}],
 "file": "test.idl","line": 6,"in_main_file": true},
{"name": "Line","repository_id": "IDL:Line:1.0","kind": "struct","base": "Point",
 "members": [{"name": "x","type": {"kind": "long"}},
             {"name": "to","type": {"kind": "short"},"default": 3}],
 "file": "test.idl","line": 7,"in_main_file": true},
{"name": "Value","repository_id": "IDL:Value:1.0","kind": "union",
 "discriminator": {"kind": "enum","name": "State"},
 "members": [
 {"name": "number","type": {"kind": "fixed","digits": 5,"scale": 2},
  "labels": [0],"is_default": false},
 {"name": "text","type": {"kind": "wstring","bound": 9},"labels": [],"is_default": true}],
 "file": "test.idl","line": 8,"in_main_file": true},
{"name": "Lines","repository_id": "IDL:Lines:1.0","kind": "typedef",
 "type": {"kind": "sequence","element": {"kind": "struct","name": "Line"},"bound": 4},
 "file": "test.idl","line": 12,"in_main_file": true},
{"name": "Grid","repository_id": "IDL:Grid:1.0","kind": "typedef",
 "type": {"kind": "array",
          "element": {"kind": "array","element": {"kind": "short"},"length": 3},
          "length": 2},
 "file": "test.idl","line": 13,"in_main_file": true},
{"name": "Table","repository_id": "IDL:Table:1.0","kind": "typedef",
 "type": {"kind": "map","key": {"kind": "string"},"element": {"kind": "any"},"bound": 8},
 "file": "test.idl","line": 14,"in_main_file": true},
{"name": "Handle","repository_id": "IDL:Handle:1.0","kind": "native",
 "file": "test.idl","line": 15,"in_main_file": true}])"));
    EXPECT_EQ(list_of(json, "interfaces"), "[]");
}

TEST(JsonTest, ConstantsOfEveryKind) {
    const std::string json = json_of(R"(module M {
enum State { OFF, ON };
const long long low = -9223372036854775808;
const unsigned long long high = 18446744073709551615;
const double half = 0.5;
const long double fine = 0.5;
const boolean yes = TRUE;
const char letter = '\xe4';
const wchar wide = L'\u20ac';
const string text = "a\"b";
const wstring more = L"\u00e4\u20ac";
const fixed price = 12.25d;
const State now = ON;
};
)");
    const auto entry = [](const char* name, const char* type, const char* value, int line) {
        return std::string{"{\"name\": \"M::"} + name + R"(","repository_id": "IDL:M/)" + name +
               R"(:1.0","type": {)" + type + "},\"value\": " + value +
               ",\"file\": \"test.idl\",\"line\": " + std::to_string(line) +
               ",\"in_main_file\": true}";
    };
    EXPECT_EQ(list_of(json, "constants"),
              '[' + entry("low", R"("kind": "long long")", "-9223372036854775808", 3) + ',' +
                  entry("high", R"("kind": "unsigned long long")", "18446744073709551615", 4) +
                  ',' + entry("half", R"("kind": "double")", "0.5", 5) + ',' +
                  entry("fine", R"("kind": "long double")", "\"0.5\"", 6) + ',' +
                  entry("yes", R"("kind": "boolean")", "true", 7) + ',' +
                  entry("letter", R"("kind": "char")", "228", 8) + ',' +
                  entry("wide", R"("kind": "wchar")", "8364", 9) + ',' +
                  entry("text", R"("kind": "string")", R"("a\"b")", 10) + ',' +
                  entry("more", R"("kind": "wstring")", "\"\xc3\xa4\xe2\x82\xac\"", 11) + ',' +
                  entry("price", R"("kind": "fixed","digits": 4,"scale": 2)", "\"12.25\"", 12) +
                  ',' + entry("now", R"("kind": "enum","name": "M::State")", "\"ON\"", 13) + ']');
}

TEST(JsonTest, InheritedOperationsAndInterfacesThatAreOnlyDeclared) {
    // There is no C++ for an interface that is only declared, but it can be told of.
    const TextCompilation compilation{R"(interface Later;
interface Device { oneway void reset(); };
local interface Pump : Device { void prime(); };
)"};
    const std::string json = emit::json(compilation.model);
    const std::string reset =
        R"({"id": 0,"name": "reset","kind": "operation","declared_in": "Device","oneway": true,)"
        R"("groupable": true,"result": null,"parameters": [],"raises": [],)"
        R"("file": "test.idl","line": 2})";
    // The hashes are zlib's crc32 of the texts that structure_test.cpp has the like of, the group
    // keys its CRC-16/CCITT-FALSE of the repository ids.
    EXPECT_EQ(
        list_of(json, "interfaces"),
        dense(R"([{"name": "Later","repository_id": "IDL:Later:1.0","kind": "plain",)"
              R"("defined": false,"structural_hash": 0,"group_key": 59203,"bases": [],)"
              R"("operations": [],"file": "test.idl","line": 1,"in_main_file": true},)"
              R"({"name": "Device","repository_id": "IDL:Device:1.0","kind": "plain",)"
              R"("defined": true,"structural_hash": 3005434858,"group_key": 36141,"bases": [],)"
              R"("operations": [)" +
              reset +
              R"(],"file": "test.idl","line": 2,"in_main_file": true},)"
              R"({"name": "Pump","repository_id": "IDL:Pump:1.0","kind": "local",)"
              R"("defined": true,"structural_hash": 2083399776,"group_key": 17690,)"
              R"("bases": ["Device"],"operations": [)" +
              reset +
              R"(,{"id": null,"name": "prime","kind": "operation","declared_in": "Pump",)"
              R"("oneway": false,"groupable": true,"result": null,"parameters": [],)"
              R"("raises": [],"file": "test.idl","line": 3}],)"
              R"("file": "test.idl","line": 3,"in_main_file": true}])"));
}

TEST(JsonTest, OctetsThatAreNoTextDoNoHarm) {
    EXPECT_NE(json_of("const string text = \"\\xff\";\n").find("\"value\": \"\xef\xbf\xbd\""),
              std::string::npos);
}

}  // namespace
}  // namespace canorb::idlc::test
