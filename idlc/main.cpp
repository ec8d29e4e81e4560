// canorb-idlc: the IDL compiler.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "idlc/compat.hpp"
#include "idlc/compile.hpp"
#include "idlc/emit/emit.hpp"
#include "idlc/emit/json.hpp"
#include "idlc/files.hpp"
#include "idlc/lexer.hpp"
#include "idlc/parse/parser.hpp"
#include "idlc/preprocess.hpp"
#include "idlc/structure.hpp"

namespace {

namespace fs = std::filesystem;
using namespace canorb::idlc;

constexpr int error_found = 1;
constexpr int usage_error = 2;

/// What a run gives.
enum class Output : std::uint8_t {
    code,
    json,
    dependencies,
    nothing,
    ids,
    hashes,
    tree,
    comparison
};

struct Options {
    std::vector<std::string> files;
    std::string output_directory = ".";
    std::string depfile;
    PreprocessorOptions preprocessor;
    Output output = Output::code;
};

bool fail(const std::string& file, const std::string& problem) {
    std::cerr << file << ": error: " << problem << '\n';
    return false;
}

/// "devices" of dir/devices.idl: what the generated files are called.
std::string stem(const std::string& file) {
    return fs::path{file}.stem();
}

std::vector<std::string> outputs(const std::string& file, const Options& options) {
    const fs::path directory{options.output_directory};
    return {directory / (stem(file) + ".hpp"), directory / (stem(file) + ".cpp")};
}

/// Whether the files to be written have names, each its own, that are not an IDL file's.
bool check_outputs(const Options& options) {
    std::map<std::string, std::string> by_stem;
    for (const std::string& file : options.files) {
        const std::string name = stem(file);
        const bool printable = std::none_of(name.begin(), name.end(), [](char c) {
            return c == '"' || c == '\\' || static_cast<unsigned char>(c) < ' ';
        });
        // ".idl" is all stem.
        if (name.empty() || name == ".idl" || !printable) {
            return fail(file, "what is generated cannot be named after it: rename it");
        }
        const auto [same, added] = by_stem.emplace(name, file);
        if (!added) {
            return fail(file, "would be written to " + outputs(file, options).front() + ", as " +
                                  same->second + " is: compile them with different --output-dir");
        }
        for (const std::string& output : outputs(file, options)) {
            std::error_code ignored;
            if (fs::equivalent(file, output, ignored)) {
                return fail(file, "would be overwritten by what is generated from it");
            }
        }
    }
    return true;
}

/// The file after the preprocessor; null where it cannot be read.
std::unique_ptr<Source> load(const std::string& file, const Options& options) {
    std::error_code error;
    const fs::file_status status = fs::status(file, error);
    if (fs::is_directory(status)) {
        fail(file, "is a directory");
        return nullptr;
    }
    if (fs::exists(status) && !fs::is_regular_file(status)) {
        // It is read twice: by the preprocessor, and to show its lines.
        fail(file, "is not a regular file; write what it gives to one first");
        return nullptr;
    }
    if (!read_file(file)) {
        fail(file, fs::exists(status) ? "is not readable" : "no such file");
        return nullptr;
    }
    Preprocessed preprocessed = preprocess(file, options.preprocessor);
    std::cerr << preprocessed.message;
    if (!preprocessed.ok) return nullptr;
    auto source = std::make_unique<Source>(file, std::move(preprocessed.text));
    for (const std::string& name : source->files()) {
        if (const auto text = read_file(name)) source->add_original(name, *text);
    }
    return source;
}

std::string dependencies(const std::string& file, const Source& source, const Options& options) {
    std::vector<std::string> inputs;
    for (const std::string& name : source.files()) {
        // Names like <built-in> are no files.
        if (!name.starts_with('<')) inputs.push_back(name);
    }
    return make_rule(outputs(file, options), inputs);
}

std::string syntax_tree(const Source& source, Diagnostics& diagnostics) {
    return ast::dump(parse::parse_file(tokenize(source, diagnostics), diagnostics));
}

bool write(const std::string& file, const std::string& content) {
    const std::string problem = write_file(file, content);
    return problem.empty() || fail(file, problem);
}

bool write_code(const std::string& file, const model::Model& model, const Options& options) {
    const emit::GeneratedCode code = emit::generate(model, stem(file));
    std::error_code error;
    fs::create_directories(options.output_directory, error);
    if (error) return fail(options.output_directory, "cannot be made: " + error.message());
    const auto names = outputs(file, options);
    return write(names[0], code.header) && write(names[1], code.source);
}

/// What the file means; nothing where it has errors, which are then told. `obstacles`: what an
/// obstacle to the code for it is.
std::optional<model::Model> compile_file(const Source& source, Severity obstacles) {
    Diagnostics diagnostics;
    model::Model model = compile(source, diagnostics);
    if (!diagnostics.failed()) report_obstacles(model, obstacles, diagnostics);
    std::cerr << format(diagnostics, source);
    if (diagnostics.failed()) return std::nullopt;
    return model;
}

/// "1A2B3C4D Devices::Motor", a line for each interface that the main file defines.
std::string hash_table(const model::Model& model) {
    std::ostringstream text;
    text << std::hex << std::uppercase << std::setfill('0');
    for (const auto& definition : model.storage) {
        if (!definition->in_main_file) continue;
        if (!std::holds_alternative<model::Interface>(definition->body)) continue;
        text << std::setw(8) << structural_hash(*definition) << ' ' << scoped_name(*definition)
             << '\n';
    }
    return text.str();
}

bool compare_files(const Options& options) {
    std::vector<std::unique_ptr<Source>> sources;
    std::vector<model::Model> models;
    for (const std::string& file : options.files) {
        sources.push_back(load(file, options));
        if (sources.back() == nullptr) continue;
        if (auto model = compile_file(*sources.back(), Severity::error))
            models.push_back(*std::move(model));
    }
    if (models.size() != 2) return false;
    const auto findings = compat::compare(models[0], models[1]);
    std::cout << compat::format(findings);
    return !compat::any_breaks(findings);
}

/// `rules` collects what --depfile writes.
bool process(const std::string& file, const Options& options, std::string& rules) {
    const auto source = load(file, options);
    if (source == nullptr) return false;
    if (options.output == Output::dependencies) {
        std::cout << dependencies(file, *source, options);
        return true;
    }
    if (options.output == Output::tree) {
        Diagnostics diagnostics;
        std::cout << syntax_tree(*source, diagnostics);
        std::cerr << format(diagnostics, *source);
        return !diagnostics.failed();
    }
    const bool check_only = options.output == Output::nothing;
    const auto model = compile_file(*source, check_only ? Severity::warning : Severity::error);
    if (!model) return false;
    if (options.output == Output::ids) std::cout << model::operation_table(*model);
    if (options.output == Output::hashes) std::cout << hash_table(*model);
    if (options.output == Output::json) std::cout << emit::json(*model);
    if (options.output != Output::code) return true;
    rules += dependencies(file, *source, options);
    return write_code(file, *model, options);
}

int run(const Options& options) {
    const bool writes = options.output == Output::code;
    if ((writes || options.output == Output::dependencies) && !check_outputs(options)) {
        return usage_error;
    }
    bool ok = true;
    std::string rules;
    if (options.output == Output::comparison) {
        ok = compare_files(options);
    } else {
        for (const std::string& file : options.files) ok = process(file, options, rules) && ok;
    }
    if (ok && !options.depfile.empty()) ok = write(options.depfile, rules);
    if (!std::cout.flush()) ok = fail("standard output", "cannot be written");
    return ok ? 0 : error_found;
}

constexpr const char* description =
    "Compiles CORBA IDL to C++ stubs and servants for canorb: FILE.idl becomes FILE.hpp and\n"
    "FILE.cpp. FILE.hpp includes OTHER.hpp where FILE.idl includes OTHER.idl.";

constexpr const char* footer =
    "The exit code is 0 when all is well, 1 for errors in a file or, of --compat, a change that\n"
    "breaks deployed nodes, 2 for a wrong command line.\n"
    "\n"
    "Examples:\n"
    "  canorb-idlc devices.idl                        writes devices.hpp and devices.cpp here\n"
    "  canorb-idlc -I common -o generated pump.idl    pump.idl includes a file of common/\n"
    "  canorb-idlc --check *.idl                      only says what is wrong\n"
    "  canorb-idlc --compat v1/pump.idl v2/pump.idl   what do nodes with v1 make of v2?\n";

}  // namespace

int main(int argc, char** argv) {
    Options options;
    CLI::App app{description};
    app.footer(footer);
    app.add_option("FILE", options.files, "IDL files")->required();
    app.add_option("-o,--output-dir", options.output_directory,
                   "where to write, made where it does not exist (default: here)");
    app.add_option("-I", options.preprocessor.include_directories,
                   "one more directory to look for included files in, behind that of the file "
                   "that includes")
        ->type_name("DIRECTORY")
        ->allow_extra_args(false);
    app.add_option("-D", options.preprocessor.macros, "define a macro for the C preprocessor")
        ->type_name("NAME[=VALUE]")
        ->allow_extra_args(false);
    auto* depfile = app.add_option("--depfile", options.depfile,
                                   "also write what was read, as rules for make and Ninja");
    auto* what = app.add_option_group("What to do instead of writing C++");
    what->require_option(0, 1);
    const auto add_output = [&](const std::string& flag, Output output, const std::string& text) {
        what->add_flag_callback(flag, [&options, output] { options.output = output; }, text);
    };
    add_output("--check", Output::nothing, "only say what is wrong");
    add_output("--print-ids", Output::ids, "print the operation ids of each interface");
    add_output("--print-hash", Output::hashes,
               "print the structural hash of each interface: nodes with the same one agree");
    add_output("--compat", Output::comparison,
               "say what nodes that were built from the first FILE misread of the second");
    add_output("--dump-ast", Output::tree, "print what was read, as a tree");
    std::string form;
    what->add_option("--emit", form,
                     "print it for other programs: json, all that it means, or deps, the rules\n"
                     "for make that --depfile writes")
        ->type_name("FORM")
        ->check(CLI::IsMember({"json", "deps"}).description(""));
    app.set_version_flag("--version", std::string{"canorb-idlc "} + CANORB_VERSION);
    try {
        app.parse(argc, argv);
        if (form == "json") options.output = Output::json;
        if (form == "deps") options.output = Output::dependencies;
        if (options.output == Output::comparison && options.files.size() != 2) {
            throw CLI::ValidationError("--compat", "needs two files, the old and the new one");
        }
        if (depfile->count() > 0 && options.output != Output::code) {
            throw CLI::ValidationError("--depfile", "there is nothing to depend on what was read");
        }
        for (const std::string& file : options.files) {
            if (file.empty()) throw CLI::ValidationError("FILE", "the name is empty");
            if (file == "-") {
                throw CLI::ValidationError("FILE",
                                           "standard input cannot be compiled: name a file");
            }
        }
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : usage_error;
    }
    return run(options);
}
