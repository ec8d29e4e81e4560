// What the segmenter cuts, the reassembler puts together; and what the bus does to the frames in
// between never makes a wrong message.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <map>
#include <random>
#include <vector>

#include "orb/caniop/reassembler.hpp"
#include "orb/caniop/segmenter.hpp"
#include "tests/caniop/test_format.hpp"

namespace canorb::caniop {
namespace {

using testing::ElementsAre;
using Octets = std::vector<std::uint8_t>;

constexpr Identifier from_5{true, 3, 5};

// Every octet depends on the message and on its place, so no two places can be taken for another.
Octets make_message(std::size_t length, unsigned seed) {
    std::minstd_rand random(seed + 1);
    Octets message(length);
    for (auto& octet : message) octet = static_cast<std::uint8_t>(random() >> 8);
    message[0] = 0x10;
    write_be16(&message[1], static_cast<std::uint16_t>(length - 3));
    return message;
}

std::vector<can::Frame> cut(Identifier identifier, const Octets& message) {
    std::vector<can::Frame> frames;
    for (std::size_t i = 0; i < frame_count(message.size()); ++i) {
        frames.push_back(cut_frame(identifier, message, i));
    }
    return frames;
}

class Receiver {
  public:
    void receive(const std::vector<can::Frame>& frames) {
        for (const can::Frame& frame : frames) {
            const auto identifier = Identifier::from_can_id(frame.id);
            const Reception reception =
                reassembler_.accept(*identifier, frame.payload(), TimePoint{});
            if (const auto* message = std::get_if<Message>(&reception)) {
                messages.emplace_back(message->octets.begin(), message->octets.end());
            }
        }
    }

    std::vector<Octets> messages;
    Counters counters;

  private:
    Reassembler reassembler_{{}, test::message_format, counters};
};

// 1 to 5 frames, short and full last ones; continuation numbers that wrap once and twice.
const std::size_t lengths[] = {8, 9, 15, 16, 22, 23, 29, 30, 36, 908, 1000, 1900};

TEST(FrameFaults, ADoubledFrameChangesNothing) {
    for (const std::size_t length : lengths) {
        const Octets message = make_message(length, 1);
        const Octets next = make_message(length, 2);
        for (std::size_t i = 0; i < frame_count(length); ++i) {
            auto frames = cut(from_5, message);
            frames.insert(frames.begin() + static_cast<std::ptrdiff_t>(i), frames[i]);
            Receiver receiver;
            receiver.receive(frames);
            receiver.receive(cut(from_5, next));
            if (length <= 8) {
                // CANIOP cannot tell it from two equal messages; the request_id does.
                EXPECT_THAT(receiver.messages, ElementsAre(message, message, next));
            } else {
                EXPECT_THAT(receiver.messages, ElementsAre(message, next)) << length << ' ' << i;
                EXPECT_EQ(receiver.counters[Counter::duplicate_frames], 1U);
            }
        }
    }
}

TEST(FrameFaults, ALostFrameLosesTheMessageAndNoOther) {
    for (const std::size_t length : lengths) {
        const Octets next = make_message(length, 2);
        for (std::size_t i = 0; i < frame_count(length); ++i) {
            auto frames = cut(from_5, make_message(length, 1));
            frames.erase(frames.begin() + static_cast<std::ptrdiff_t>(i));
            Receiver receiver;
            receiver.receive(frames);
            receiver.receive(cut(from_5, next));
            EXPECT_THAT(receiver.messages, ElementsAre(next)) << length << ' ' << i;
        }
    }
}

TEST(FrameFaults, SwappedFramesLoseTheMessageAndNoOther) {
    for (const std::size_t length : lengths) {
        const Octets next = make_message(length, 2);
        for (std::size_t i = 0; i + 1 < frame_count(length); ++i) {
            auto frames = cut(from_5, make_message(length, 1));
            std::swap(frames[i], frames[i + 1]);
            Receiver receiver;
            receiver.receive(frames);
            receiver.receive(cut(from_5, next));
            EXPECT_THAT(receiver.messages, ElementsAre(next)) << length << ' ' << i;
        }
    }
}

TEST(FrameFaults, AFrameOfTheNextMessageAtTheWrongPlaceMakesNoWrongMessage) {
    // The first frame of the next message before the last of this one, where the numbers differ.
    const Octets message = make_message(22, 1);
    const Octets next = make_message(30, 2);
    auto frames = cut(from_5, message);
    const auto more = cut(from_5, next);
    frames.insert(frames.end(), more.begin(), more.end());
    std::swap(frames[2], frames[3]);
    Receiver receiver;
    receiver.receive(frames);
    EXPECT_TRUE(receiver.messages.empty());
    receiver.receive(cut(from_5, next));
    EXPECT_THAT(receiver.messages, ElementsAre(next));
}

// Three senders at once, each with its own order of messages; the bus interleaves their frames at
// random. In the second half every other message of a sender suffers one fault.
TEST(FrameFaults, RandomMessagesOfSeveralSenders) {
    std::mt19937 random(20240607);
    const auto below = [&](std::size_t n) {
        return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
    };
    constexpr Identifier identifiers[] = {{true, 3, 5}, {true, 3, 6}, {false, 3, 5}};

    for (const bool faults : {false, true}) {
        Counters counters;
        Reassembler reassembler({}, test::message_format, counters);
        std::deque<can::Frame> frames[3];
        std::deque<Octets> expected[3];
        std::size_t awaited = 0;
        std::size_t received = 0;
        for (unsigned i = 0; i < 3000; ++i) {
            const std::size_t sender = i % 3;
            const std::size_t length = 3 + below(below(10) == 0 ? 2000 : 60);
            const Octets message = make_message(length, i);
            auto cut_frames = cut(identifiers[sender], message);
            const bool faulty = faults && (i / 3) % 2 == 0 && cut_frames.size() > 1;
            const auto at = static_cast<std::ptrdiff_t>(below(cut_frames.size()));
            const std::size_t fault = faulty ? below(3) : 3;
            if (fault == 0) cut_frames.erase(cut_frames.begin() + at);
            if (fault == 1) {
                const can::Frame again = *(cut_frames.begin() + at);
                cut_frames.insert(cut_frames.begin() + at, again);
            }
            if (fault == 2) {
                const auto other = at == 0 ? 1 : at - 1;
                std::swap(*(cut_frames.begin() + at), *(cut_frames.begin() + other));
            }
            if (fault == 1 || fault == 3) {
                expected[sender].push_back(message);
                ++awaited;
            }
            frames[sender].insert(frames[sender].end(), cut_frames.begin(), cut_frames.end());
        }
        while (!frames[0].empty() || !frames[1].empty() || !frames[2].empty()) {
            const std::size_t sender = below(3);
            if (frames[sender].empty()) continue;
            const can::Frame frame = frames[sender].front();
            frames[sender].pop_front();
            const Reception reception =
                reassembler.accept(identifiers[sender], frame.payload(), TimePoint{});
            const auto* message = std::get_if<Message>(&reception);
            if (message == nullptr) continue;
            ASSERT_FALSE(expected[sender].empty());
            ASSERT_EQ(Octets(message->octets.begin(), message->octets.end()),
                      expected[sender].front());
            expected[sender].pop_front();
            ++received;
        }
        EXPECT_EQ(received, awaited);
        EXPECT_EQ(counters[Counter::messages_received], awaited);
        EXPECT_EQ(counters[Counter::duplicate_frames] > 0, faults);
    }
}

}  // namespace
}  // namespace canorb::caniop
