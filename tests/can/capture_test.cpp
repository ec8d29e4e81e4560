// Arbitration-lost capture and error code capture, as an SJA1000 has them (data sheet, 6.4.5 and
// 6.4.6).

#include <gtest/gtest.h>

#include "tests/can/bus_fixture.hpp"
#include "tests/can/flip.hpp"

namespace canorb::can::sim::test {
namespace {

FramePosition in(FrameField field, int index = 0) {
    return {field, static_cast<std::uint8_t>(index), false};
}

FramePosition stuff_after(FrameField field, int index = 0) {
    return {field, static_cast<std::uint8_t>(index), true};
}

// ---- arbitration lost

class ArbitrationLostCapture : public WithFidelity {
  protected:
    /// Where the loser lost.
    int lost(const Frame& loser, const Frame& winner) {
        loser_.must_send(loser);
        winner_.must_send(winner);
        run_until_quiet(bus_);
        loser_.drain();
        winner_.drain();
        EXPECT_EQ(frames_.size(), 2U);
        if (frames_.size() == 2) {
            EXPECT_EQ(frames_[0].frame, winner);
            EXPECT_EQ(frames_[0].lost_arbitrations, 1U);
            EXPECT_EQ(frames_[1].frame, loser);
            EXPECT_EQ(frames_[1].lost_arbitrations, 0U);
        }
        frames_.clear();
        EXPECT_FALSE(bus_.statistics(winner_.node()).arbitration_lost_at);
        return bus_.statistics(loser_.node()).arbitration_lost_at.value_or(99);
    }

    TestNode loser_{bus_};
    TestNode winner_{bus_};
};
CANORB_WITH_BOTH_FIDELITIES(ArbitrationLostCapture);

// With stuff bits all over, and with few.
constexpr std::uint32_t patterns[] = {0, 0x1FFFFFFF, 0x15555555, 0x0AAAAAAA};

TEST_P(ArbitrationLostCapture, Is0To10InAStandardIdentifier) {
    for (const std::uint32_t pattern : patterns) {
        for (int bit = 0; bit <= 10; ++bit) {
            const std::uint32_t weight = 1U << (10 - bit);
            const std::uint32_t id = pattern & 0x7FF & ~weight;
            EXPECT_EQ(lost(standard(id | weight), standard(id)), bit) << pattern;
        }
    }
    EXPECT_EQ(bus_.statistics(loser_.node()).lost_arbitrations, 4U * 11U);
    EXPECT_EQ(bus_.statistics(winner_.node()).lost_arbitrations, 0U);
}

TEST_P(ArbitrationLostCapture, Is0To10InTheUpperBitsOfAnExtendedIdentifier) {
    for (const std::uint32_t pattern : patterns) {
        for (int bit = 0; bit <= 10; ++bit) {
            const std::uint32_t weight = 1U << (28 - bit);
            const std::uint32_t id = pattern & ~weight;
            EXPECT_EQ(lost(extended(id | weight), extended(id)), bit) << pattern;
            EXPECT_EQ(lost(extended(id | weight), standard(id >> 18)), bit) << pattern;
            EXPECT_EQ(lost(standard((id | weight) >> 18), extended(id)), bit) << pattern;
        }
    }
}

TEST_P(ArbitrationLostCapture, Is11AtSrrAndAtTheRtrOfAStandardFrame) {
    for (const std::uint32_t pattern : patterns) {
        const std::uint32_t base = pattern >> 18;
        EXPECT_EQ(lost(remote(standard(base)), standard(base)), 11) << pattern;
        EXPECT_EQ(lost(extended(pattern), standard(base)), 11) << pattern;
        EXPECT_EQ(lost(remote(extended(pattern)), standard(base)), 11) << pattern;
    }
}

TEST_P(ArbitrationLostCapture, Is12AtIde) {
    for (const std::uint32_t pattern : patterns) {
        const std::uint32_t base = pattern >> 18;
        EXPECT_EQ(lost(extended(pattern), remote(standard(base))), 12) << pattern;
        EXPECT_EQ(lost(remote(extended(pattern)), remote(standard(base))), 12) << pattern;
    }
}

TEST_P(ArbitrationLostCapture, Is13To30InTheLowerBitsOfAnExtendedIdentifier) {
    for (const std::uint32_t pattern : patterns) {
        for (int bit = 13; bit <= 30; ++bit) {
            const std::uint32_t weight = 1U << (30 - bit);
            const std::uint32_t id = pattern & ~weight;
            EXPECT_EQ(lost(extended(id | weight), extended(id)), bit) << pattern;
        }
    }
}

TEST_P(ArbitrationLostCapture, Is31AtTheRtrOfAnExtendedFrame) {
    for (const std::uint32_t pattern : patterns) {
        EXPECT_EQ(lost(remote(extended(pattern)), extended(pattern)), 31) << pattern;
    }
}

TEST_P(ArbitrationLostCapture, EachOfManyLosersHasItsOwn) {
    TestNode third{bus_};
    TestNode fourth{bus_};
    winner_.must_send(standard(0x000));
    loser_.must_send(standard(0x001));
    third.must_send(standard(0x040));
    fourth.must_send(extended(0x00000000));
    bus_.advance_one();
    EXPECT_EQ(bus_.statistics(winner_.node()).arbitration_lost_at, std::nullopt);
    EXPECT_EQ(bus_.statistics(loser_.node()).arbitration_lost_at, 10);
    EXPECT_EQ(bus_.statistics(third.node()).arbitration_lost_at, 4);
    EXPECT_EQ(bus_.statistics(fourth.node()).arbitration_lost_at, 11);
    run_until_quiet(bus_);
    ASSERT_EQ(frames_.size(), 4U);
    EXPECT_EQ(frames_[0].lost_arbitrations, 3U);
    EXPECT_EQ(frames_[1].lost_arbitrations, 2U);
    EXPECT_EQ(frames_[2].lost_arbitrations, 1U);
    EXPECT_EQ(frames_[3].lost_arbitrations, 0U);
    EXPECT_EQ(frames_[1].frame, extended(0x00000000));
}

// ---- error code

constexpr bool transmitting = true;
constexpr bool receiving = false;

TEST(ErrorCodeCapture, HasTheKindInItsUpperTwoBits) {
    const auto code = [](ErrorKind kind) {
        return sja1000_error_code({kind, in(FrameField::data), transmitting});
    };
    EXPECT_EQ(code(ErrorKind::bit), 0b00'0'01010);
    EXPECT_EQ(code(ErrorKind::form), 0b01'0'01010);
    EXPECT_EQ(code(ErrorKind::stuff), 0b10'0'01010);
    EXPECT_EQ(code(ErrorKind::crc), 0b11'0'01010);
    EXPECT_EQ(code(ErrorKind::acknowledgment), 0b11'0'01010);
}

TEST(ErrorCodeCapture, HasTheDirectionInBit5) {
    EXPECT_EQ(sja1000_error_code({ErrorKind::bit, in(FrameField::crc), transmitting}), 0x08);
    EXPECT_EQ(sja1000_error_code({ErrorKind::bit, in(FrameField::crc), receiving}), 0x28);
}

TEST(ErrorCodeCapture, HasTheSegmentInItsLowerFiveBits) {
    const auto segment = [](FrameField field, int index = 0) {
        return int{sja1000_error_code({ErrorKind::bit, in(field, index), transmitting})};
    };
    EXPECT_EQ(segment(FrameField::start_of_frame), 0b00011);
    EXPECT_EQ(segment(FrameField::identifier, 0), 0b00010) << "ID.28 to ID.21";
    EXPECT_EQ(segment(FrameField::identifier, 7), 0b00010);
    EXPECT_EQ(segment(FrameField::identifier, 8), 0b00110) << "ID.20 to ID.18";
    EXPECT_EQ(segment(FrameField::identifier, 10), 0b00110);
    EXPECT_EQ(segment(FrameField::remote_request), 0b00100) << "SRTR";
    EXPECT_EQ(segment(FrameField::identifier_extension), 0b00101);
    EXPECT_EQ(segment(FrameField::extended_identifier, 0), 0b00111) << "ID.17 to ID.13";
    EXPECT_EQ(segment(FrameField::extended_identifier, 4), 0b00111);
    EXPECT_EQ(segment(FrameField::extended_identifier, 5), 0b01111) << "ID.12 to ID.5";
    EXPECT_EQ(segment(FrameField::extended_identifier, 12), 0b01111);
    EXPECT_EQ(segment(FrameField::extended_identifier, 13), 0b01110) << "ID.4 to ID.0";
    EXPECT_EQ(segment(FrameField::extended_identifier, 17), 0b01110);
    EXPECT_EQ(segment(FrameField::extended_remote_request), 0b01100);
    EXPECT_EQ(segment(FrameField::reserved_1), 0b01101);
    EXPECT_EQ(segment(FrameField::reserved_0), 0b01001);
    EXPECT_EQ(segment(FrameField::data_length_code, 3), 0b01011);
    EXPECT_EQ(segment(FrameField::data, 63), 0b01010);
    EXPECT_EQ(segment(FrameField::crc, 14), 0b01000);
    EXPECT_EQ(segment(FrameField::crc_delimiter), 0b11000);
    EXPECT_EQ(segment(FrameField::ack_slot), 0b11001);
    EXPECT_EQ(segment(FrameField::ack_delimiter), 0b11011);
    EXPECT_EQ(segment(FrameField::end_of_frame, 6), 0b11010);
    EXPECT_EQ(segment(FrameField::intermission), 0b10010);
    EXPECT_EQ(segment(FrameField::active_error_flag), 0b10001);
    EXPECT_EQ(segment(FrameField::passive_error_flag), 0b10110);
    EXPECT_EQ(segment(FrameField::error_superposition), 0b10011) << "tolerates dominant bits";
    EXPECT_EQ(segment(FrameField::error_delimiter), 0b10111);
    EXPECT_EQ(segment(FrameField::overload_flag), 0b11100);
}

/// A sender and two receivers. What the first and only primary error of a frame is when one node
/// sees one bit the wrong way.
class ErrorCodeOnABus : public testing::Test {
  protected:
    ErrorCodeOnABus() {
        bus_.set_disturbance(&flip_);
        bus_.set_error_trace([this](const NodeError& error) { errors_.push_back(error); });
    }
    ~ErrorCodeOnABus() override { bus_.set_disturbance(nullptr); }

    int code(const Frame& frame, FramePosition position, const TestNode& node) {
        flip_.at(position, node.node());
        errors_.clear();
        sender_.must_send(frame);
        run_until_quiet(bus_);
        for (TestNode* each : {&sender_, &receiver_, &other_}) each->drain();
        EXPECT_FALSE(errors_.empty());
        if (errors_.empty()) return -1;
        EXPECT_TRUE(errors_[0].primary);
        EXPECT_EQ(errors_[0].node, node.node());
        EXPECT_EQ(frame, receiver_.received.back().frame) << "it is repeated";
        return sja1000_error_code(errors_[0].capture);
    }
    int sender_code(const Frame& frame, FrameField field, int index = 0) {
        return code(frame, in(field, index), sender_);
    }

    Bus bus_{500'000};
    Flip flip_;
    TestNode sender_{bus_};
    TestNode receiver_{bus_};
    TestNode other_{bus_};
    std::vector<NodeError> errors_;
};

TEST_F(ErrorCodeOnABus, OfASender) {
    // 0 10101010101 1 1 010101010101010101 000 00I01 ...: dominant bits that it sees as recessive.
    const Frame frame = extended(0x15555555, "55");
    EXPECT_EQ(sender_code(frame, FrameField::start_of_frame), 0x03);
    EXPECT_EQ(sender_code(frame, FrameField::identifier, 1), 0x02);
    EXPECT_EQ(sender_code(frame, FrameField::identifier, 9), 0x06);
    EXPECT_EQ(sender_code(frame, FrameField::extended_identifier, 0), 0x07);
    EXPECT_EQ(sender_code(frame, FrameField::extended_identifier, 6), 0x0F);
    EXPECT_EQ(sender_code(frame, FrameField::extended_identifier, 14), 0x0E);
    EXPECT_EQ(sender_code(frame, FrameField::extended_remote_request), 0x0C);
    EXPECT_EQ(sender_code(frame, FrameField::reserved_1), 0x0D);
    EXPECT_EQ(sender_code(frame, FrameField::reserved_0), 0x09);
    EXPECT_EQ(sender_code(standard(0x555), FrameField::remote_request), 0x04);
    EXPECT_EQ(sender_code(standard(0x555), FrameField::identifier_extension), 0x05);
    // And any of these.
    EXPECT_EQ(sender_code(frame, FrameField::data_length_code, 3), 0x0B);
    EXPECT_EQ(sender_code(frame, FrameField::data, 0), 0x0A);
    EXPECT_EQ(sender_code(frame, FrameField::data, 7), 0x0A);
    EXPECT_EQ(sender_code(frame, FrameField::crc, 0), 0x08);
    // Fields of fixed form, and an ACK that it does not see.
    EXPECT_EQ(sender_code(frame, FrameField::crc_delimiter), 0x58);
    EXPECT_EQ(sender_code(frame, FrameField::ack_slot), 0xD9);
    EXPECT_EQ(sender_code(frame, FrameField::ack_delimiter), 0x5B);
    EXPECT_EQ(sender_code(frame, FrameField::end_of_frame, 0), 0x5A);
    EXPECT_EQ(sender_code(frame, FrameField::end_of_frame, 6), 0x5A);
}

TEST_F(ErrorCodeOnABus, OfASendersStuffBits) {
    // 0 0000I0001111: recessive, in the arbitration, overwritten.
    EXPECT_EQ(code(standard(0x00F), stuff_after(FrameField::identifier, 3), sender_), 0x82);
    // 0 11111O0000I01: dominant, seen as recessive.
    EXPECT_EQ(code(standard(0x7C1), stuff_after(FrameField::identifier, 4), sender_), 0x02);
    // 0 10101010101 000 00I00: not in the arbitration.
    EXPECT_EQ(code(standard(0x555), stuff_after(FrameField::data_length_code, 1), sender_), 0x0B);
}

TEST_F(ErrorCodeOnABus, OfAReceiver) {
    EXPECT_EQ(code(standard(0x00F), stuff_after(FrameField::identifier, 3), receiver_), 0xA2);
    EXPECT_EQ(code(standard(0x555), stuff_after(FrameField::data_length_code, 1), receiver_), 0xAB);
    // A bit of the identifier that no stuffing shows: the CRC does, at the end of the ACK
    // delimiter.
    EXPECT_EQ(code(standard(0x555), in(FrameField::identifier, 5), receiver_), 0xFB);
    EXPECT_EQ(code(standard(0x555), in(FrameField::crc_delimiter), receiver_), 0x78);
    EXPECT_EQ(code(standard(0x555), in(FrameField::ack_slot), receiver_), 0x39) << "its own ACK";
    EXPECT_EQ(code(standard(0x555), in(FrameField::ack_delimiter), receiver_), 0x7B);
    EXPECT_EQ(code(standard(0x555), in(FrameField::end_of_frame, 5), receiver_), 0x7A);
}

TEST_F(ErrorCodeOnABus, IsInTheStatisticsOfTheNode) {
    EXPECT_EQ(bus_.statistics(receiver_.node()).last_error, std::nullopt);
    flip_.at(in(FrameField::identifier, 5), receiver_.node());
    sender_.must_send(standard(0x555));
    run_until_quiet(bus_);
    const NodeStatistics& receiver = bus_.statistics(receiver_.node());
    EXPECT_EQ(receiver.errors, 1U);
    EXPECT_EQ(receiver.last_error,
              (ErrorCapture{ErrorKind::crc, in(FrameField::ack_delimiter), receiving}));
    // Its flag is in the first bit of EOF.
    const NodeStatistics& sender = bus_.statistics(sender_.node());
    EXPECT_EQ(sender.errors, 1U);
    EXPECT_EQ(sender.last_error,
              (ErrorCapture{ErrorKind::form, in(FrameField::end_of_frame), transmitting}));
    EXPECT_EQ(bus_.statistics().error_frames, 1U);
}

}  // namespace
}  // namespace canorb::can::sim::test
