#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

namespace canorb::test {

/// How much longer than in the normal run of the tests a long one is to be: 1, or what `./run soak`
/// has set in CANORB_SOAK_FACTOR.
inline std::uint64_t soak_factor() {
    const char* const text = std::getenv("CANORB_SOAK_FACTOR");
    const long long factor = text == nullptr ? 1 : std::atoll(text);
    return factor > 1 ? static_cast<std::uint64_t>(factor) : 1;
}

/// Says how far a long run is, every ten seconds. Nothing of it is asserted.
inline void show_progress(const char* what, std::uint64_t done, std::uint64_t all) {
    using std::chrono::steady_clock;
    static auto last = steady_clock::now();
    if (done % 1024 != 0 || steady_clock::now() - last < std::chrono::seconds{10}) return;
    last = steady_clock::now();
    std::printf("%s: %llu of %llu\n", what, static_cast<unsigned long long>(done),
                static_cast<unsigned long long>(all));
    std::fflush(stdout);
}

}  // namespace canorb::test
