#include "panel.hpp"

int main() {
    Plant::Panel panel;
    panel.sensors.resize(2);
    panel.sensors[1].range.high = 80.0F;
    return panel.sensors == Plant::Panel{}.sensors ? 1 : 0;
}
