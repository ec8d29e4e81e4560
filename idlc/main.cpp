// canorb-idlc: the IDL compiler.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "idlc/compile.hpp"
#include "idlc/emit/emit.hpp"
#include "idlc/preprocess.hpp"

namespace {

namespace fs = std::filesystem;
using namespace canorb::idlc;

struct Options {
    std::vector<std::string> files;
    std::string output_directory = ".";
    std::string depfile;
    PreprocessorOptions preprocessor;
    bool check_only = false;
    bool print_ids = false;
};

/// What to compile, as make wants to know it.
struct Dependencies {
    std::vector<std::string> outputs;
    std::vector<std::string> inputs;
};

bool fail(const std::string& file, const std::string& problem) {
    std::cerr << file << ": " << problem << '\n';
    return false;
}

std::optional<std::string> read_file(const std::string& name) {
    std::ifstream file{name, std::ios::binary};
    if (!file) return std::nullopt;
    return std::string{std::istreambuf_iterator<char>{file}, {}};
}

/// Leaves a file alone that has the content already, so that nothing is built again for it.
bool write_file(const fs::path& name, const std::string& content) {
    if (read_file(name) == content) return true;
    std::ofstream file{name, std::ios::binary | std::ios::trunc};
    file << content;
    file.close();
    return file ? true : fail(name, "cannot be written");
}

std::string escape_for_make(const std::string& name) {
    std::string escaped;
    for (const char c : name) {
        if (c == ' ' || c == '#') escaped += '\\';
        if (c == '$') escaped += '$';
        escaped += c;
    }
    return escaped;
}

bool write_depfile(const std::string& name, const Dependencies& dependencies) {
    std::string text;
    for (const std::string& output : dependencies.outputs) text += escape_for_make(output) + ' ';
    text += ':';
    for (const std::string& input : dependencies.inputs) text += " \\\n  " + escape_for_make(input);
    return write_file(name, text + '\n');
}

bool write_code(const std::string& file, const model::Model& model, const Options& options,
                Dependencies& dependencies) {
    const std::string stem = fs::path{file}.stem();
    const emit::GeneratedCode code = emit::generate(model, stem);
    const fs::path directory{options.output_directory};
    std::error_code error;
    fs::create_directories(directory, error);
    if (error) return fail(directory, error.message());
    dependencies.outputs.push_back(directory / (stem + ".hpp"));
    dependencies.outputs.push_back(directory / (stem + ".cpp"));
    return write_file(directory / (stem + ".hpp"), code.header) &&
           write_file(directory / (stem + ".cpp"), code.source);
}

bool compile_file(const std::string& file, const Options& options, Dependencies& dependencies) {
    if (fs::is_directory(file)) return fail(file, "is a directory");
    const auto original = read_file(file);
    if (!original) return fail(file, "no such file, or not readable");
    const Preprocessed preprocessed = preprocess(file, options.preprocessor);
    std::cerr << preprocessed.message;
    if (!preprocessed.ok) return false;

    Source source{file, preprocessed.text};
    for (const std::string& name : source.files()) {
        // Names like <built-in> are no files.
        if (name.starts_with('<')) continue;
        if (const auto text = read_file(name)) source.add_original(name, *text);
        dependencies.inputs.push_back(name);
    }
    Diagnostics diagnostics;
    const model::Model model = compile(source, diagnostics);
    std::cerr << format(diagnostics, source);
    if (diagnostics.failed()) return false;
    if (options.print_ids) std::cout << model::operation_table(model);
    if (options.check_only || options.print_ids) return true;
    return write_code(file, model, options, dependencies);
}

}  // namespace

int main(int argc, char** argv) {
    constexpr int usage_error = 2;
    Options options;
    CLI::App app{
        "Compiles CORBA IDL to C++ stubs and servants for canorb.\n"
        "FILE.idl becomes FILE.hpp and FILE.cpp."};
    app.add_option("FILE", options.files, "IDL files")->required();
    app.add_flag("--check", options.check_only, "report errors only, write nothing");
    app.add_flag("--print-ids", options.print_ids,
                 "print each interface's operation ids, write nothing");
    app.add_option("-o,--output-dir", options.output_directory,
                   "where to write, made where it does not exist (default: here)");
    app.add_option("-I", options.preprocessor.include_directories,
                   "directory to search for included files")
        ->allow_extra_args(false);
    app.add_option("-D", options.preprocessor.macros, "define a macro: NAME or NAME=VALUE")
        ->allow_extra_args(false);
    app.add_option("--depfile", options.depfile,
                   "write the dependencies there, for make and Ninja");
    app.set_version_flag("--version", std::string{"canorb-idlc "} + CANORB_VERSION);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : usage_error;
    }

    bool ok = true;
    Dependencies dependencies;
    for (const std::string& file : options.files) {
        ok = compile_file(file, options, dependencies) && ok;
    }
    if (ok && !options.depfile.empty()) ok = write_depfile(options.depfile, dependencies);
    return ok ? 0 : 1;
}
