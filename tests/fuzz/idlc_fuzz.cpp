// Any text through the whole IDL compiler but the preprocessor: it ends, with messages or with
// code that is the same each time, and never with a crash.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "idlc/compile.hpp"
#include "idlc/emit/emit.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace canorb::idlc;
    const Source source{"fuzz.idl", std::string(data, data + size)};
    Diagnostics diagnostics;
    const model::Model model = compile(source, diagnostics);
    const std::string messages = format(diagnostics, source);
    if (diagnostics.failed()) {
        if (messages.empty()) std::abort();
        return 0;
    }
    const emit::GeneratedCode once = emit::generate(model, "fuzz");
    const emit::GeneratedCode twice = emit::generate(model, "fuzz");
    if (once.header != twice.header || once.source != twice.source) std::abort();
    static_cast<void>(model::operation_table(model));
    return 0;
}
