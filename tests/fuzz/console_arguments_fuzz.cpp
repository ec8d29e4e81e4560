// Any text as an argument of the console: what is taken becomes octets that are a value of the
// type. The first octet chooses the type, the others are the text.

#include <cstddef>
#include <cstdint>
#include <string>

#include "tests/fuzz/console_model.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace canorb::console;
    if (size == 0) return 0;
    const Operation& op = fuzz::operation(data[0]);
    const auto octets = fuzz::encoded(op, std::string{data + 1, data + size});
    if (octets) {
        fuzz::require(fuzz::decoded(op, *octets).has_value());
    } else {
        fuzz::require(octets.error().starts_with("argument 1 (x"));
    }
    return 0;
}
