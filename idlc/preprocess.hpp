#pragma once

#include <string>
#include <vector>

namespace canorb::idlc {

struct PreprocessorOptions {
    std::vector<std::string> include_directories;
    std::vector<std::string> macros;  ///< NAME or NAME=VALUE
};

struct Preprocessed {
    /// False: the preprocessor could not be run or refused the file; `message` says why.
    bool ok = false;
    std::string text;
    std::string message;  ///< what it wrote to standard error; warnings where `ok`
};

/// Runs the host's C preprocessor, `cpp`, on the file. Comments and linemarkers stay in the text.
Preprocessed preprocess(const std::string& file, const PreprocessorOptions& options);

}  // namespace canorb::idlc
