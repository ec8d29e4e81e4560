#include "omniorb_device.hpp"

#include <cstdio>
#include <memory>
#include <stdexcept>

#include "ending_signals.hpp"

namespace peers {

void Device::limits(CORBA::Float& low, CORBA::Float& high) {
    low = 18.0F;
    high = 24.0F;
}

CORBA::Float Device::convert(CORBA::UShort channel) {
    throw Bench::NoSuchChannel{channel};
}

void Device::forbidden() {
    throw CORBA::NO_PERMISSION{0, CORBA::COMPLETED_YES};
}

OmniOrb::OmniOrb(const Options& options) {
    using Option = const char* [2];
    const auto list = std::make_unique<Option[]>(options.size() + 1);
    for (std::size_t i = 0; i < options.size(); ++i) {
        list[i][0] = options[i].first.c_str();
        list[i][1] = options[i].second.c_str();
    }
    int count = 0;
    orb_ = CORBA::ORB_init(count, nullptr, "omniORB4", list.get());
}

OmniOrb::~OmniOrb() {
    try {
        orb_->destroy();
    } catch (const CORBA::Exception& error) {
        std::fprintf(stderr, "omniORB does not end: %s\n", error._name());
    }
}

Bench::Device_var OmniOrb::serve(const char* key) {
    const CORBA::Object_var object = orb_->resolve_initial_references("omniINSPOA");
    const PortableServer::POA_var poa = PortableServer::POA::_narrow(object);
    const PortableServer::Servant_var<Device> servant = new Device;
    const PortableServer::ObjectId_var id = PortableServer::string_to_ObjectId(key);
    poa->activate_object_with_id(id, servant);
    const PortableServer::POAManager_var manager = poa->the_POAManager();
    manager->activate();
    return servant->_this();
}

Bench::Device_var OmniOrb::device(const std::string& reference) {
    const CORBA::Object_var object = orb_->string_to_object(reference.c_str());
    Bench::Device_var device = Bench::Device::_narrow(object);
    if (CORBA::is_nil(device)) throw std::runtime_error("the reference is not a device's");
    return device;
}

std::string OmniOrb::to_string(Bench::Device_ptr device) {
    const CORBA::String_var text = orb_->object_to_string(device);
    return text.in();
}

void serve_until_signal(const OmniOrb::Options& options) {
    OmniOrb orb{options};
    const Bench::Device_var device = orb.serve(object_key);
    std::printf("%s\n", orb.to_string(device).c_str());
    std::fflush(stdout);
    wait_for_ending_signal();
}

}  // namespace peers
