#include "tests/support/allocations.hpp"

#include <cstdlib>
#include <new>

std::atomic<std::size_t> canorb::test::allocations{0};

// Not inlined: gcc would take malloc() and delete for a mismatch.
[[gnu::noinline]] void* operator new(std::size_t size) {
    ++canorb::test::allocations;
    if (void* memory = std::malloc(size)) return memory;
    std::abort();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
    std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
