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
    std::string message;  ///< its errors and warnings, as diagnostics are printed; ends its line
};

/// Runs the host's C preprocessor, `cpp`, `gcc -E` or `clang -E`, on the file. Comments and
/// linemarkers stay in the text. An included file is looked for in the directory of the file that
/// includes it, where it is in quotes, then in `include_directories`, and nowhere else; but
/// there is an orb.idl where there is no other, and its name in linemarkers is <orb.idl>.
Preprocessed preprocess(const std::string& file, const PreprocessorOptions& options);

}  // namespace canorb::idlc
