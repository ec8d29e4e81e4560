#pragma once

#include <cstdint>
#include <string>

#include "canorb/orb.hpp"
#include "operations.hpp"

namespace canorb::bench {

/// Answers as the operations' table in doc/benchmarks.md says.
class DeviceImpl final : public ::Bench::DeviceServant {
  public:
    float level() override { return 0.75F; }
    void level(float) override {}
    void ping() override {}
    void SetAttributeValueUL(const std::string&, std::uint32_t, std::uint32_t) override {}
    float read() override { return 21.5F; }
    void push(std::uint16_t, float) override {}
    ::Bench::State status() override { return ::Bench::State::running; }
    void rename(const std::string&) override {}
    void load(const ::Bench::Block&) override {}
    void limits(float& low, float& high) override {
        low = 18;
        high = 24;
    }
    float convert(std::uint16_t channel) override { throw ::Bench::NoSuchChannel{channel}; }
    void forbidden() override { throw NO_PERMISSION("", Completion::yes); }
    void attach(const ::Bench::Device&) override {}
};

}  // namespace canorb::bench
