// Fast CDR's side. The structs have the members and the functions that fastddsgen makes of such
// structs in IDL. A DDS reader decodes into samples that it has already, so these are used again.

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastcdr/config.h>

#include <memory>

#include "codec.hpp"

namespace {

using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;

struct SetAttribute {
    std::string attribute;
    std::uint32_t index = 0;
    std::uint32_t setting = 0;

    void serialize(Cdr& out) const {
        out << attribute.c_str();
        out << index;
        out << setting;
    }
    void deserialize(Cdr& in) {
        in >> attribute;
        in >> index;
        in >> setting;
    }
};

struct Float {
    float value = 0;

    void serialize(Cdr& out) const { out << value; }
    void deserialize(Cdr& in) { in >> value; }
};

struct Push {
    std::uint16_t id = 0;
    float value = 0;

    void serialize(Cdr& out) const {
        out << id;
        out << value;
    }
    void deserialize(Cdr& in) {
        in >> id;
        in >> value;
    }
};

enum class State : std::uint32_t { stopped, starting, running, failed };

struct Status {
    State value = State::stopped;

    void serialize(Cdr& out) const { out << static_cast<std::uint32_t>(value); }
    void deserialize(Cdr& in) {
        std::uint32_t number = 0;
        in >> number;
        value = static_cast<State>(number);
    }
};

struct Text {
    std::string value;

    void serialize(Cdr& out) const { out << value.c_str(); }
    void deserialize(Cdr& in) { in >> value; }
};

struct Block {
    std::vector<std::uint8_t> value;

    void serialize(Cdr& out) const { out << value; }
    void deserialize(Cdr& in) { in >> value; }
};

struct Limits {
    float low = 0;
    float high = 0;

    void serialize(Cdr& out) const {
        out << low;
        out << high;
    }
    void deserialize(Cdr& in) {
        in >> low;
        in >> high;
    }
};

struct UserException {
    std::string repository_id;
    std::uint16_t channel = 0;

    void serialize(Cdr& out) const {
        out << repository_id.c_str();
        out << channel;
    }
    void deserialize(Cdr& in) {
        in >> repository_id;
        in >> channel;
    }
};

struct SystemException {
    std::string repository_id;
    std::uint32_t minor = 0;
    std::uint32_t completion = 0;

    void serialize(Cdr& out) const {
        out << repository_id.c_str();
        out << minor;
        out << completion;
    }
    void deserialize(Cdr& in) {
        in >> repository_id;
        in >> minor;
        in >> completion;
    }
};

/// A message of fixed size.
struct Message {
    std::vector<char> octets = std::vector<char>(1024);
    FastBuffer buffer{octets.data(), octets.size()};
    Cdr out{buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR};
    Cdr in{buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR};
};

/// A list of which `sample` has the values.
template <typename Sample, typename Check>
void add(Codecs& codecs, std::string list, const Sample& sample, Check check) {
    struct Side {
        Message message;
        Sample sent;
        Sample received;
    };
    const auto side = std::make_shared<Side>();
    side->sent = sample;
    codecs.add(
        std::move(list),
        [side] {
            side->message.out.reset();
            side->sent.serialize(side->message.out);
            return side->message.out.getSerializedDataLength();
        },
        [side](auto consume) {
            side->message.in.reset();
            side->received.deserialize(side->message.in);
            consume(side->received);
        },
        check);
}

}  // namespace

Codecs fast_cdr_codecs(const Values& v) {
    Codecs codecs{v};
    add(codecs, "set_attribute_ul", SetAttribute{v.attribute, v.index, v.setting},
        [&v](const SetAttribute& got) {
            return got.attribute == v.attribute && got.index == v.index && got.setting == v.setting;
        });
    add(codecs, "read", Float{v.read}, [&v](const Float& got) { return got.value == v.read; });
    add(codecs, "push", Push{v.id, v.read},
        [&v](const Push& got) { return got.id == v.id && got.value == v.read; });
    add(codecs, "level", Float{v.level}, [&v](const Float& got) { return got.value == v.level; });
    add(codecs, "status", Status{State{v.status}},
        [&v](const Status& got) { return got.value == State{v.status}; });
    add(codecs, "rename_64", Text{v.name}, [&v](const Text& got) { return got.value == v.name; });
    add(codecs, "load_256", Block{v.block},
        [&v](const Block& got) { return got.value == v.block; });
    add(codecs, "limits", Limits{v.low, v.high},
        [&v](const Limits& got) { return got.low == v.low && got.high == v.high; });
    add(codecs, "user_exception", UserException{v.user_exception, v.channel},
        [&v](const UserException& got) {
            return got.repository_id == v.user_exception && got.channel == v.channel;
        });
    add(codecs, "system_exception", SystemException{v.system_exception, v.minor, v.completion},
        [&v](const SystemException& got) {
            return got.repository_id == v.system_exception && got.minor == v.minor &&
                   got.completion == v.completion;
        });
    add(codecs, "attach_nil", Text{}, [](const Text& got) { return got.value.empty(); });
    add(codecs, "attach_reference", Text{v.reference},
        [&v](const Text& got) { return got.value == v.reference; });
    return codecs;
}

std::string fast_cdr_version() {
    return FASTCDR_VERSION_STR;
}
