#pragma once

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "idlc/compile.hpp"
#include "idlc/diagnostics.hpp"
#include "idlc/emit/json.hpp"
#include "idlc/source.hpp"
#include "tools/console/arguments.hpp"
#include "tools/console/model.hpp"
#include "tools/console/values.hpp"

/// What both fuzz targets of the console work on: a type of every kind, each as the parameter of an
/// operation.
namespace canorb::console::fuzz {

inline void require(bool holds) {
    if (!holds) std::abort();
}

inline const Model& model() {
    static const std::unique_ptr<Model> model = [] {
        const idlc::Source source{"fuzz.idl", R"(
            enum Mode { idle, @value(300) busy };
            @bit_bound(12) bitmask Alarms { hot, @position(9) stalled };
            struct Nothing {};
            typedef sequence<Nothing> Nothings;
            typedef fixed<5,2> Price;
            typedef map<short, string<4>> Names;
            typedef map<wstring, any> Values;
            typedef sequence<octet, 5> Octets;
            typedef double Pair[2];
            union Shape switch (Mode) { case idle: float radius; default: Octets sides; };
            union Flag switch (boolean) { case TRUE: long long large; };
            struct Tree;
            typedef sequence<Tree> TreeSeq;
            struct Tree { long value; TreeSeq children; };
            struct Status { Mode working; Alarms all_alarms; Price cost; Pair ends; Shape form;
                            long double exact; char letter; wchar wide; wstring<3> text;
                            Object peer; };
            interface Fuzzed {
                void f0(in unsigned short x); void f1(in long long x); void f2(in float x);
                void f3(in Mode x); void f4(in Alarms x); void f5(in Price x);
                void f6(in string<4> x); void f7(in wstring x); void f8(in any x);
                void f9(in Names x); void f10(in Values x); void f11(in Shape x);
                void f12(in Tree x); void f13(in Status x); void f14(in Nothings x);
                void f15(in Fuzzed x); void f16(in char x); void f17(in Flag x);
                void f18(in long double x); void f19(in TreeSeq x);
            };)"};
        idlc::Diagnostics diagnostics;
        const idlc::model::Model compiled = idlc::compile(source, diagnostics);
        require(!diagnostics.failed());
        auto result = std::make_unique<Model>();
        require(!result->add(idlc::emit::json(compiled), "fuzz.idl"));
        return result;
    }();
    return *model;
}

inline const Operation& operation(std::uint8_t number) {
    const auto& all = model().find_interface("Fuzzed")->operations;
    return all[number % all.size()];
}

inline Result<std::vector<std::uint8_t>, std::string> encoded(const Operation& op,
                                                              const std::string& text) {
    return encode_arguments(op, std::vector<std::string>{text}, model());
}

/// As JSON; nothing where the octets are no value.
inline std::optional<std::string> decoded(const Operation& op, Bytes octets) {
    const auto values = decode_arguments(op, octets, model());
    if (!values) {
        require(!values.error().empty());
        return std::nullopt;
    }
    return to_text(values->at(0).second);
}

}  // namespace canorb::console::fuzz
