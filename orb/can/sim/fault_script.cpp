#include "orb/can/sim/fault_script.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "orb/can/sim/fault_script_numbers.hpp"

namespace canorb::can::sim {
namespace {

constexpr std::uint64_t second = 1'000'000'000;  // in nanoseconds

/// A word, a quoted text or a comma.
struct Token {
    std::string_view text;
    std::size_t column = 0;
    bool quoted = false;
};

struct Keyword {
    std::string_view text;
    FaultKind kind;
};
constexpr std::array<Keyword, 6> actions{{{"flip", FaultKind::flip},
                                          {"dominant", FaultKind::dominant},
                                          {"recessive", FaultKind::recessive},
                                          {"stuck-dominant", FaultKind::stuck_dominant},
                                          {"cut-off", FaultKind::cut_off},
                                          {"reconnect", FaultKind::reconnect}}};

struct Unit {
    std::string_view text;
    std::uint64_t nanoseconds;  ///< 0: bit times
};
constexpr std::array<Unit, 6> units{
    {{"ns", 1}, {"us", 1'000}, {"ms", 1'000'000}, {"s", second}, {"bits", 0}, {"bit", 0}}};

struct PlaceName {
    std::string_view text;
    FramePlace::Field field;
    std::uint16_t numbers;  ///< the highest; 0 where the field is a single bit
};
constexpr std::array<PlaceName, 17> places{{
    {"sof", FramePlace::Field::start_of_frame, 0},
    {"id", FramePlace::Field::identifier, 29},
    {"srr", FramePlace::Field::substitute_remote_request, 0},
    {"rtr", FramePlace::Field::remote_request, 0},
    {"ide", FramePlace::Field::identifier_extension, 0},
    {"r1", FramePlace::Field::reserved_1, 0},
    {"r0", FramePlace::Field::reserved_0, 0},
    {"dlc", FramePlace::Field::data_length_code, 4},
    {"data", FramePlace::Field::data, 64},
    {"crc", FramePlace::Field::crc, 15},
    {"crc-delimiter", FramePlace::Field::crc_delimiter, 0},
    {"ack", FramePlace::Field::ack_slot, 0},
    {"ack-delimiter", FramePlace::Field::ack_delimiter, 0},
    {"eof", FramePlace::Field::end_of_frame, 7},
    {"intermission", FramePlace::Field::intermission, 3},
    {"stuff", FramePlace::Field::stuff_bit, 29},
    {"bit", FramePlace::Field::any_bit, 999},
}};

/// Words that are no node's name unless quoted.
constexpr std::array<std::string_view, 7> reserved{"wire", "each-node", "for",  "from",
                                                   "at",   "attempt",   "every"};

template <typename Table>
const typename Table::value_type* look_up(const Table& table, std::string_view text) {
    const auto found = std::find_if(table.begin(), table.end(),
                                    [&](const auto& entry) { return entry.text == text; });
    return found == table.end() ? nullptr : &*found;
}

bool is_reserved(std::string_view word) {
    return std::find(reserved.begin(), reserved.end(), word) != reserved.end();
}

bool is_space(char c) {
    return c == ' ' || c == '\t';
}

/// Reads one line. After the first failure nothing more is taken.
class LineParser {
  public:
    LineParser(std::string_view line, std::size_t number, FaultScript& script, bool& has_seed)
        : line_(line), number_(number), script_(script), has_seed_(has_seed) {}

    /// Adds what the line says to the script.
    std::optional<FaultScriptError> parse() {
        if (split() && !tokens_.empty()) statement();
        return std::move(error_);
    }

  private:
    bool fail(std::size_t column, std::string message) {
        if (!error_) error_ = FaultScriptError{number_, column, std::move(message)};
        return false;
    }
    /// At the next token, or behind the last.
    bool fail(std::string message) {
        if (next_ == tokens_.size()) return fail(end_column_, std::move(message));
        return fail(tokens_[next_].column, std::move(message));
    }

    bool split() {
        std::size_t at = 0;
        end_column_ = 1;
        while (at < line_.size()) {
            const char c = line_[at];
            if (is_space(c)) {
                ++at;
                continue;
            }
            if (c == '#') break;
            const std::size_t begin = at;
            if (c == '"') {
                const std::size_t end = line_.find('"', at + 1);
                if (end == line_.npos) return fail(at + 1, "write a \" at the end of the name");
                if (end == at + 1) return fail(at + 1, "write a name between the quotes");
                tokens_.push_back({line_.substr(at + 1, end - at - 1), begin + 1, true});
                at = end + 1;
            } else {
                ++at;
                while (c != ',' && at < line_.size() && !is_space(line_[at]) && line_[at] != ',' &&
                       line_[at] != '#' && line_[at] != '"') {
                    ++at;
                }
                tokens_.push_back({line_.substr(begin, at - begin), begin + 1, false});
            }
            end_column_ = at + 1;
        }
        return true;
    }

    const Token* peek() const { return next_ < tokens_.size() ? &tokens_[next_] : nullptr; }

    /// Whether that word is next.
    bool is_next(std::string_view word) const {
        return peek() != nullptr && !peek()->quoted && peek()->text == word;
    }
    bool take(std::string_view word) {
        if (!is_next(word)) return false;
        ++next_;
        return true;
    }
    /// A word without quotes; empty where there is none.
    std::string_view word() const {
        return peek() == nullptr || peek()->quoted ? std::string_view{} : peek()->text;
    }

    bool statement() {
        if (take("seed")) return seed() && end();
        Fault fault;
        fault.line = number_;
        if (take("at")) {
            if (!at_time(fault) || !action(fault)) return false;
        } else if (take("frame")) {
            if (!in_frame(fault) || !action(fault)) return false;
        } else if (take("bit-error-rate")) {
            if (!bit_error_rate(fault)) return false;
        } else {
            return fail("write \"at\", \"frame\", \"bit-error-rate\" or \"seed\" here");
        }
        if (!end()) return false;
        script_.faults.push_back(std::move(fault));
        return true;
    }

    bool end() {
        if (peek() == nullptr) return true;
        return fail("write a # before a comment, and nothing else after the end of a fault" +
                    hint());
    }

    /// What may be meant by a word behind a name.
    std::string hint() const {
        if (peek() == nullptr || next_ != behind_bare_name_ || is_reserved(word())) return "";
        return " (a name with spaces is written in quotes)";
    }

    bool seed() {
        if (has_seed_) return fail(tokens_[0].column, "remove this: a script has one seed");
        const auto value = parse_number(word(), 10, UINT64_MAX);
        if (!value) return fail("write a whole number, at most 18446744073709551615");
        ++next_;
        has_seed_ = true;
        script_.seed = *value;
        return true;
    }

    bool at_time(Fault& fault) {
        AtTime when;
        if (!time(when.first)) return false;
        if (take("every")) {
            FaultTime period;
            if (!positive_time(period)) return false;
            when.period = period;
        }
        fault.trigger = when;
        return true;
    }

    bool time(FaultTime& result) {
        const std::string_view both = word();
        const std::size_t letter = std::min(both.find_first_not_of("0123456789."), both.size());
        std::string_view number = both.substr(0, letter);
        std::string_view unit_name = both.substr(letter);
        if (number.empty()) return fail("write a time here, such as 10ms, 2.5us or 20 bits");
        if (unit_name.empty()) {
            ++next_;
            unit_name = word();
        }
        const Unit* unit = look_up(units, unit_name);
        if (unit == nullptr) return fail("write a time with its unit: ns, us, ms, s or bits");
        const bool in_bits = unit->nanoseconds == 0;
        const auto amount = in_bits ? parse_number(number, 10, FaultTime::highest_bits)
                                    : parse_nanoseconds(number, unit->nanoseconds);
        if (!amount) {
            return fail(in_bits ? "write a whole number of bits, at most 1000000000000"
                                : "write a number with at most one point, whole in nanoseconds, at "
                                  "most 1000000000s");
        }
        result = FaultTime{*amount, in_bits};
        ++next_;
        return true;
    }

    bool positive_time(FaultTime& result) {
        const std::size_t begin = next_;
        if (!time(result)) return false;
        if (result.amount > 0) return true;
        return fail(tokens_[begin].column, "write a time that is longer than 0");
    }

    bool in_frame(Fault& fault) {
        InFrame when;
        const bool has_id = !is_next("from") && !is_next("attempt") && !is_next("at");
        if (has_id && !identifier(when)) return false;
        if (take("from")) {
            when.sender.emplace();
            if (!name(*when.sender)) return false;
        }
        if (take("attempt") && !attempts(when)) return false;
        if (!take("at")) {
            return fail(
                "write \"from\" and a node, then \"attempt\" and a number, or \"at\" and a place "
                "in the frame here" +
                hint());
        }
        if (!place(when.place)) return false;
        fault.trigger = std::move(when);
        return true;
    }

    bool identifier(InFrame& when) {
        std::string_view digits = word();
        if (digits.starts_with("0x") || digits.starts_with("0X")) digits.remove_prefix(2);
        when.extended = digits.size() == 8;
        const auto id = parse_number(digits, 16, when.extended ? 0x1FFFFFFF : 0x7FF);
        if (!id || (digits.size() != 3 && digits.size() != 8)) {
            return fail(
                "write an identifier of 3 hexadecimal digits (standard, up to 7FF) or 8 "
                "(extended, up to 1FFFFFFF), or \"from\", \"attempt\" or \"at\"");
        }
        when.id = static_cast<std::uint32_t>(*id);
        ++next_;
        return true;
    }

    bool attempts(InFrame& when) {
        const std::string_view text = word();
        const std::size_t dots = text.find("..");
        const std::string_view first = text.substr(0, std::min(dots, text.size()));
        const std::string_view last =
            dots == std::string_view::npos ? first : text.substr(dots + 2);
        const auto from = parse_number(first, 10, UINT64_MAX - 1);
        const auto to = parse_number(last, 10, UINT64_MAX - 1);
        if (!from || !to || *from == 0 || *to < *from) {
            return fail(
                "write which attempt, counted from 1, such as 3, or from which to which, "
                "such as 1..16");
        }
        when.first_attempt = *from;
        when.last_attempt = *to;
        ++next_;
        return true;
    }

    bool place(FramePlace& result) {
        const std::string_view text = word();
        const std::size_t point = text.find('.');
        const PlaceName* entry = look_up(places, text.substr(0, std::min(point, text.size())));
        if (entry == nullptr) {
            std::string known;
            for (const PlaceName& each : places) {
                if (!known.empty()) known += ", ";
                known += each.text;
                if (each.numbers > 0) known += ".N";
            }
            return fail("write a place in the frame here: " + known);
        }
        result.field = entry->field;
        result.number = 1;
        if (entry->numbers == 0) {
            if (point != std::string_view::npos) {
                return fail("write " + std::string{entry->text} +
                            " without a number: it is one bit");
            }
        } else {
            const auto number = point == std::string_view::npos
                                    ? std::nullopt
                                    : parse_number(text.substr(point + 1), 10, entry->numbers);
            if (!number || *number == 0) {
                return fail("write " + std::string{entry->text} + ".1 to " +
                            std::string{entry->text} + "." + std::to_string(entry->numbers));
            }
            result.number = static_cast<std::uint16_t>(*number);
        }
        ++next_;
        return true;
    }

    bool bit_error_rate(Fault& fault) {
        const auto probability = parse_probability(word());
        if (!probability) {
            return fail(
                "write a rate above 0 and up to 1, such as 1e-5 or 0.001, with at most 18 "
                "digits after the point");
        }
        ++next_;
        fault.trigger = AtRandom{*probability};
        fault.kind = FaultKind::flip;
        fault.duration = FaultTime{1, true};
        return targets(fault.targets, true);
    }

    bool action(Fault& fault) {
        const Keyword* keyword = look_up(actions, word());
        if (keyword == nullptr) {
            return fail(
                "write what happens here: flip, dominant, recessive, stuck-dominant, cut-off "
                "or reconnect");
        }
        ++next_;
        fault.kind = keyword->kind;
        const bool is_about_nodes =
            fault.kind == FaultKind::cut_off || fault.kind == FaultKind::reconnect;
        if (!targets(fault.targets, !is_about_nodes)) return false;
        const bool is_one_bit = fault.kind == FaultKind::flip ||
                                fault.kind == FaultKind::dominant ||
                                fault.kind == FaultKind::recessive;
        if (is_one_bit) fault.duration = FaultTime{1, true};
        if (fault.kind == FaultKind::reconnect || !take("for")) return true;
        FaultTime duration;
        if (!positive_time(duration)) return false;
        fault.duration = duration;
        return true;
    }

    bool targets(FaultTargets& result, bool wire_allowed) {
        if (is_next("wire")) {
            if (!wire_allowed) return fail("write which nodes, not the wire");
            ++next_;
            result.scope = FaultTargets::Scope::wire;
            return true;
        }
        if (take("each-node")) {
            result.scope = FaultTargets::Scope::each_node;
            return true;
        }
        result.scope = FaultTargets::Scope::named;
        const std::string_view first_choices =
            wire_allowed ? "wire, each-node or " : "each-node or ";
        do {
            std::string node;
            if (!name(node, result.names.empty() ? first_choices : "")) return false;
            result.names.push_back(std::move(node));
        } while (take(","));
        return true;
    }

    /// `others` may be there as well.
    bool name(std::string& result, std::string_view others = "") {
        if (peek() == nullptr || is_next(",") || is_reserved(word())) {
            return fail("write " + std::string{others} + "a node's name here" +
                        (is_reserved(word()) ? " (in quotes if that is its name)" : ""));
        }
        result = std::string{peek()->text};
        const bool quoted = peek()->quoted;
        ++next_;
        if (!quoted) behind_bare_name_ = next_;
        return true;
    }

    std::string_view line_;
    std::size_t number_;
    FaultScript& script_;
    bool& has_seed_;
    std::vector<Token> tokens_;
    std::size_t next_ = 0;
    std::size_t behind_bare_name_ = 0;  ///< the token after the last name without quotes
    std::size_t end_column_ = 1;
    std::optional<FaultScriptError> error_;
};

}  // namespace

Duration FaultTime::at(std::uint32_t bitrate) const {
    std::uint64_t nanoseconds = amount;
    if (in_bits) nanoseconds = amount / bitrate * second + amount % bitrate * second / bitrate;
    return Duration{static_cast<Duration::rep>(nanoseconds)};
}

std::string place_name(FramePosition position) {
    using Field = FramePlace::Field;
    const auto numbered = [&](std::string_view text, unsigned first = 1) {
        return std::string{text} + '.' + std::to_string(first + position.index);
    };
    const auto in_script = [&](Field field, unsigned first = 1) {
        const PlaceName& place =
            *std::find_if(places.begin(), places.end(),
                          [&](const PlaceName& each) { return each.field == field; });
        return place.numbers > 0 ? numbered(place.text, first) : std::string{place.text};
    };
    switch (position.field) {
        case FrameField::start_of_frame:
            return in_script(Field::start_of_frame);
        case FrameField::identifier:
            return in_script(Field::identifier);
        case FrameField::remote_request:
        case FrameField::extended_remote_request:
            return in_script(Field::remote_request);
        case FrameField::identifier_extension:
            return in_script(Field::identifier_extension);
        case FrameField::extended_identifier:
            return in_script(Field::identifier, 12);
        case FrameField::reserved_1:
            return in_script(Field::reserved_1);
        case FrameField::reserved_0:
            return in_script(Field::reserved_0);
        case FrameField::data_length_code:
            return in_script(Field::data_length_code);
        case FrameField::data:
            return in_script(Field::data);
        case FrameField::crc:
            return in_script(Field::crc);
        case FrameField::crc_delimiter:
            return in_script(Field::crc_delimiter);
        case FrameField::ack_slot:
            return in_script(Field::ack_slot);
        case FrameField::ack_delimiter:
            return in_script(Field::ack_delimiter);
        case FrameField::end_of_frame:
            return in_script(Field::end_of_frame);
        case FrameField::intermission:
            return in_script(Field::intermission);
        case FrameField::suspend_transmission:
            return numbered("suspend");
        case FrameField::active_error_flag:
            return numbered("active-error-flag");
        case FrameField::passive_error_flag:
            return numbered("passive-error-flag");
        case FrameField::error_superposition:
            return "error-superposition";
        case FrameField::error_delimiter:
            return numbered("error-delimiter");
        case FrameField::overload_flag:
            return numbered("overload-flag");
        case FrameField::overload_delimiter:
            return numbered("overload-delimiter");
        case FrameField::idle:
            return "idle";
    }
    return "?";
}

std::string format(const FaultScriptError& error) {
    return std::to_string(error.line) + ":" + std::to_string(error.column) + ": " + error.message;
}

Result<FaultScript, std::vector<FaultScriptError>> parse_fault_script(std::string_view text) {
    FaultScript script;
    std::vector<FaultScriptError> errors;
    bool has_seed = false;
    for (std::size_t number = 1; !text.empty() && errors.size() <= max_fault_script_errors;
         ++number) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        std::string_view line = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        if (line.ends_with('\r')) line.remove_suffix(1);
        LineParser parser{line, number, script, has_seed};
        auto error = parser.parse();
        if (!error) continue;
        if (errors.size() == max_fault_script_errors) error->message = "and more errors";
        errors.push_back(std::move(*error));
    }
    if (!errors.empty()) return Failure{std::move(errors)};
    return script;
}

}  // namespace canorb::can::sim
