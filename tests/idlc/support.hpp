#pragma once

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "idlc/compile.hpp"
#include "idlc/diagnostics.hpp"
#include "idlc/preprocess.hpp"
#include "idlc/source.hpp"

namespace canorb::idlc::test {

/// The folder of these tests, where errors/ and golden/ are.
inline const std::filesystem::path data_directory = CANORB_IDLC_TEST_DATA;

inline std::string read_file(const std::filesystem::path& name) {
    std::ifstream file{name, std::ios::binary};
    return {std::istreambuf_iterator<char>{file}, {}};
}

/// With UPDATE_GOLDEN=1 in the environment the expected files are written, not compared: look at
/// what the version control says has changed.
inline bool updating() {
    const char* value = std::getenv("UPDATE_GOLDEN");
    return value != nullptr && std::string{value} == "1";
}

inline std::string expected(const std::filesystem::path& name, const std::string& actual) {
    if (updating()) std::ofstream{name, std::ios::binary} << actual;
    return read_file(name);
}

/// Every .idl file of a folder, by name.
inline std::vector<std::string> idl_files(const std::string& folder) {
    std::vector<std::string> stems;
    for (const auto& entry : std::filesystem::directory_iterator{data_directory / folder}) {
        if (entry.path().extension() == ".idl") stems.push_back(entry.path().stem());
    }
    std::sort(stems.begin(), stems.end());
    return stems;
}

/// An IDL file, as the program compiles it.
struct Compilation {
    /// `file` is relative to the current directory, and is named so in diagnostics.
    explicit Compilation(const std::string& file)
        : preprocessed(preprocess(file, {})), source(file, preprocessed.text) {
        for (const std::string& name : source.files()) {
            if (!name.starts_with('<')) source.add_original(name, read_file(name));
        }
        model = compile(source, diagnostics);
        if (!diagnostics.failed()) report_obstacles(model, Severity::error, diagnostics);
    }

    Preprocessed preprocessed;
    Source source;
    Diagnostics diagnostics;
    model::Model model;
};

/// Text without a file.
struct TextCompilation {
    explicit TextCompilation(const std::string& text) : source("test.idl", text) {
        model = compile(source, diagnostics);
        if (!diagnostics.failed()) report_obstacles(model, Severity::error, diagnostics);
    }

    std::string messages() const { return format(diagnostics, source); }

    Source source;
    Diagnostics diagnostics;
    model::Model model;
};

}  // namespace canorb::idlc::test
