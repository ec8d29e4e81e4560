#pragma once

#include <memory>
#include <string>
#include <vector>

#include "orb/base/result.hpp"
#include "tools/console/model.hpp"

namespace canorb::console {

/// Where the types of what is called come from.
struct IdlFiles {
    std::vector<std::string> json;         ///< what canorb-idlc --emit json wrote
    std::vector<std::string> idl;          ///< compiled by canorb-idlc now
    std::vector<std::string> directories;  ///< where they find what they include

    bool any() const { return !json.empty() || !idl.empty(); }
};

/// Reads and compiles them. The error is a sentence for people; where the compiler found errors in
/// a file, it has told of them itself.
Result<std::unique_ptr<Model>, std::string> load(const IdlFiles& files);

}  // namespace canorb::console
