#include "canorb/orb.hpp"

#include "orb/runtime/orb_impl.hpp"
#include "orb/services/node_object.hpp"

namespace canorb {

Orb::Orb(Bus& bus, OrbOptions options)
    : impl_(std::make_shared<runtime::OrbImpl>(bus, std::move(options))) {
    if (impl_->options().management_object) {
        impl_->set_management_object(std::make_unique<services::NodeObject>(*impl_));
    }
    impl_->start_workers();
}

Orb::~Orb() {
    impl_->close();
}

std::optional<NodeId> Orb::node() const {
    return impl_->node();
}
void Orb::set_node(int node) {
    impl_->set_node(node);
}
const OrbOptions& Orb::options() const {
    return impl_->options();
}
Poa& Orb::root_poa() {
    return impl_->root_poa();
}

ObjectRef Orb::string_to_object(std::string_view text) {
    return impl_->string_to_object(text);
}

std::string Orb::object_to_string(const ObjectRef& reference) const {
    return impl_->object_to_string(reference);
}

std::string Orb::group_to_string(GroupId group) const {
    return impl_->object_to_string(impl_->group_reference(group));
}

ObjectRef Orb::group_reference(GroupId group) const {
    return impl_->group_reference(group);
}
void Orb::object_join(const ObjectRef& object, GroupId group) {
    impl_->join(object, group);
}
void Orb::object_leave(const ObjectRef& object, GroupId group) {
    impl_->leave(object, group);
}

bool Orb::object_is_member(const ObjectRef& object, GroupId group) const {
    return impl_->is_member(object, group);
}

std::vector<ObjectRef> Orb::group_members(GroupId group) const {
    return impl_->members(group);
}

void Orb::run() {
    impl_->run_until(never);
}
bool Orb::run_for(Duration duration) {
    return impl_->run_until(impl_->after(duration));
}
void Orb::poll() {
    impl_->poll();
}
int Orb::event_fd() {
    return impl_->event_fd();
}
bool Orb::drain(Duration limit) {
    return impl_->drain(limit);
}
void Orb::shutdown() noexcept {
    impl_->shutdown();
}

TimePoint Orb::now() const {
    return impl_->now();
}

TimerId Orb::at(TimePoint time, std::function<void()> callback) {
    return impl_->add_timer(time, Duration::zero(), std::move(callback));
}

TimerId Orb::every(Duration period, std::function<void()> callback) {
    if (period <= Duration::zero())
        throw_system_exception(cause::bad_argument, "a period must be greater than 0");
    return impl_->add_timer(impl_->after(period), period, std::move(callback));
}

void Orb::cancel(TimerId timer) {
    impl_->cancel_timer(timer);
}

void Orb::on_event(std::function<void(const Event&)> callback) {
    impl_->on_event(std::move(callback));
}

void Orb::on_restart(std::function<void()> callback) {
    impl_->on_restart(std::move(callback));
}
void Orb::on_message(std::function<void(const MessageTrace&)> callback) {
    impl_->on_message(std::move(callback));
}

Counters Orb::counters() const {
    return impl_->counters();
}
can::ErrorStatus Orb::error_status() const {
    return impl_->error_status();
}
can::Capabilities Orb::link_capabilities() const {
    return impl_->capabilities();
}
void Orb::recover() {
    impl_->recover();
}

}  // namespace canorb
