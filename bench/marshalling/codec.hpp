#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "values.hpp"

template <typename T>
inline void hide_one(const T& object) {
    __asm__ volatile("" : : "r"(&object) : "memory");
}

/// The optimizer takes these objects to be read, and all memory to have changed: nothing is
/// computed ahead of the loop, and nothing is left out because nobody looks at it.
template <typename... T>
inline void hide(const T&... objects) {
    (hide_one(objects), ...);
}

/// The processor's time stamp counter; 0 where there is none.
inline std::uint64_t ticks() {
#if defined(__x86_64__)
    return __builtin_ia32_rdtsc();
#else
    return 0;
#endif
}

struct Timing {
    double nanoseconds = 0;  ///< of all repetitions
    std::uint64_t ticks = 0;
};

/// The loop in which everything is measured.
template <typename Body>
Timing time_loop(std::size_t repetitions, const Values& values, Body& body) {
    const auto begin = std::chrono::steady_clock::now();
    const std::uint64_t first = ticks();
    for (std::size_t i = 0; i < repetitions; ++i) {
        hide(values);
        body();
    }
    const std::uint64_t last = ticks();
    const std::chrono::duration<double, std::nano> passed =
        std::chrono::steady_clock::now() - begin;
    return {passed.count(), last - first};
}

/// One side's way with one list of values.
struct Codec {
    std::string list;
    std::size_t octets = 0;  ///< of the encoding
    std::function<Timing(std::size_t repetitions)> encode;
    std::function<Timing(std::size_t repetitions)> decode;
};

/// The codecs of one side, in the order in which they are added.
class Codecs {
  public:
    explicit Codecs(const Values& values) : values_(values) {}

    /// `encode()` gives the octets that it wrote; `decode(consume)` reads what encode wrote last,
    /// and calls consume() with what it read, which `check` compares with the values. Before it is
    /// timed, there is once `receive()`.
    template <typename Encode, typename Decode, typename Check, typename Receive>
    void add(std::string list, Encode encode, Decode decode, Check check, Receive receive) {
        const std::size_t octets = encode();
        receive();
        bool same = false;
        decode([&](const auto&... decoded) { same = check(decoded...); });
        if (!same) throw std::runtime_error{list + ": what was decoded is not what was encoded"};

        Codec codec{std::move(list), octets, {}, {}};
        codec.encode = [&values = values_, encode](std::size_t repetitions) {
            auto body = [&encode] { hide(encode()); };
            return time_loop(repetitions, values, body);
        };
        codec.decode = [&values = values_, encode, receive, decode](std::size_t repetitions) {
            encode();
            receive();
            auto body = [&decode] { decode([](const auto&... decoded) { hide(decoded...); }); };
            return time_loop(repetitions, values, body);
        };
        codecs_.push_back(std::move(codec));
    }

    template <typename Encode, typename Decode, typename Check>
    void add(std::string list, Encode encode, Decode decode, Check check) {
        add(std::move(list), encode, decode, check, [] {});
    }

    const std::vector<Codec>& all() const { return codecs_; }

  private:
    const Values& values_;
    std::vector<Codec> codecs_;
};

/// The sides. What they return refers to `values`, which outlive it.
Codecs canorb_codecs(Values& values);  // sets values.reference
Codecs omniorb_codecs(const Values& values);
Codecs fast_cdr_codecs(const Values& values);

/// The library at run time.
std::string omniorb_version();
std::string fast_cdr_version();
