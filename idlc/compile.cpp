#include "idlc/compile.hpp"

#include "idlc/check/check.hpp"
#include "idlc/lexer.hpp"
#include "idlc/parse/parser.hpp"

namespace canorb::idlc {

model::Model compile(const Source& source, Diagnostics& diagnostics) {
    const auto tokens = tokenize(source, diagnostics);
    const ast::File file = parse::parse_file(tokens, diagnostics);
    // A file that does not parse would be reported a second time for what is missing from it.
    if (diagnostics.failed()) return {};
    return check::build_model(file, source, diagnostics);
}

void report_obstacles(const model::Model& model, Severity severity, Diagnostics& diagnostics) {
    for (const model::Obstacle& obstacle : model.obstacles) {
        if (severity == Severity::error) {
            diagnostics.error(obstacle.where, obstacle.problem);
        } else {
            diagnostics.warning(obstacle.where, "no code can be generated: " + obstacle.problem);
        }
    }
}

}  // namespace canorb::idlc
