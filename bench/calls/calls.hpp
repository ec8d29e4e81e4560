#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "bench/device.hpp"
#include "canorb/orb.hpp"
#include "orb/can/link/link.hpp"
#include "statistics.hpp"

namespace canorb::bench {

::Bench::Device device_at(Orb& orb, int node);
/// Calls until it answers; throws what the last of many calls threw.
void await(const ::Bench::Device& device);
/// The void call, back to back. A call that fails ends the program.
Statistics time_calls(const ::Bench::Device& device, std::size_t calls);
/// Serves object 1 of this node, for ever.
void serve_device(const std::string& address, int node, int cpu);
void progress(std::string_view what);

nlohmann::json on_the_paced_bus(bool quick);

}  // namespace canorb::bench
