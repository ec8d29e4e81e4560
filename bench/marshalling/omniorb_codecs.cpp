// omniORB's side: what the stubs and skeletons that omniidl makes of bench/operations.idl do
// between the argument and the stream (marshalArguments and unmarshalArguments of each call
// descriptor), and its run-time library for exceptions. operations.hh here is omniidl's, with its
// namespace renamed.

#include <omniORB4/CORBA.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string_view>

#include "codec.hpp"
#include "operations.hh"

namespace {

/// A servant to refer to.
class Device final : public POA_Bench::Device {
    CORBA::Float level() override { return 0; }
    void level(CORBA::Float /*value*/) override {}
    void ping() override {}
    void SetAttributeValueUL(const char* /*attrName*/, CORBA::ULong /*idxVal*/,
                             CORBA::ULong /*attrValue*/) override {}
    CORBA::Float read() override { return 0; }
    void push(CORBA::UShort /*id*/, CORBA::Float /*value*/) override {}
    Bench::State status() override { return Bench::stopped; }
    void rename(const char* /*name*/) override {}
    void load(const Bench::Block& /*data*/) override {}
    void limits(CORBA::Float& low, CORBA::Float& high) override { low = high = 0; }
    CORBA::Float convert(CORBA::UShort channel) override { throw Bench::NoSuchChannel{channel}; }
    void forbidden() override { throw CORBA::NO_PERMISSION{}; }
    void attach(Bench::Device_ptr /*peer*/) override {}
};

/// The ORB, running: what marshals strings is its code sets, and references its object table.
class RunningOrb {
  public:
    RunningOrb() {
        const char* options[][2] = {{"endPoint", "giop:tcp:127.0.0.1:"}, {nullptr, nullptr}};
        int count = 0;
        orb_ = CORBA::ORB_init(count, nullptr, "omniORB4", options);
        const CORBA::Object_var object = orb_->resolve_initial_references("RootPOA");
        const PortableServer::POA_var poa = PortableServer::POA::_narrow(object);
        poa->the_POAManager()->activate();
        servant_ = new Device;
        const PortableServer::ObjectId_var id = poa->activate_object(servant_);
        reference_ = servant_->_this();
    }
    ~RunningOrb() { orb_->destroy(); }
    RunningOrb(const RunningOrb&) = delete;
    RunningOrb& operator=(const RunningOrb&) = delete;

    Bench::Device_ptr reference() const { return reference_; }

  private:
    CORBA::ORB_var orb_;
    PortableServer::Servant_var<Device> servant_;
    Bench::Device_var reference_;
};

struct Side {
    RunningOrb orb;
    cdrMemoryStream stream;
    Bench::Block block;
    Bench::State status{};
    Bench::NoSuchChannel no_such_channel;
    CORBA::NO_PERMISSION forbidden;
    Bench::Device_var nil = Bench::Device::_nil();

    /// Marshals with `body(stream)`; the octets.
    template <typename Body>
    std::size_t write(Body body) {
        stream.rewindPtrs();
        hide(stream);
        body(stream);
        hide(stream);
        return stream.bufSize();
    }
    cdrStream& incoming() {
        stream.rewindInputPtr();
        hide(stream);
        return stream;
    }
};

/// As omniORB's server writes it: the repository id, then what the exception itself knows.
void marshal_exception(const CORBA::Exception& exception, cdrStream& stream) {
    int size = 0;
    const char* id = exception._NP_repoId(&size);
    static_cast<CORBA::ULong>(size) >>= stream;
    stream.put_octet_array(reinterpret_cast<const CORBA::Octet*>(id), size);
    exception._NP_marshal(stream);
}

/// The index of a system exception's id among those that omniORB knows, by the comparisons that its
/// GIOP_C::UnMarshallSystemException() makes.
std::size_t index_of_system_exception(const char* id) {
    std::size_t index = 0;
#define COMPARE_ID(name)                                                     \
    if (omni::strMatch(id, "IDL:omg.org/CORBA/" #name ":1.0")) return index; \
    ++index;
    OMNIORB_FOR_EACH_SYS_EXCEPTION(COMPARE_ID)
#undef COMPARE_ID
    return index;
}

void add_calls(Codecs& codecs, const std::shared_ptr<Side>& side, const Values& v) {
    Side& s = *side;
    codecs.add(
        "set_attribute_ul",
        [side, &s, &v] {
            return s.write([&v](cdrStream& stream) {
                stream.marshalString(v.attribute.c_str(), 0);
                v.index >>= stream;
                v.setting >>= stream;
            });
        },
        [&s](auto consume) {
            cdrStream& stream = s.incoming();
            CORBA::String_var attribute = stream.unmarshalString(0);
            CORBA::ULong index;
            CORBA::ULong setting;
            index <<= stream;
            setting <<= stream;
            consume(attribute, index, setting);
        },
        [&v](const CORBA::String_var& attribute, CORBA::ULong index, CORBA::ULong setting) {
            return attribute.in() == v.attribute && index == v.index && setting == v.setting;
        });
    const auto decode_float = [&s](auto consume) {
        cdrStream& stream = s.incoming();
        CORBA::Float value;
        value <<= stream;
        consume(value);
    };
    codecs.add(
        "read", [side, &s, &v] { return s.write([&v](cdrStream& stream) { v.read >>= stream; }); },
        decode_float, [&v](CORBA::Float value) { return value == v.read; });
    codecs.add(
        "push",
        [side, &s, &v] {
            return s.write([&v](cdrStream& stream) {
                v.id >>= stream;
                v.read >>= stream;
            });
        },
        [&s](auto consume) {
            cdrStream& stream = s.incoming();
            CORBA::UShort id;
            CORBA::Float value;
            id <<= stream;
            value <<= stream;
            consume(id, value);
        },
        [&v](CORBA::UShort id, CORBA::Float value) { return id == v.id && value == v.read; });
    codecs.add(
        "level",
        [side, &s, &v] { return s.write([&v](cdrStream& stream) { v.level >>= stream; }); },
        decode_float, [&v](CORBA::Float value) { return value == v.level; });
    codecs.add(
        "status", [side, &s] { return s.write([&s](cdrStream& stream) { s.status >>= stream; }); },
        [&s](auto consume) {
            Bench::State result;
            result <<= s.incoming();
            consume(result);
        },
        [&v](Bench::State status) { return status == static_cast<Bench::State>(v.status); });
    codecs.add(
        "rename_64",
        [side, &s, &v] {
            return s.write([&v](cdrStream& stream) { stream.marshalString(v.name.c_str(), 0); });
        },
        [&s](auto consume) {
            CORBA::String_var name = s.incoming().unmarshalString(0);
            consume(name);
        },
        [&v](const CORBA::String_var& name) { return name.in() == v.name; });
    codecs.add(
        "load_256", [side, &s] { return s.write([&s](cdrStream& stream) { s.block >>= stream; }); },
        [&s](auto consume) {
            Bench::Block_var data = new Bench::Block;
            data.inout() <<= s.incoming();
            consume(data);
        },
        [&v](const Bench::Block_var& data) {
            const CORBA::Octet* octets = data->get_buffer();
            return std::equal(octets, octets + data->length(), v.block.begin(), v.block.end());
        });
    codecs.add(
        "limits",
        [side, &s, &v] {
            return s.write([&v](cdrStream& stream) {
                v.low >>= stream;
                v.high >>= stream;
            });
        },
        [&s](auto consume) {
            cdrStream& stream = s.incoming();
            CORBA::Float low;
            CORBA::Float high;
            low <<= stream;
            high <<= stream;
            consume(low, high);
        },
        [&v](CORBA::Float low, CORBA::Float high) { return low == v.low && high == v.high; });
}

void add_exceptions(Codecs& codecs, const std::shared_ptr<Side>& side, const Values& v) {
    Side& s = *side;
    codecs.add(
        "user_exception",
        [side, &s] {
            return s.write(
                [&s](cdrStream& stream) { marshal_exception(s.no_such_channel, stream); });
        },
        [&s](auto consume) {
            cdrStream& stream = s.incoming();
            const CORBA::String_var id = stream.unmarshalRawString();
            if (!omni::strMatch(id, Bench::NoSuchChannel::_PD_repoId)) return;
            Bench::NoSuchChannel exception;
            exception <<= stream;
            consume(exception);
        },
        [&v](const Bench::NoSuchChannel& exception) { return exception.channel == v.channel; });
    codecs.add(
        "system_exception",
        [side, &s] {
            return s.write([&s](cdrStream& stream) { marshal_exception(s.forbidden, stream); });
        },
        [&s](auto consume) {
            cdrStream& stream = s.incoming();
            const CORBA::String_var id = stream.unmarshalRawString();
            CORBA::ULong minor;
            CORBA::ULong completion;
            minor <<= stream;
            completion <<= stream;
            const std::size_t index = index_of_system_exception(id);
            consume(index, minor, completion);
        },
        [&v](std::size_t index, CORBA::ULong minor, CORBA::ULong completion) {
            return index == index_of_system_exception(v.system_exception.c_str()) &&
                   minor == v.minor && completion == v.completion;
        });
}

void add_references(Codecs& codecs, const std::shared_ptr<Side>& side) {
    Side& s = *side;
    const auto decode = [&s](auto consume) {
        const Bench::Device_var peer = Bench::Device::_unmarshalObjRef(s.incoming());
        consume(peer);
    };
    codecs.add(
        "attach_nil",
        [side, &s] {
            return s.write(
                [&s](cdrStream& stream) { Bench::Device::_marshalObjRef(s.nil, stream); });
        },
        decode, [](const Bench::Device_var& peer) { return CORBA::is_nil(peer); });
    codecs.add(
        "attach_reference",
        [side, &s] {
            return s.write([&s](cdrStream& stream) {
                Bench::Device::_marshalObjRef(s.orb.reference(), stream);
            });
        },
        decode,
        [&s](const Bench::Device_var& peer) { return peer->_is_equivalent(s.orb.reference()); });
}

}  // namespace

Codecs omniorb_codecs(const Values& values) {
    const auto side = std::make_shared<Side>();
    side->block.length(static_cast<CORBA::ULong>(values.block.size()));
    std::copy(values.block.begin(), values.block.end(), side->block.get_buffer());
    side->status = static_cast<Bench::State>(values.status);
    side->no_such_channel.channel = values.channel;
    side->forbidden =
        CORBA::NO_PERMISSION{values.minor, static_cast<CORBA::CompletionStatus>(values.completion)};

    Codecs codecs{values};
    add_calls(codecs, side, values);
    add_exceptions(codecs, side, values);
    add_references(codecs, side);
    return codecs;
}

std::string omniorb_version() {
    return omniORB::versionString();
}
