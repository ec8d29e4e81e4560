#include "node_a.hpp"

#include <fmt/format.h>

#include <utility>
#include <variant>

#include "groups.hpp"
#include "messages.hpp"

namespace tank {

NodeA::NodeA(canorb::Orb& orb, OperatorLine& line, Outputs outputs)
    : orb_(orb),
      line_(line),
      outputs_(std::move(outputs)),
      measurement_object_(orb.root_poa().activate_object(measurement_)),
      round_(orb.group_reference(round_group).narrow<Tank::Round>()),
      actuation_(orb.group_reference(actuation_group).narrow<Tank::Actuation>()),
      clock_(orb.now(), default_slot_length) {
    orb_.object_join(measurement_object_, measurement_group);
    timer_ = orb_.at(clock_.end(), [this] { on_timer(); });
}

NodeA::~NodeA() {
    orb_.cancel(timer_);
    orb_.root_poa().deactivate_object(*measurement_object_.index());
}

void NodeA::on_timer() {
    const std::uint64_t round = clock_.round();
    // Slots that went by unseen are left out: they belong to others by now.
    do {
        clock_.advance();
    } while (clock_.end() <= orb_.now());
    timer_ = orb_.at(clock_.end(), [this] { on_timer(); });
    if (clock_.round() != round) begin_round();
    enter_slot();
}

void NodeA::begin_round() {
    level_.reset();
    decided_ = false;
    status_.round = clock_.round();
    status_.slot_length = in_ms(clock_.length());
    show();
}

void NodeA::enter_slot() {
    switch (clock_.slot()) {
        case slot::sync:
            if (in_time()) send_sync();
            break;
        case slot::control:
            control();
            break;
        case slot::actuation:
            // Without a decision in this round there is nothing to send: an old one may be wrong.
            if (decided_ && in_time()) send_inlet();
            break;
        case slot::apply:
            line_.write(status_text(status_) + "\r\n");
            break;
        case slot::slot_duration:
            take_order();
            if (in_time()) send_slot_duration();
            break;
        default:
            break;
    }
}

void NodeA::control() {
    const Mode mode = mode_at(status_.temperature_c);
    if (mode != status_.mode) {
        status_.mode = mode;
        say(fmt::format("{} C: {} mode", status_.temperature_c,
                        mode == Mode::normal ? "normal" : "alarm"));
    }
    const unsigned missed_before = controller_.rounds_without_level();
    status_.wanted = controller_.decide(
        {level_, status_.reported.inlet_open, status_.setpoint_cm, status_.temperature_c});
    decided_ = true;

    const unsigned missed = controller_.rounds_without_level();
    if (missed == 1) say("no level in this round");
    if (missed == Controller::rounds_without_level_limit)
        say(fmt::format("no level for {} rounds: both valves ordered closed", missed));
    if (missed == 0 && missed_before > 0) say("the level is back");
    if (level_) status_.level_mm = level_;
    status_.level_stale = !level_;
    show();
}

void NodeA::send_sync() {
    transmit([this](auto timeout) { round_.with_timeout(timeout).sync(); });
}

// The three values of slot 5 go one after the other: each when the frames before it are confirmed.

void NodeA::send_inlet() {
    transmit([this](auto timeout) {
        actuation_.with_timeout(timeout)
            .with_sent(when_sent(&NodeA::send_outlet))
            .inlet(position(status_.wanted.inlet_open));
    });
}

void NodeA::send_outlet() {
    transmit([this](auto timeout) {
        actuation_.with_timeout(timeout)
            .with_sent(when_sent(&NodeA::send_temperature))
            .outlet(position(status_.wanted.outlet_open));
    });
}

void NodeA::send_temperature() {
    transmit([this](auto timeout) {
        actuation_.with_timeout(timeout).temperature(
            static_cast<std::int16_t>(status_.temperature_c));
    });
}

void NodeA::send_slot_duration() {
    transmit([this](auto timeout) {
        const auto length = in_ms(clock_.next_length()).count();
        round_.with_timeout(timeout).slot_duration(static_cast<std::uint16_t>(length));
    });
}

void NodeA::take_order() {
    std::optional<char> character = line_.read();
    while (character && is_line_end(*character)) character = line_.read();
    if (!character) return;
    if (const std::optional<Order> order = parse_order(*character)) {
        std::visit([this](const auto& known) { carry_out(known); }, *order);
    } else {
        say(fmt::format("{} is no order", printable(*character)));
    }
    show();
}

void NodeA::carry_out(const SetpointOrder& order) {
    status_.setpoint_cm = order.cm;
    say(fmt::format("setpoint {} cm", order.cm));
}

void NodeA::carry_out(const SlotOrder& order) {
    const std::uint32_t bitrate = orb_.link_capabilities().bitrate;
    if (!slot_fits(order.length, bitrate)) {
        say(fmt::format("slots of {} ms refused: at {} bit/s they are too short",
                        order.length.count(), bitrate));
        return;
    }
    clock_.set_next_length(order.length);
    say(fmt::format("slots of {} ms from the next round on", order.length.count()));
}

bool NodeA::in_time() const {
    return orb_.now() - clock_.start() <=
           latest_start(clock_.length(), orb_.link_capabilities().bitrate);
}

canorb::SentCallback NodeA::when_sent(void (NodeA::*next)()) {
    return [self = std::weak_ptr(self_), next, slot_end = clock_.end()] {
        const std::shared_ptr<NodeA*> locked = self.lock();
        if (!locked) return;
        NodeA& node = **locked;
        // What does not fit into the slot any more is not sent at all.
        const std::uint32_t bitrate = node.orb_.link_capabilities().bitrate;
        if (node.orb_.now() + value_length(bitrate) <= slot_end) (node.*next)();
    };
}

// Makes a call that may wait for the bus until the slot ends, and is withdrawn then. The bus may be
// out of order: this node goes on, and its calls work again when the bus does.
template <typename Call>
void NodeA::transmit(Call call) {
    try {
        call(clock_.end() - orb_.now());
        transmission_failed_ = false;
    } catch (const canorb::SystemException& exception) {
        if (!transmission_failed_) say(exception.what());
        transmission_failed_ = true;
    }
}

// To the operator as well: he asked, or ought to know.
void NodeA::say(std::string_view text) {
    line_.write(fmt::format("{}\r\n", text));
    if (outputs_.log) outputs_.log(text);
}

void NodeA::show() {
    if (outputs_.display) outputs_.display(status_);
}

}  // namespace tank
