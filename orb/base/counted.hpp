#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace canorb {

/// "1 frame", "2 frames".
inline std::string counted(std::uint64_t count, std::string_view thing) {
    return std::to_string(count) + ' ' + std::string{thing} + (count == 1 ? "" : "s");
}

}  // namespace canorb
