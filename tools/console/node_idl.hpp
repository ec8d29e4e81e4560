#pragma once

#include <string_view>

namespace canorb::console {

/// <canorb/node.idl> as `canorb-idlc --emit json` writes it: every node has such an object.
extern const std::string_view node_idl_json;

}  // namespace canorb::console
