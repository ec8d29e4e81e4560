#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "orb/base/bytes.hpp"
#include "orb/base/result.hpp"
#include "tools/console/model.hpp"

namespace canorb::console {

using Json = nlohmann::ordered_json;

/// Values that were sent, each with its name, in the order in which they stand in the message.
using NamedValues = std::vector<std::pair<std::string, Json>>;

// All of these read octets that anybody may have sent. The error is a sentence for people that
// names the value and its type; the octets are then not what the IDL says.

/// The body of a Reply: the result, as "result", then inout and out parameters.
Result<NamedValues, std::string> decode_results(const Operation& operation, Bytes body,
                                                const Model& model);

/// The parameters of a Request: in and inout.
Result<NamedValues, std::string> decode_arguments(const Operation& operation, Bytes parameters,
                                                  const Model& model);

/// The members of a user exception, which follow its id.
Result<NamedValues, std::string> decode_members(const Definition& exception, Bytes octets,
                                                const Model& model);

/// Values as JSON in one line, as arguments take them. What could give orders to a terminal is
/// escaped; texts that are no UTF-8 have U+FFFD for what is none.
std::string to_text(const Json& value);

/// "{speed: 3, name: "left"}".
std::string to_text(const NamedValues& values);

/// In hex.
std::string hex(Bytes octets);

}  // namespace canorb::console
