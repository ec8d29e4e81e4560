// Any text through the whole IDL compiler but the preprocessor: it ends, with messages or with
// what is the same each time, and never with a crash.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "idlc/ast.hpp"
#include "idlc/compat.hpp"
#include "idlc/compile.hpp"
#include "idlc/emit/emit.hpp"
#include "idlc/emit/json.hpp"
#include "idlc/lexer.hpp"
#include "idlc/parse/parser.hpp"

namespace {

using namespace canorb::idlc;

struct Compilation {
    explicit Compilation(const std::string& text) : source("fuzz.idl", text) {
        source.add_original("fuzz.idl", text);
        model = compile(source, diagnostics);
        if (!diagnostics.failed()) report_obstacles(model, Severity::error, diagnostics);
    }

    Source source;
    Diagnostics diagnostics;
    model::Model model;
};

/// All that the emitters make of it.
std::vector<std::string> outputs(const model::Model& model) {
    const emit::GeneratedCode code = emit::generate(model, "fuzz");
    return {code.header, code.source, emit::json(model), model::operation_table(model)};
}

void require(bool condition) {
    if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string text(data, data + size);
    const Compilation once{text};
    const std::string messages = format(once.diagnostics, once.source);
    Diagnostics syntax_errors;
    static_cast<void>(
        ast::dump(parse::parse_file(tokenize(once.source, syntax_errors), syntax_errors)));

    // A second compilation has its objects elsewhere in memory.
    const Compilation again{text};
    require(format(again.diagnostics, again.source) == messages);
    if (once.diagnostics.failed()) {
        require(!messages.empty());
        return 0;
    }
    require(!syntax_errors.failed());
    require(outputs(once.model) == outputs(again.model));
    // What did not change breaks nothing.
    require(compat::compare(once.model, again.model).empty());
    return 0;
}
