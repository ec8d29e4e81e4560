#include "traffic.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <variant>

#include "orb/can/frame_length.hpp"

namespace canorb::bench {
namespace {

constexpr std::size_t prepared_for_each_id = 128;

}  // namespace

DisturbingFrames::DisturbingFrames(std::span<const std::uint32_t> ids, const LongestFrame& longest,
                                   std::mt19937_64& random)
    : random_(random) {
    const auto below = [&random](std::uint64_t limit) { return random() % limit; };
    for (const std::uint32_t id : ids) {
        for (std::size_t i = 0; i < prepared_for_each_id; ++i) {
            const auto octets = static_cast<std::uint8_t>(below(9));
            can::Frame frame;
            switch (below(4)) {
                case 0:
                    frame = longest.find(id, can::Frame::max_classic_payload, random);
                    break;
                case 1:
                    frame = longest.find(id, octets, random);
                    break;
                default: {
                    const bool few = below(2) == 0;
                    frame.id = id;
                    frame.length = octets;
                    for (std::uint8_t j = 0; j < octets; ++j) {
                        const std::uint64_t octet = few ? (below(2) == 0 ? 0 : 0xFF) : below(256);
                        frame.data[j] = static_cast<std::uint8_t>(octet);
                    }
                }
            }
            longest_bits_ = std::max(longest_bits_, can::frame_length(frame));
            frames_.push_back(frame);
        }
    }
}

const can::Frame& DisturbingFrames::next() {
    return frames_[random_() % frames_.size()];
}

void free_mailboxes(can::Controller& controller) {
    while (const auto event = controller.poll()) {
        const auto* result = std::get_if<can::TransmitResult>(&*event);
        if (result != nullptr && result->outcome != can::TransmitOutcome::sent) {
            throw std::runtime_error("a frame was not sent");
        }
    }
}

BusyNode::BusyNode(std::unique_ptr<can::Controller> controller, DisturbingFrames frames)
    : controller_(std::move(controller)), frames_(std::move(frames)) {}

void BusyNode::fill() {
    free_mailboxes(*controller_);
    while (true) {
        const can::SendResult result = controller_->send(frames_.next());
        if (const auto* error = std::get_if<can::SendError>(&result)) {
            if (*error != can::SendError::full) throw std::runtime_error("a frame was refused");
            return;
        }
    }
}

}  // namespace canorb::bench
