#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "idlc/model.hpp"

/// What becomes of nodes that were built from an older version of an IDL file, when others are
/// built from a newer one. The rules, one by one, are in doc/evolution.md.
namespace canorb::idlc::compat {

enum class Severity : std::uint8_t {
    breaks,   ///< old and new nodes misread each other, or calls fail that did not
    careful,  ///< fails only where the new possibility is used, or means something else
    safe,     ///< old nodes go on as before
};

struct Rule {
    std::string_view name;  ///< "operation-removed"
    Severity severity;
};

/// All there are, as in doc/evolution.md.
std::span<const Rule> rules();

struct Finding {
    std::string_view rule;
    Severity severity;
    std::optional<model::Provenance> old_place;  ///< nothing: not there in the old version
    std::optional<model::Provenance> new_place;  ///< nothing: not there in the new version
    std::string text;                            ///< what happens, in a sentence or two
};

/// Whatever differs on the wire between the two, in the order of the old version's definitions,
/// then what the new one adds. Both models are without errors.
std::vector<Finding> compare(const model::Model& old_version, const model::Model& new_version);

/// For people, the worst first, with a line that counts them at the end.
std::string format(const std::vector<Finding>& findings);

/// Whether a finding breaks deployed nodes.
bool any_breaks(const std::vector<Finding>& findings);

}  // namespace canorb::idlc::compat
