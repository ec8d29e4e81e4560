#include "omniorb_sizes.hpp"

#include <functional>
#include <stdexcept>
#include <vector>

#include "child_process.hpp"
#include "octets.hpp"
#include "omniorb_device.hpp"
#include "recording_proxy.hpp"

namespace peers {

namespace {

using nlohmann::ordered_json;

struct Operation {
    const char* key;
    bool oneway;
    /// Whether the result is the expected one.
    std::function<bool(Bench::Device_ptr)> call;
};

bool is_refused(Bench::Device_ptr device) {
    try {
        device->forbidden();
        return false;
    } catch (const CORBA::NO_PERMISSION& error) {
        return error.minor() == 0 && error.completed() == CORBA::COMPLETED_YES;
    }
}

bool is_unknown(Bench::Device_ptr device, CORBA::UShort channel) {
    try {
        device->convert(channel);
        return false;
    } catch (const Bench::NoSuchChannel& error) {
        return error.channel == channel;
    }
}

bool load(Bench::Device_ptr device) {
    Bench::Block block;
    block.length(256);
    for (CORBA::ULong i = 0; i < block.length(); ++i) {
        block[i] = static_cast<CORBA::Octet>(i * 7 % 256);
    }
    device->load(block);
    return true;
}

bool limits(Bench::Device_ptr device) {
    CORBA::Float low = 0;
    CORBA::Float high = 0;
    device->limits(low, high);
    return low == 18.0F && high == 24.0F;
}

/// A call of which the octets are all that is of interest.
std::function<bool(Bench::Device_ptr)> done(std::function<void(Bench::Device_ptr)> call) {
    return [call = std::move(call)](Bench::Device_ptr device) {
        call(device);
        return true;
    };
}

std::vector<Operation> operations(Bench::Device_ptr own) {
    using Target = Bench::Device_ptr;
    std::string name;
    for (int i = 0; i < 8; ++i) name += "abcdefgh";
    return {
        {"ping", false, done([](Target d) { d->ping(); })},
        {"set_attribute_ul", false,
         done([](Target d) { d->SetAttributeValueUL("TemperatureSetPoint", 7, 1500); })},
        {"read", false, [](Target d) { return d->read() == 21.5F; }},
        {"push", true, done([](Target d) { d->push(1025, 21.5F); })},
        {"get_level", false, [](Target d) { return d->level() == 0.75F; }},
        {"set_level", false, done([](Target d) { d->level(0.75F); })},
        {"status", false, [](Target d) { return d->status() == Bench::running; }},
        {"rename_64", false, done([name](Target d) { d->rename(name.c_str()); })},
        {"load_256", false, load},
        {"limits", false, limits},
        {"user_exception", false, [](Target d) { return is_unknown(d, 9); }},
        {"system_exception", false, is_refused},
        {"attach_nil", false, done([](Target d) { d->attach(Bench::Device::_nil()); })},
        {"attach_reference", false, done([own](Target d) { d->attach(own); })},
    };
}

std::size_t octets_of(const std::vector<Octets>& messages) {
    std::size_t sum = 0;
    for (const auto& message : messages) sum += message.size();
    return sum;
}

ordered_json list_of(const std::vector<Octets>& messages) {
    auto list = ordered_json::array();
    for (const auto& message : messages) {
        ordered_json entry{{"type", message_type(message)}};
        entry.update(to_json(message));
        list.push_back(std::move(entry));
    }
    return list;
}

void require(bool condition, const std::string& what) {
    if (!condition) throw std::runtime_error(what);
}

/// The recorded call as JSON. After a oneway call, a ping has been made: what the server sends
/// between is its answer to that one.
ordered_json call(const Operation& operation, Bench::Device_ptr device, RecordingProxy& proxy) {
    const std::string key = operation.key;
    require(operation.call(device), key + ": not the expected result");
    if (operation.oneway) device->ping();
    const auto recorded = proxy.take();
    const std::size_t replies = 1;
    const std::size_t requests = operation.oneway ? 2 : 1;
    require(recorded.to_server.size() == requests && recorded.to_client.size() == replies,
            key + ": not one request and one reply");
    require(message_type(recorded.to_server[0]) == "Request" &&
                message_type(recorded.to_client[0]) == "Reply",
            key + ": neither request nor reply");
    ordered_json result;
    result["request"] = to_json(recorded.to_server[0]);
    result["reply"] = operation.oneway ? ordered_json(nullptr) : to_json(recorded.to_client[0]);
    return result;
}

ordered_json first_call_extra(const RecordingProxy::Recording& first,
                              const RecordingProxy::Recording& next) {
    return {{"request", octets_of(first.to_server) - octets_of(next.to_server)},
            {"reply", octets_of(first.to_client) - octets_of(next.to_client)},
            {"to_server", list_of(first.to_server)},
            {"to_client", list_of(first.to_client)}};
}

}  // namespace

ordered_json giop_sizes(const std::string& version) {
    const TemporaryDirectory directory;
    const std::string path = (directory.path() / "server").string();
    RecordingProxy proxy{path};
    // omniORB tells clients of a TCP port elsewhere only if it listens on one itself.
    Child server{{own_program(), "server", "--giop", version, "--endpoint", "giop:unix:" + path,
                  "--endpoint", "giop:tcp:127.0.0.1:", "--publish",
                  "giop:tcp:127.0.0.1:" + std::to_string(proxy.port())}};
    const std::string reference = server.read_line();

    OmniOrb orb{{{"maxGIOPVersion", version}, {"endPoint", "giop:tcp:127.0.0.1:"}}};
    const Bench::Device_var own = orb.serve(object_key);
    const Bench::Device_var device = orb.device(reference);
    device->ping();
    const auto first = proxy.take();
    device->ping();
    const auto next = proxy.take();

    const Octets& message = next.to_server.at(0);
    const std::string used = std::to_string(message[4]) + "." + std::to_string(message[5]);
    require(used == version, "the ORB speaks GIOP " + used);

    ordered_json result;
    result["object_key"] = object_key;
    result["first_call_extra"] = first_call_extra(first, next);
    for (const auto& operation : operations(own)) {
        throw_if_interrupted();
        result["operations"][operation.key] = call(operation, device, proxy);
    }
    return result;
}

}  // namespace peers
