#include "fastdds_latency.hpp"

#include <exception>

namespace peers {

namespace {

using namespace std::chrono_literals;

/// A run of round trips, one after the other.
class Run {
  public:
    /// Keeps the time of each where TIMES is given.
    Run(Caller& caller, std::size_t count, std::vector<Clock::duration>* times)
        : caller_(caller), count_(count), times_(times) {}

    Clock::duration by_listener() {
        const ReplyHandler handler{caller_, [this](const dds::SampleInfo&) {
                                       keep_time();
                                       if (++done_ == count_ || !try_send()) wake();
                                   }};
        const auto begin = Clock::now();
        send();
        wait_for_wake(20s + 1ms * count_);
        if (failure_) std::rethrow_exception(failure_);
        return Clock::now() - begin;
    }

    Clock::duration by_caller() {
        const ReplyHandler handler{caller_, [this](const dds::SampleInfo&) { wake(); }};
        const auto begin = Clock::now();
        for (; done_ < count_; ++done_) {
            send();
            wait_for_wake(20s);
            keep_time();
        }
        return Clock::now() - begin;
    }

  private:
    void send() {
        if (times_ != nullptr) sent_ = Clock::now();
        caller_.send();
    }

    /// Nothing may be thrown in the reader's thread.
    bool try_send() {
        try {
            send();
            return true;
        } catch (...) {
            failure_ = std::current_exception();
            return false;
        }
    }

    void keep_time() {
        if (times_ != nullptr) times_->push_back(Clock::now() - sent_);
    }

    void wake() {
        const std::lock_guard lock{mutex_};
        woken_ = true;
        changed_.notify_one();
    }

    void wait_for_wake(std::chrono::milliseconds timeout) {
        std::unique_lock lock{mutex_};
        wait_for(changed_, lock, [&] { return woken_; }, timeout, "a reply is lost");
        woken_ = false;
    }

    Caller& caller_;
    std::size_t count_;
    std::vector<Clock::duration>* times_;
    std::size_t done_ = 0;
    Clock::time_point sent_;
    std::mutex mutex_;
    std::condition_variable changed_;
    bool woken_ = false;
    std::exception_ptr failure_;
};

}  // namespace

LatencyResult measure_round_trips(Caller& caller, const std::string& wait,
                                  const RoundTrips& counts) {
    const auto run = [&](std::size_t count, std::vector<Clock::duration>* times) {
        if (count == 0) return Clock::duration{};
        Run all{caller, count, times};
        return wait == "listener" ? all.by_listener() : all.by_caller();
    };
    LatencyResult result;
    result.times.reserve(counts.timed);
    run(counts.warm_up, nullptr);
    run(counts.timed, &result.times);
    result.throughput_time = run(counts.throughput, nullptr);
    return result;
}

}  // namespace peers
