#pragma once

#include <string>

#include "idlc/model.hpp"

namespace canorb::idlc::emit {

/// The two generated files. The same model gives the same octets.
struct GeneratedCode {
    std::string header;
    std::string source;
};

/// Code for what the main file itself declares. `stem` is the generated files' name without its
/// ending: the source includes "stem.hpp".
GeneratedCode generate(const model::Model& model, const std::string& stem);

}  // namespace canorb::idlc::emit
