#include "controller_reference.hpp"

#include <fmt/format.h>

namespace plant {

void take_controller_reference(canorb::Orb& orb, const std::string& text,
                               Plant::Controller& controller, const Log& log) {
    try {
        const canorb::ObjectRef reference = orb.string_to_object(text);
        // A group does not answer, and the type is in the reference: nobody needs to be asked.
        if (!reference.node() || reference.type_id() != Plant::Controller::_interface.repository_id)
            return log("initialize: not a controller's reference: " + text);
        if (!controller.is_nil() && reference == controller) return;
        controller = reference.unchecked_narrow<Plant::Controller>();
        log(fmt::format("controller: {}", text));
    } catch (const canorb::SystemException& exception) {
        log(fmt::format("initialize: {}", exception.what()));
    }
}

PanelLine controller_line(const Plant::Controller& controller, bool answers) {
    if (controller.is_nil()) return {Mark::bad, "no controller yet"};
    const std::string text = fmt::format("controller node {}", controller.node()->value());
    return answers ? PanelLine{Mark::none, text} : PanelLine{Mark::bad, text + " is silent"};
}

}  // namespace plant
