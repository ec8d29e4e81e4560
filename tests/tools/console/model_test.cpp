// The compiler's JSON as types and operations; and what is none.

#include <gmock/gmock.h>

#include "tests/tools/console/model_of.hpp"
#include "tools/console/type_codes.hpp"

namespace canorb::console {
namespace {

using test::json_of;
using test::model_of;

TEST(Model, KnowsInterfacesByNameIdAndGroupKey) {
    const auto model = model_of(R"(module Devices {
        exception Fault { string reason; };
        typedef sequence<unsigned short> Samples;
        interface Base { readonly attribute string<16> model; };
        interface Motor : Base {
            float speed(in unsigned short channel) raises (Fault);
            oneway void stop();
            Samples sample(inout long range, out Base other);
        };
        local interface Secret { void f(); };
    };)");
    const Interface* motor = model->find_interface("Devices::Motor");
    ASSERT_NE(motor, nullptr);
    EXPECT_EQ(model->find_interface("IDL:Devices/Motor:1.0"), motor);
    EXPECT_EQ(model->find_interface(std::uint16_t{0x4DDB}), motor);
    EXPECT_EQ(model->find_interface("Devices::Pump"), nullptr);
    ASSERT_EQ(motor->operations.size(), 4U);
    EXPECT_EQ(motor->operations[0].signature(), "string<16> _get_model()");
    EXPECT_EQ(motor->operations[0].declared_in_id, "IDL:Devices/Base:1.0");
    EXPECT_EQ(motor->operations[1].signature(),
              "float speed(in unsigned short channel) raises (Devices::Fault)");
    EXPECT_EQ(motor->operations[2].signature(), "oneway void stop()");
    EXPECT_TRUE(motor->operations[2].oneway);
    EXPECT_TRUE(motor->operations[2].groupable);
    EXPECT_EQ(motor->operations[3].signature(),
              "Devices::Samples sample(inout long range, out Devices::Base other)");
    EXPECT_EQ(motor->find(OperationId{2})->name, "stop");
    EXPECT_EQ(motor->find(OperationId{4}), nullptr);
    ASSERT_NE(model->find_exception("IDL:Devices/Fault:1.0"), nullptr);
    EXPECT_EQ(model->find_exception("IDL:Devices/Fault:1.0")->name, "Devices::Fault");
    EXPECT_TRUE(model->find_interface("Devices::Secret")->is_local);
}

TEST(Model, TakesSeveralDocumentsThatAgree) {
    Model model;
    const std::string base = "interface Base { void f(); };\n";
    EXPECT_EQ(model.add(json_of(base + "interface A : Base {};"), "a"), std::nullopt);
    EXPECT_EQ(model.add(json_of("// further down\n\n" + base + "interface B : Base {};"), "b"),
              std::nullopt);
    EXPECT_EQ(model.interfaces().size(), 3U);
    EXPECT_EQ(model.find_interface("B")->operations.size(), 1U);
    EXPECT_THAT(model.add(json_of("interface Base { void g(); };"), "c").value_or(""),
                testing::EndsWith("Base is declared in another way than before"));
}

TEST(Model, TakesTheDefinitionOfWhatWasOnlyDeclared) {
    for (const bool declared_first : {true, false}) {
        Model model;
        const std::string declaration =
            json_of("interface Peer; interface A { void f(in Peer p); };");
        const std::string definition = json_of("interface Peer { void g(); };");
        EXPECT_EQ(model.add(declared_first ? declaration : definition, "a"), std::nullopt);
        EXPECT_EQ(model.add(declared_first ? definition : declaration, "b"), std::nullopt);
        EXPECT_TRUE(model.find_interface("Peer")->defined);
        EXPECT_NE(model.find_interface("Peer")->find("g", 0), nullptr);
    }
}

TEST(Model, RefusesWhatTheCompilerDoesNotWrite) {
    const auto error_of = [](std::string_view json) {
        Model model;
        return model.add(json, "file.json").value_or("no error");
    };
    const std::string not_json = "file.json is not what canorb-idlc --emit json writes";
    EXPECT_EQ(error_of(""), not_json);
    EXPECT_EQ(error_of("{"), not_json);
    EXPECT_EQ(error_of("[]"), not_json);
    EXPECT_EQ(error_of(R"({"format": 7})"), not_json);
    EXPECT_EQ(error_of(R"({"format": "canorb-idl", "format_version": 2})"),
              "file.json has a format_version that this program does not know; it knows 1");
    const std::string head = R"({"format": "canorb-idl", "format_version": 1, )";
    EXPECT_THAT(error_of(head + R"("interfaces": []})"), testing::HasSubstr("types"));
    const auto types = [&](const std::string& list) {
        return error_of(head + R"("interfaces": [], "exceptions": [], "types": [)" + list + "]}");
    };
    EXPECT_EQ(types(""), "no error");
    const auto entry = [](const std::string& name, const std::string& rest) {
        return R"({"name": ")" + name + R"(", "repository_id": "IDL:X:1.0", )" + rest + '}';
    };
    EXPECT_THAT(types(entry("A", R"("kind": "typedef", "type": {"kind": "typedef", "name": "A"})")),
                testing::EndsWith("A is a typedef of itself"));
    EXPECT_THAT(types(entry("A", R"("kind": "struct", "members": [{"name": "a", "type":
                            {"kind": "struct", "name": "A"}}])")),
                testing::EndsWith("A has itself as a member"));
    EXPECT_THAT(types(entry("A", R"("kind": "typedef", "type": {"kind": "struct", "name": "B"})")),
                testing::EndsWith("there is no type B"));
    EXPECT_THAT(types(entry("A", R"("kind": "typedef", "type": {"kind": "float16"})")),
                testing::EndsWith("there is no type 'float16'"));
    EXPECT_THAT(types(entry("A", R"("kind": "enum", "enumerators": [])")),
                testing::EndsWith("A has no enumerator"));
    EXPECT_THAT(types(entry("A", R"("kind": "bitmask", "bit_bound": 65, "flags": [])")),
                testing::EndsWith("A is not of 1 to 64 bits"));
    EXPECT_THAT(types(entry("A", R"("kind": "typedef", "type":
                            {"kind": "fixed", "digits": 32, "scale": 0})")),
                testing::EndsWith("a fixed that there is not"));
    EXPECT_THAT(types(entry("A", R"("kind": "union", "discriminator": {"kind": "float"},
                            "members": [])")),
                testing::EndsWith("A has a discriminator that none can be"));
    EXPECT_THAT(types(entry("A", R"("kind": "typedef", "type": {"kind": "map",
                            "key": {"kind": "any"}, "element": {"kind": "any"}})")),
                testing::EndsWith("any as a map's key"));
}

TEST(Model, FindsTypesByTheirTypeCodes) {
    const auto model = model_of(R"(
        struct Tree; typedef sequence<Tree> Trees;
        struct Tree { long value; Trees children; };
        union Number switch (boolean) { case TRUE: long large; case FALSE: octet small; };
        @bit_bound(9) bitmask Alarms { hot };
        enum Sparse { @value(3) three };
        typedef map<octet, string> Names;
        interface Device {};)");
    for (const char* name : {"Tree", "Number", "Alarms", "Sparse", "Device", "long double", "any",
                             "unsigned long long", "wchar", "TypeCode"}) {
        const auto type = model->find_type(name);
        ASSERT_TRUE(type) << name;
        const auto code = type_code(*type);
        ASSERT_TRUE(code) << name;
        ccdr::Decoder in{code->octets()};
        ccdr::read_type_code(in);
        EXPECT_TRUE(in.finished()) << name;
        const auto found = find_type(*code, *model);
        ASSERT_TRUE(found) << name;
        EXPECT_EQ(found->name, name);
    }
    // A struct with the id of one that is known, and other members.
    std::string other = "\x0F\x0E";
    other += "IDL:Tree:1.0";
    other += std::string{"\0\0\x01\0\x01\x01\0\x0A", 8}.substr(1);
    EXPECT_FALSE(find_type(TypeCode{other}, *model));
}

}  // namespace
}  // namespace canorb::console
