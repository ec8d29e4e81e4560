#include "tools/console/node_idl.hpp"

namespace canorb::console {

const std::string_view node_idl_json =
#include "node_idl.inc"
    ;

}  // namespace canorb::console
