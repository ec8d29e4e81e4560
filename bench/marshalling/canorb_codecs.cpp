// canorb's side: what its generated stubs and skeletons of bench/operations.idl do between the
// argument and the message, and back.

#include <canorb/orb.hpp>
#include <canorb/simulation.hpp>

#include <algorithm>
#include <memory>

#include "codec.hpp"
#include "operations.hpp"
#include "orb/giop/format.hpp"
#include "orb/giop/system_exception.hpp"

namespace {

using namespace canorb;

/// A message, and what a stub (ClientCall) or a skeleton (ServerCall) keeps of it.
class Message {
  public:
    /// As ClientCall::write() does.
    template <typename... T>
    std::size_t write(const T&... values) {
        begin();
        (encode(out_, values), ...);
        return end();
    }
    /// As ServerCall::raise() does.
    template <typename E>
    std::size_t raise(const E& exception) {
        begin();
        out_.string(E::repository_id);
        encode(out_, exception);
        return end();
    }
    std::size_t fail(const SystemError& error) {
        begin();
        giop::encode(out_, error);
        return end();
    }

    /// As CallReply::read() and ServerCall::read() do.
    template <typename... T>
    void read(T&... values) {
        ccdr::Decoder& in = incoming();
        (decode(in, values), ...);
        check_read();
    }
    ccdr::Decoder& incoming() {
        in_ = received_;
        hide(in_);
        return in_;
    }
    /// What was written last is what is read from now on.
    void receive() { received_ = ccdr::Decoder{out_.octets(), out_.context()}; }
    void check_read() const {
        if (!in_.finished()) throw std::runtime_error{"canorb does not decode what it encoded"};
    }

  private:
    // A stub's encoder is part of an object that others know: it is not kept in registers alone.
    void begin() {
        out_ = empty_;
        hide(out_);
    }
    std::size_t end() {
        hide(out_);
        if (out_.error() != ccdr::EncodeError::none) throw std::runtime_error{"canorb: BAD_PARAM"};
        return out_.size();
    }

    std::vector<std::uint8_t> buffer_ = std::vector<std::uint8_t>(giop::max_message);
    alignas(64) ccdr::Encoder empty_{buffer_};
    alignas(64) ccdr::Encoder out_{empty_};
    alignas(64) ccdr::Decoder received_{Bytes{}};
    alignas(64) ccdr::Decoder in_{Bytes{}};
};

/// A servant to refer to.
class Device final : public Bench::DeviceServant {
    float level() override { return 0; }
    void level(float /*value*/) override {}
    void ping() override {}
    void SetAttributeValueUL(const std::string& /*attrName*/, std::uint32_t /*idxVal*/,
                             std::uint32_t /*attrValue*/) override {}
    float read() override { return 0; }
    void push(std::uint16_t /*id*/, float /*value*/) override {}
    Bench::State status() override { return Bench::State::stopped; }
    void rename(const std::string& /*name*/) override {}
    void load(const Bench::Block& /*data*/) override {}
    void limits(float& low, float& high) override { low = high = 0; }
    float convert(std::uint16_t channel) override { throw Bench::NoSuchChannel{channel}; }
    void forbidden() override { throw NO_PERMISSION{}; }
    void attach(const Bench::Device& /*peer*/) override {}
};

/// What all codecs of this side use. It is never destroyed before them.
struct Side {
    Message message;
    Simulation simulation;
    Orb orb{simulation.add_bus(), {.node = 3}};
    Device device;
    Bench::Block block;
    Bench::State status{};
    Bench::NoSuchChannel no_such_channel;
    SystemError forbidden;
    Bench::Device nil;
    Bench::Device reference;
};

template <typename Encode, typename Decode, typename Check>
void add(Codecs& codecs, Message& message, const char* list, Encode encode, Decode decode,
         Check check) {
    codecs.add(list, encode, decode, check, [&message] { message.receive(); });
}

void add_calls(Codecs& codecs, const std::shared_ptr<Side>& side, const Values& v) {
    Message& m = side->message;
    add(
        codecs, m, "set_attribute_ul",
        [side, &m, &v] { return m.write(v.attribute, v.index, v.setting); },
        [&m](auto consume) {
            std::string attrName;
            std::uint32_t idxVal{};
            std::uint32_t attrValue{};
            m.read(attrName, idxVal, attrValue);
            consume(attrName, idxVal, attrValue);
        },
        [&v](const std::string& attribute, std::uint32_t index, std::uint32_t setting) {
            return attribute == v.attribute && index == v.index && setting == v.setting;
        });
    add(
        codecs, m, "read", [side, &m, &v] { return m.write(v.read); },
        [&m](auto consume) {
            float result{};
            m.read(result);
            consume(result);
        },
        [&v](float result) { return result == v.read; });
    add(
        codecs, m, "push", [side, &m, &v] { return m.write(v.id, v.read); },
        [&m](auto consume) {
            std::uint16_t id{};
            float value{};
            m.read(id, value);
            consume(id, value);
        },
        [&v](std::uint16_t id, float value) { return id == v.id && value == v.read; });
    add(
        codecs, m, "level", [side, &m, &v] { return m.write(v.level); },
        [&m](auto consume) {
            float value{};
            m.read(value);
            consume(value);
        },
        [&v](float value) { return value == v.level; });
    add(
        codecs, m, "status", [side, &m] { return m.write(side->status); },
        [&m](auto consume) {
            Bench::State result{};
            m.read(result);
            consume(result);
        },
        [&v](Bench::State status) { return status == Bench::State{v.status}; });
    add(
        codecs, m, "rename_64", [side, &m, &v] { return m.write(v.name); },
        [&m](auto consume) {
            std::string name;
            m.read(name);
            consume(name);
        },
        [&v](const std::string& name) { return name == v.name; });
    add(
        codecs, m, "load_256", [side, &m] { return m.write(side->block); },
        [&m](auto consume) {
            Bench::Block data;
            m.read(data);
            consume(data);
        },
        [&v](const Bench::Block& data) { return std::ranges::equal(data, v.block); });
    add(
        codecs, m, "limits", [side, &m, &v] { return m.write(v.low, v.high); },
        [&m](auto consume) {
            float low{};
            float high{};
            m.read(low, high);
            consume(low, high);
        },
        [&v](float low, float high) { return low == v.low && high == v.high; });
}

void add_exceptions(Codecs& codecs, const std::shared_ptr<Side>& side, const Values& v) {
    Message& m = side->message;
    add(
        codecs, m, "user_exception", [side, &m] { return m.raise(side->no_such_channel); },
        [&m](auto consume) {
            ccdr::Decoder& in = m.incoming();
            if (in.string() != Bench::NoSuchChannel::repository_id) return;
            Bench::NoSuchChannel exception;
            decode(in, exception);
            m.check_read();
            consume(exception);
        },
        [&v](const Bench::NoSuchChannel& exception) { return exception.channel == v.channel; });
    add(
        codecs, m, "system_exception", [side, &m] { return m.fail(side->forbidden); },
        [&m](auto consume) {
            SystemError error;
            giop::decode(m.incoming(), error);
            m.check_read();
            consume(error);
        },
        [&v](const SystemError& error) {
            return repository_id(error.kind) == v.system_exception && error.minor == v.minor &&
                   error.completion == Completion{static_cast<std::uint8_t>(v.completion)};
        });
}

void add_references(Codecs& codecs, const std::shared_ptr<Side>& side) {
    Message& m = side->message;
    const auto decode = [&m](auto consume) {
        Bench::Device peer;
        m.read(peer);
        consume(peer);
    };
    add(
        codecs, m, "attach_nil", [side, &m] { return m.write(side->nil); }, decode,
        [](const Bench::Device& peer) { return peer.is_nil(); });
    add(
        codecs, m, "attach_reference", [side, &m] { return m.write(side->reference); }, decode,
        [side](const Bench::Device& peer) { return peer == side->reference; });
}

}  // namespace

Codecs canorb_codecs(Values& values) {
    const auto side = std::make_shared<Side>();
    side->block.assign(values.block);
    side->status = Bench::State{values.status};
    side->no_such_channel = Bench::NoSuchChannel{values.channel};
    side->forbidden = {.kind = SystemErrorKind::no_permission,
                       .completion = static_cast<Completion>(values.completion),
                       .minor = values.minor};
    side->reference = Bench::Device{side->orb.root_poa().activate_object_with_id(1, side->device)};
    values.reference = side->orb.object_to_string(side->reference);

    Codecs codecs{values};
    add_calls(codecs, side, values);
    add_exceptions(codecs, side, values);
    add_references(codecs, side);
    return codecs;
}
