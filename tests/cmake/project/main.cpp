#include "alarm.hpp"
#include "panel.hpp"
#include "units.hpp"

int main() {
    Plant::Panel panel;
    panel.shown = 21.5F;
    const Units::Range range{};
    return panel.shown > range.low && Plant::Alarm::NONE != Plant::Alarm::HOT ? 0 : 1;
}
