#pragma once

#include <atomic>
#include <cstddef>

namespace canorb::test {

/// Calls of operator new so far, in a program made by canorb_add_allocation_test().
extern std::atomic<std::size_t> allocations;

}  // namespace canorb::test
