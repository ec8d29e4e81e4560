// Any octets as a value that the console shows: what is shown, written as an argument, is shown in
// the same way again.
// The first octet chooses the type, the others are the value.

#include <cstddef>
#include <cstdint>

#include "tests/fuzz/console_model.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace canorb;
    using namespace canorb::console;
    if (size == 0) return 0;
    const Operation& op = fuzz::operation(data[0]);
    const auto text = fuzz::decoded(op, Bytes{data + 1, size - 1});
    if (!text) return 0;
    for (const char c : *text) fuzz::require(static_cast<unsigned char>(c) >= ' ' && c != 0x7F);
    // A text in quotes would be another one, and an any may be of a type that has no name here.
    const bool is_json = text->front() == '{' || text->front() == '[';
    const auto octets = is_json ? fuzz::encoded(op, *text)
                                : Result<std::vector<std::uint8_t>, std::string>{Failure{*text}};
    if (octets) fuzz::require(fuzz::decoded(op, *octets) == text);
    return 0;
}
