#include "orb/can/record/vcd_writer.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

namespace canorb::can {
namespace {

constexpr std::size_t longest_name = 48;
constexpr std::string_view declaration_start = "$var wire 1 ";
constexpr std::string_view declaration_end = "_tx $end\n";
constexpr std::size_t longest_code = 3;
constexpr std::size_t declaration_octets =
    declaration_start.size() + longest_code + 1 + longest_name + declaration_end.size();
constexpr std::size_t initial_value_octets = 1 + longest_code + 1;

/// The identifier code that stands for a wire: "A", ..., "z", "AA", ...
std::string code_of(std::size_t number) {
    constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";
    std::string code;
    ++number;
    while (number > 0) {
        --number;
        code.insert(code.begin(), letters[number % letters.size()]);
        number /= letters.size();
    }
    assert(code.size() <= longest_code);
    return code;
}

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

bool is_letter(char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
}

std::string legal_name(std::string_view name, sim::NodeIndex node) {
    if (name.empty()) return "node_" + std::to_string(static_cast<unsigned>(node));
    std::string result{name.substr(0, longest_name)};
    for (char& c : result) {
        if (!is_letter(c) && !is_digit(c)) c = '_';
    }
    // An identifier of Verilog does not begin with a digit.
    if (is_digit(result.front())) result = '_' + result.substr(0, longest_name - 1);
    return result;
}

/// "$end" would end the section that the text is in.
std::string without_keywords(std::string text) {
    std::replace(text.begin(), text.end(), '$', '_');
    return text;
}

std::string padded(std::string line, std::size_t octets) {
    assert(line.size() <= octets && line.back() == '\n');
    line.insert(line.size() - 1, octets - line.size(), ' ');
    return line;
}

std::string declaration(std::string_view code, std::string_view name) {
    std::string line{declaration_start};
    line += code;
    line += ' ';
    line += name;
    line += " $end\n";
    return line;
}

}  // namespace

VcdWriter::Wire::Wire(std::size_t number)
    : code(code_of(number)), changes{'0' + code + '\n', '1' + code + '\n'} {}

Result<std::unique_ptr<VcdWriter>, std::string> VcdWriter::create(const std::string& path,
                                                                  const VcdOptions& options) {
    auto file = RecordFile::create(path);
    if (!file) return Failure{file.error()};
    if (!file->seekable()) {
        return Failure{"cannot write a VCD to " + path + ": it must be a file, not a pipe"};
    }
    std::unique_ptr<VcdWriter> writer{new VcdWriter{std::move(*file), options}};
    if (!writer->error().empty()) return Failure{writer->error()};
    return writer;
}

VcdWriter::VcdWriter(RecordFile file, const VcdOptions& options)
    : file_(std::move(file)),
      start_(options.start),
      room_(options.room),
      bus_(0),
      end_(options.start),
      written_(options.start) {
    write_header(options);
}

VcdWriter::~VcdWriter() {
    flush();
}

void VcdWriter::write_header(const VcdOptions& options) {
    const auto room = [this](std::size_t octets) {
        std::string lines;
        for (std::size_t i = 0; i < 2 * room_; ++i) lines += padded("\n", octets);
        return lines;
    };
    std::string header;
    header += "$version canorb $end\n";
    if (!options.comment.empty()) {
        header += "$comment " + without_keywords(options.comment) + " $end\n";
    }
    header += "$timescale 1 ns $end\n";
    header += "$scope module can $end\n";
    header += declaration(bus_.code, "bus");
    declarations_at_ = header.size();
    header += room(declaration_octets);
    header += "$upscope $end\n";
    header += "$enddefinitions $end\n";
    header += "#0\n";
    header += "$dumpvars\n";
    header += bus_.changes[1];
    initial_values_at_ = header.size();
    header += room(initial_value_octets);
    header += "$end\n";
    file_.append(header);
    file_.flush();
}

void VcdWriter::node_attached(sim::NodeIndex node, std::string_view name) {
    const auto index = static_cast<std::size_t>(node);
    if (index >= lines_of_.size()) lines_of_.resize(index + 1);
    node_detached(node);  // a bus tells an observer of its nodes each time it gets it
    lines_of_[index] = lines_for(legal_name(name, node));
    if (!lines_of_[index]) ++nodes_without_lines_;
}

void VcdWriter::node_detached(sim::NodeIndex node) {
    const auto index = static_cast<std::size_t>(node);
    if (index >= lines_of_.size() || !lines_of_[index]) return;
    Lines& lines = lines_[*lines_of_[index]];
    set(lines.tx, 1, end_);
    set(lines.rx, 1, end_);
    lines.attached = false;
    lines_of_[index].reset();
}

std::optional<VcdWriter::LinesIndex> VcdWriter::lines_for(std::string_view wanted) {
    std::string name{wanted};
    for (std::size_t number = 2;; ++number) {
        const auto found = std::find_if(lines_.begin(), lines_.end(),
                                        [&](const Lines& lines) { return lines.name == name; });
        if (found == lines_.end()) break;
        if (!found->attached) {
            found->attached = true;
            return static_cast<LinesIndex>(found - lines_.begin());
        }
        const std::string suffix = '_' + std::to_string(number);
        name = std::string{wanted.substr(0, longest_name - suffix.size())} + suffix;
    }
    if (lines_.size() == room_) return std::nullopt;
    const LinesIndex index = lines_.size();
    lines_.push_back({std::move(name), Wire{1 + 2 * index}, Wire{2 + 2 * index}});
    declare(index);
    return index;
}

void VcdWriter::declare(LinesIndex index) {
    const Lines& lines = lines_[index];
    file_.overwrite(declarations_at_ + 2 * index * declaration_octets,
                    padded(declaration(lines.tx.code, lines.name + "_tx"), declaration_octets) +
                        padded(declaration(lines.rx.code, lines.name + "_rx"), declaration_octets));
    file_.overwrite(initial_values_at_ + 2 * index * initial_value_octets,
                    padded(lines.tx.changes[1], initial_value_octets) +
                        padded(lines.rx.changes[1], initial_value_octets));
}

void VcdWriter::bit(const sim::BusBit& bit) {
    assert(bit.start >= end_ && bit.driven.size() == bit.seen.size());
    if (bit.start > end_) set_all_recessive(end_);
    set(bus_, bit.bus, bit.start);
    const std::size_t nodes = std::min(bit.driven.size(), lines_of_.size());
    for (std::size_t node = 0; node < nodes; ++node) {
        if (!lines_of_[node]) continue;
        Lines& lines = lines_[*lines_of_[node]];
        set(lines.tx, bit.driven[node], bit.start);
        set(lines.rx, bit.seen[node], bit.start);
    }
    end_ = bit.end;
}

void VcdWriter::set_all_recessive(TimePoint time) {
    set(bus_, 1, time);
    for (Lines& lines : lines_) {
        set(lines.tx, 1, time);
        set(lines.rx, 1, time);
    }
}

void VcdWriter::set(Wire& wire, std::uint8_t level, TimePoint time) {
    if (level == wire.level) return;
    wire.level = level;
    write_time(time);
    file_.append(wire.changes[level]);
}

void VcdWriter::write_time(TimePoint time) {
    if (time <= written_) return;
    written_ = time;
    file_.append('#' + std::to_string((time - start_).count()) + '\n');
}

void VcdWriter::flush() {
    write_time(end_);  // without it a reader would not know how long the last level lasted
    file_.flush();
}

}  // namespace canorb::can
