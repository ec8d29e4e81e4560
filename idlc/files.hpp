#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace canorb::idlc {

/// The content of a regular file; nothing where there is none, or it cannot be read.
std::optional<std::string> read_file(const std::string& name);

/// What hinders a file from being written, as text; empty: it was. A file that has the content
/// already is left alone, so that nothing is built again for it; what was written of a file only
/// in part is removed.
std::string write_file(const std::string& name, std::string_view content);

/// "out1 out2: in1 in2" as make and Ninja read it, the inputs a line each.
std::string make_rule(const std::vector<std::string>& outputs,
                      const std::vector<std::string>& inputs);

}  // namespace canorb::idlc
