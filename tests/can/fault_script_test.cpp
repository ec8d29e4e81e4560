#include "orb/can/sim/fault_script.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace canorb::can::sim {
namespace {

using namespace std::chrono_literals;
using Field = FramePlace::Field;
using Scope = FaultTargets::Scope;

/// The script, or one without faults where it has errors.
FaultScript parse(std::string_view text) {
    auto script = parse_fault_script(text);
    if (script) return *script;
    for (const FaultScriptError& error : script.error()) ADD_FAILURE() << format(error);
    return {};
}

/// The one fault of a script.
Fault parse_fault(std::string_view text) {
    const FaultScript script = parse(text);
    EXPECT_EQ(script.faults.size(), 1U) << text;
    return script.faults.empty() ? Fault{} : script.faults[0];
}

AtTime time_of(const Fault& fault) {
    const auto* at = std::get_if<AtTime>(&fault.trigger);
    EXPECT_NE(at, nullptr);
    return at == nullptr ? AtTime{} : *at;
}

InFrame frame_of(const Fault& fault) {
    const auto* frame = std::get_if<InFrame>(&fault.trigger);
    EXPECT_NE(frame, nullptr);
    return frame == nullptr ? InFrame{} : *frame;
}

std::uint64_t rate_of(const Fault& fault) {
    const auto* random = std::get_if<AtRandom>(&fault.trigger);
    EXPECT_NE(random, nullptr);
    return random == nullptr ? 0 : random->probability;
}

std::vector<std::string> errors_of(std::string_view text) {
    const auto script = parse_fault_script(text);
    std::vector<std::string> errors;
    if (script) return errors;
    for (const FaultScriptError& error : script.error()) errors.push_back(format(error));
    return errors;
}

TEST(FaultScript, MayBeEmpty) {
    EXPECT_TRUE(parse("").faults.empty());
    EXPECT_TRUE(parse("\n\n").faults.empty());
    EXPECT_TRUE(parse("# nothing\n   \t # and nothing\r\n").faults.empty());
    EXPECT_EQ(parse("").seed, 1U);
}

TEST(FaultScript, HasASeed) {
    EXPECT_EQ(parse("seed 42").seed, 42U);
    EXPECT_EQ(parse("# first\n\tseed 18446744073709551615 # all of it").seed, UINT64_MAX);
}

TEST(FaultScript, ActsAtATime) {
    const Fault fault = parse_fault("\n\nat 10ms flip wire\n");
    EXPECT_EQ(fault.line, 3U);
    EXPECT_EQ(time_of(fault).first.at(500'000), 10ms);
    EXPECT_FALSE(time_of(fault).period);
    EXPECT_EQ(fault.kind, FaultKind::flip);
    EXPECT_EQ(fault.targets.scope, Scope::wire);
    ASSERT_TRUE(fault.duration);
    EXPECT_TRUE(fault.duration->in_bits);
    EXPECT_EQ(fault.duration->amount, 1U);
}

TEST(FaultScript, ReadsTimes) {
    const auto nanoseconds = [](const std::string& time) {
        return time_of(parse_fault("at " + time + " flip wire")).first.at(300'000).count();
    };
    EXPECT_EQ(nanoseconds("0ns"), 0);
    EXPECT_EQ(nanoseconds("17 ns"), 17);
    EXPECT_EQ(nanoseconds("3us"), 3'000);
    EXPECT_EQ(nanoseconds("2.5us"), 2'500);
    EXPECT_EQ(nanoseconds("0.000001ms"), 1);
    EXPECT_EQ(nanoseconds("1.000000001 s"), 1'000'000'001);
    EXPECT_EQ(nanoseconds("1000000000s"), 1'000'000'000'000'000'000);
    EXPECT_EQ(nanoseconds("1bit"), 3'333);
    EXPECT_EQ(nanoseconds("2 bits"), 6'666);
    EXPECT_EQ(nanoseconds("3bits"), 10'000);
    EXPECT_EQ(nanoseconds("1000000000000 bits"), 3'333'333'333'333'333);
}

TEST(FaultScript, ActsPeriodically) {
    const Fault fault = parse_fault("at 100 bits every 2ms dominant a for 6 bits");
    EXPECT_EQ(time_of(fault).first.at(1'000'000), 100us);
    ASSERT_TRUE(time_of(fault).period);
    EXPECT_EQ(time_of(fault).period->at(1'000'000), 2ms);
    ASSERT_TRUE(fault.duration);
    EXPECT_EQ(fault.duration->at(1'000'000), 6us);
}

TEST(FaultScript, KnowsWhatCanHappen) {
    EXPECT_EQ(parse_fault("at 1s flip a").kind, FaultKind::flip);
    EXPECT_EQ(parse_fault("at 1s dominant a").kind, FaultKind::dominant);
    EXPECT_EQ(parse_fault("at 1s recessive wire").kind, FaultKind::recessive);
    const Fault stuck = parse_fault("at 1s stuck-dominant wire");
    EXPECT_EQ(stuck.kind, FaultKind::stuck_dominant);
    EXPECT_FALSE(stuck.duration) << "for good";
    const Fault briefly = parse_fault("at 1s stuck-dominant a for 200us");
    ASSERT_TRUE(briefly.duration);
    EXPECT_EQ(briefly.duration->at(500'000), 200us);
    const Fault cut = parse_fault("at 1s cut-off a");
    EXPECT_EQ(cut.kind, FaultKind::cut_off);
    EXPECT_FALSE(cut.duration);
    EXPECT_EQ(parse_fault("at 1s reconnect each-node").kind, FaultKind::reconnect);
}

TEST(FaultScript, NamesNodes) {
    const Fault fault = parse_fault("at 1s flip a,pump-3 , \"the valve, left\",\"wire\", Füller");
    EXPECT_EQ(fault.targets.scope, Scope::named);
    EXPECT_EQ(fault.targets.names,
              (std::vector<std::string>{"a", "pump-3", "the valve, left", "wire", "Füller"}));
    EXPECT_EQ(parse_fault("at 1s flip each-node#all of them").targets.scope, Scope::each_node);
    EXPECT_EQ(parse_fault("at 1s flip \"each-node\"").targets.scope, Scope::named);
    EXPECT_EQ(parse_fault("at 1s flip \"a#1\" for 3 bits").targets.names,
              std::vector<std::string>{"a#1"});
}

TEST(FaultScript, ActsInAFrame) {
    const InFrame standard = frame_of(parse_fault("frame 123 at eof.6 dominant a"));
    EXPECT_EQ(standard.id, 0x123U);
    EXPECT_FALSE(standard.extended);
    EXPECT_FALSE(standard.sender);
    EXPECT_EQ(standard.first_attempt, 1U);
    EXPECT_EQ(standard.last_attempt, UINT64_MAX);
    EXPECT_EQ(standard.place.field, Field::end_of_frame);
    EXPECT_EQ(standard.place.number, 6U);

    const InFrame extended =
        frame_of(parse_fault("frame 0x1ffFFfff from \"pump 3\" attempt 2 at sof flip wire"));
    EXPECT_EQ(extended.id, 0x1FFFFFFFU);
    EXPECT_TRUE(extended.extended);
    EXPECT_EQ(extended.sender, "pump 3");
    EXPECT_EQ(extended.first_attempt, 2U);
    EXPECT_EQ(extended.last_attempt, 2U);

    const InFrame any = frame_of(parse_fault("frame at data.3 flip wire"));
    EXPECT_FALSE(any.id);
    const InFrame first = frame_of(parse_fault("frame from pump-3 attempt 1..16 at ack flip wire"));
    EXPECT_FALSE(first.id);
    EXPECT_EQ(first.sender, "pump-3");
    EXPECT_EQ(first.first_attempt, 1U);
    EXPECT_EQ(first.last_attempt, 16U);
}

TEST(FaultScript, KnowsThePlacesInAFrame) {
    const std::vector<std::pair<std::string, FramePlace>> places{
        {"sof", {Field::start_of_frame, 1}},
        {"id.1", {Field::identifier, 1}},
        {"id.29", {Field::identifier, 29}},
        {"srr", {Field::substitute_remote_request, 1}},
        {"rtr", {Field::remote_request, 1}},
        {"ide", {Field::identifier_extension, 1}},
        {"r1", {Field::reserved_1, 1}},
        {"r0", {Field::reserved_0, 1}},
        {"dlc.4", {Field::data_length_code, 4}},
        {"data.64", {Field::data, 64}},
        {"crc.15", {Field::crc, 15}},
        {"crc-delimiter", {Field::crc_delimiter, 1}},
        {"ack", {Field::ack_slot, 1}},
        {"ack-delimiter", {Field::ack_delimiter, 1}},
        {"eof.7", {Field::end_of_frame, 7}},
        {"intermission.3", {Field::intermission, 3}},
        {"stuff.29", {Field::stuff_bit, 29}},
        {"bit.999", {Field::any_bit, 999}},
    };
    for (const auto& [text, place] : places) {
        const FramePlace parsed = frame_of(parse_fault("frame at " + text + " flip wire")).place;
        EXPECT_EQ(parsed.field, place.field) << text;
        EXPECT_EQ(parsed.number, place.number) << text;
    }
}

TEST(FaultScript, HasBitErrorRates) {
    const Fault half = parse_fault("bit-error-rate 0.5 wire");
    EXPECT_EQ(rate_of(half), std::uint64_t{1} << 63);
    EXPECT_EQ(half.kind, FaultKind::flip);
    EXPECT_EQ(half.targets.scope, Scope::wire);
    EXPECT_EQ(rate_of(parse_fault("bit-error-rate 1 wire")), UINT64_MAX);
    EXPECT_EQ(rate_of(parse_fault("bit-error-rate 1.000e-0 wire")), UINT64_MAX);
    EXPECT_EQ(rate_of(parse_fault("bit-error-rate 25e-2 wire")), std::uint64_t{1} << 62);
    // 2 to the 64 is 18446744073709551616.
    EXPECT_EQ(rate_of(parse_fault("bit-error-rate 1e-5 each-node")), 184467440737095U);
    EXPECT_EQ(rate_of(parse_fault("bit-error-rate 0.00001 a, b")), 184467440737095U);
    EXPECT_EQ(rate_of(parse_fault("bit-error-rate 1e-18 wire")), 18U);
}

TEST(FaultScript, SaysWhatToWrite) {
    const std::vector<std::pair<std::string, std::string>> cases{
        {"flip wire", "1:1: write \"at\", \"frame\", \"bit-error-rate\" or \"seed\" here"},
        {"\"at\" 1s flip wire",
         "1:1: write \"at\", \"frame\", \"bit-error-rate\" or \"seed\" here"},
        {"  at", "1:5: write a time here, such as 10ms, 2.5us or 20 bits"},
        {"at flip wire", "1:4: write a time here, such as 10ms, 2.5us or 20 bits"},
        {"at 10 flip wire", "1:7: write a time with its unit: ns, us, ms, s or bits"},
        {"at 10", "1:6: write a time with its unit: ns, us, ms, s or bits"},
        {"at 10min flip wire", "1:4: write a time with its unit: ns, us, ms, s or bits"},
        {"at 1.5 bits flip wire", "1:8: write a whole number of bits, at most 1000000000000"},
        {"at 1.2.3ms flip wire",
         "1:4: write a number with at most one point, whole in nanoseconds, at most 1000000000s"},
        {"at 0.5ns flip wire",
         "1:4: write a number with at most one point, whole in nanoseconds, at most 1000000000s"},
        {"at 1000000000.1s flip wire",
         "1:4: write a number with at most one point, whole in nanoseconds, at most 1000000000s"},
        {"at 99999999999999999999999ns flip wire",
         "1:4: write a number with at most one point, whole in nanoseconds, at most 1000000000s"},
        {"at 1s every 0ms flip wire", "1:13: write a time that is longer than 0"},
        {"at 1s",
         "1:6: write what happens here: flip, dominant, recessive, stuck-dominant, "
         "cut-off or reconnect"},
        {"at 1s explode a",
         "1:7: write what happens here: flip, dominant, recessive, "
         "stuck-dominant, cut-off or reconnect"},
        {"at 1s flip", "1:11: write wire, each-node or a node's name here"},
        {"at 1s cut-off", "1:14: write each-node or a node's name here"},
        {"at 1s flip a,", "1:14: write a node's name here"},
        {"at 1s flip , a", "1:12: write wire, each-node or a node's name here"},
        {"at 1s flip for 3 bits",
         "1:12: write wire, each-node or a node's name here (in quotes if that is its name)"},
        {"at 1s flip a, wire", "1:15: write a node's name here (in quotes if that is its name)"},
        {"at 1s flip a b",
         "1:14: write a # before a comment, and nothing else after the end of a fault (a name with "
         "spaces is written in quotes)"},
        {"at 1s flip \"a\" b",
         "1:16: write a # before a comment, and nothing else after the end of a fault"},
        {"at 1s flip wire, a",
         "1:16: write a # before a comment, and nothing else after the end of a fault"},
        {"at 1s cut-off wire", "1:15: write which nodes, not the wire"},
        {"at 1s reconnect wire", "1:17: write which nodes, not the wire"},
        {"at 1s reconnect a for 1s",
         "1:19: write a # before a comment, and nothing else after the end of a fault"},
        {"at 1s cut-off a for 0s", "1:21: write a time that is longer than 0"},
        {"at 1s flip \"a", "1:12: write a \" at the end of the name"},
        {"at 1s flip \"\"", "1:12: write a name between the quotes"},
        {"frame",
         "1:6: write an identifier of 3 hexadecimal digits (standard, up to 7FF) or 8 "
         "(extended, up to 1FFFFFFF), or \"from\", \"attempt\" or \"at\""},
        {"frame 800 at sof flip wire",
         "1:7: write an identifier of 3 hexadecimal digits (standard, up to 7FF) or 8 (extended, "
         "up to 1FFFFFFF), or \"from\", \"attempt\" or \"at\""},
        {"frame 20000000 at sof flip wire",
         "1:7: write an identifier of 3 hexadecimal digits (standard, up to 7FF) or 8 (extended, "
         "up to 1FFFFFFF), or \"from\", \"attempt\" or \"at\""},
        {"frame 0x12 at sof flip wire",
         "1:7: write an identifier of 3 hexadecimal digits (standard, up to 7FF) or 8 (extended, "
         "up to 1FFFFFFF), or \"from\", \"attempt\" or \"at\""},
        {"frame from at sof flip wire",
         "1:12: write a node's name here (in quotes if that is its name)"},
        {"frame 123 sof flip wire",
         "1:11: "
         "write \"from\" and a node, then \"attempt\" and a number, or \"at\" and a place in the "
         "frame here"},
        {"frame from a sof flip wire",
         "1:14: "
         "write \"from\" and a node, then \"attempt\" and a number, or \"at\" and a place in the "
         "frame here (a name with spaces is written in quotes)"},
        {"frame attempt 1 from a at sof flip wire",
         "1:17: "
         "write \"from\" and a node, then \"attempt\" and a number, or \"at\" and a place in the "
         "frame here"},
        {"frame attempt 0 at sof flip wire",
         "1:15: write which attempt, counted from 1, such as "
         "3, or from which to which, such as 1..16"},
        {"frame attempt 3..2 at sof flip wire",
         "1:15: write which attempt, counted from 1, such "
         "as 3, or from which to which, such as 1..16"},
        {"frame attempt 3.. at sof flip wire",
         "1:15: write which attempt, counted from 1, such "
         "as 3, or from which to which, such as 1..16"},
        {"frame at eof flip wire", "1:10: write eof.1 to eof.7"},
        {"frame at eof.8 flip wire", "1:10: write eof.1 to eof.7"},
        {"frame at data.0 flip wire", "1:10: write data.1 to data.64"},
        {"frame at crc.1x flip wire", "1:10: write crc.1 to crc.15"},
        {"frame at ack.1 flip wire", "1:10: write ack without a number: it is one bit"},
        {"frame at end flip wire",
         "1:10: write a place in the frame here: sof, id.N, srr, rtr, ide, r1, r0, dlc.N, data.N, "
         "crc.N, crc-delimiter, ack, ack-delimiter, eof.N, intermission.N, stuff.N, bit.N"},
        {"seed", "1:5: write a whole number, at most 18446744073709551615"},
        {"seed 18446744073709551616", "1:6: write a whole number, at most 18446744073709551615"},
        {"seed -1", "1:6: write a whole number, at most 18446744073709551615"},
        {"seed 1 2", "1:8: write a # before a comment, and nothing else after the end of a fault"},
        {"bit-error-rate wire",
         "1:16: write a rate above 0 and up to 1, such as 1e-5 or 0.001, "
         "with at most 18 digits after the point"},
        {"bit-error-rate 1e-5", "1:20: write wire, each-node or a node's name here"},
    };
    for (const auto& [text, error] : cases) {
        EXPECT_EQ(errors_of(text), std::vector<std::string>{error}) << text;
    }
}

TEST(FaultScript, RefusesRatesThatAreNone) {
    for (const char* rate :
         {"0", "0.0", "2", "1.1", "-1e-3", "1e3", "1e", "1e-", "1.", ".5", "1e-19",
          "0.0000000000000000001", "1e-3x", "e-3", "nan", "99999999999999999999e-18"}) {
        EXPECT_EQ(errors_of(std::string{"bit-error-rate "} + rate + " wire").size(), 1U) << rate;
    }
}

TEST(FaultScript, ReportsTheFirstErrorOfEachLine) {
    EXPECT_EQ(errors_of("at x flip\nat 1s flip wire\nseed 1\nseed 2\r\nframe at ack.2 flop"),
              (std::vector<std::string>{
                  "1:4: write a time here, such as 10ms, 2.5us or 20 bits",
                  "4:1: remove this: a script has one seed",
                  "5:10: write ack without a number: it is one bit",
              }));
}

TEST(FaultScript, ReportsTwentyErrorsAndThatThereAreMore) {
    std::string text;
    for (int i = 0; i < 20; ++i) text += "nonsense\n";
    auto errors = errors_of(text + "at 1s flip wire\n");
    ASSERT_EQ(errors.size(), 20U);
    EXPECT_EQ(errors.back().substr(0, 12), "20:1: write ");
    errors = errors_of(text + "seed 1\n\nnonsense\nnonsense\n");
    ASSERT_EQ(errors.size(), 21U);
    EXPECT_EQ(errors.back(), "23:1: and more errors");
}

TEST(FaultScript, TakesTheExamples) {
    const std::filesystem::path folder{CANORB_FAULT_EXAMPLES};
    std::size_t scripts = 0;
    for (const auto& entry : std::filesystem::directory_iterator{folder}) {
        if (entry.path().extension() != ".fault") continue;
        std::ifstream file{entry.path()};
        std::stringstream text;
        text << file.rdbuf();
        const auto script = parse_fault_script(text.str());
        if (!script) {
            for (const auto& error : script.error()) {
                ADD_FAILURE() << entry.path() << ":" << format(error);
            }
            continue;
        }
        EXPECT_FALSE(script->faults.empty()) << entry.path();
        ++scripts;
    }
    EXPECT_GE(scripts, 8U);
}

/// What the documentation shows as a script is one.
TEST(FaultScript, TakesTheDocumentation) {
    std::ifstream file{CANORB_FAULT_DOCUMENTATION};
    ASSERT_TRUE(file.is_open());
    std::string line;
    std::string script;
    bool is_script = false;
    int scripts = 0;
    while (std::getline(file, line)) {
        if (line == "```fault") {
            is_script = true;
            script.clear();
        } else if (line == "```" && is_script) {
            is_script = false;
            ++scripts;
            for (const std::string& error : errors_of(script)) ADD_FAILURE() << script << error;
        } else if (is_script) {
            script += line + "\n";
        }
    }
    EXPECT_GE(scripts, 5);
}

TEST(FaultScript, NamesPlacesAsItReadsThem) {
    using F = FrameField;
    for (const auto& [position, name] : std::vector<std::pair<FramePosition, std::string>>{
             {{F::start_of_frame, 0}, "sof"},
             {{F::identifier, 0}, "id.1"},
             {{F::identifier, 10}, "id.11"},
             {{F::remote_request, 0}, "rtr"},
             {{F::identifier_extension, 0}, "ide"},
             {{F::extended_identifier, 0}, "id.12"},
             {{F::extended_identifier, 17}, "id.29"},
             {{F::extended_remote_request, 0}, "rtr"},
             {{F::reserved_1, 0}, "r1"},
             {{F::reserved_0, 0}, "r0"},
             {{F::data_length_code, 3}, "dlc.4"},
             {{F::data, 63}, "data.64"},
             {{F::data, 7, true}, "data.8"},
             {{F::crc, 14}, "crc.15"},
             {{F::crc_delimiter, 0}, "crc-delimiter"},
             {{F::ack_slot, 0}, "ack"},
             {{F::ack_delimiter, 0}, "ack-delimiter"},
             {{F::end_of_frame, 6}, "eof.7"},
             {{F::intermission, 2}, "intermission.3"},
         }) {
        EXPECT_EQ(place_name(position), name);
        EXPECT_TRUE(parse_fault_script("frame at " + name + " flip wire")) << name;
    }
    EXPECT_EQ(place_name({F::suspend_transmission, 7}), "suspend.8");
    EXPECT_EQ(place_name({F::active_error_flag, 0}), "active-error-flag.1");
    EXPECT_EQ(place_name({F::error_superposition, 2}), "error-superposition");
    EXPECT_EQ(place_name({F::overload_delimiter, 1}), "overload-delimiter.2");
    EXPECT_EQ(place_name({}), "idle");
}

}  // namespace
}  // namespace canorb::can::sim
