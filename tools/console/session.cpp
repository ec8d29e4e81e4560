#include "tools/console/session.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <thread>

#include "orb/can/link/descriptor.hpp"
#include "tools/console/signals.hpp"

namespace canorb::console {
namespace {

/// What may be behind an exception, for who knows the bus but not the code.
std::string_view hint(SystemErrorKind kind) {
    switch (kind) {
        case SystemErrorKind::timeout:
            return "is the node on the bus, and does it run? --timeout waits longer";
        case SystemErrorKind::object_not_exist:
            return "nothing is active at that index of the node";
        case SystemErrorKind::bad_operation:
            return "the object has no such operation: is this its interface, and the IDL the one "
                   "that it was made from?";
        case SystemErrorKind::marshal:
            return "the two sides were made from different IDL";
        case SystemErrorKind::no_permission:
            return "the node refuses this";
        case SystemErrorKind::transient:
            return "the node is too busy now: try again";
        case SystemErrorKind::imp_limit:
            return "the message is longer than one of the sides takes";
        case SystemErrorKind::unknown:
            return "the servant raised what its IDL does not declare; the node's log says what";
        default:
            return {};
    }
}

int run_guarded(Session& session, const std::function<int(Session&)>& work) {
    try {
        return work(session);
    } catch (const SystemException& exception) {
        if (session.is_closed()) return interrupted;
        return fail(describe(exception), session.is_bus_gone() ? bus_unreachable : call_failed);
    } catch (const std::exception& error) {
        return fail(error.what(), call_failed);
    }
}

}  // namespace

void say(std::string_view sentence) {
    std::fprintf(stderr, "canorb: %.*s\n", static_cast<int>(sentence.size()), sentence.data());
}

int fail(std::string_view sentence, int exit_code) {
    say(sentence);
    return exit_code;
}

void print(std::string_view line) {
    std::fwrite(line.data(), 1, line.size(), stdout);
    std::fputc('\n', stdout);
    std::fflush(stdout);
}

std::string describe(const SystemException& exception) {
    std::string text = exception.what();
    const std::string_view reason = hint(exception.error().kind);
    if (!reason.empty()) text.append(" (").append(reason).append(")");
    return text;
}

Session::Session(Bus& bus, const CommonOptions& common) : common_(common) {
    constexpr Duration most_at_the_end = std::chrono::seconds{1};
    OrbOptions options;
    options.node = common.node;
    options.name = "canorb";
    options.default_timeout = std::min(common.timeout, most_at_the_end);
    options.max_message = 65538;
    options.log = [](std::string_view) {};
    orb_.emplace(bus, std::move(options));
}

ObjectRef Session::object(std::string_view text) {
    const std::lock_guard lock{mutex_};
    if (!orb_) throw BAD_INV_ORDER("interrupted");
    return orb_->string_to_object(text).with_timeout(common_.timeout);
}

bool Session::send_all() {
    const std::lock_guard lock{mutex_};
    if (!orb_) throw BAD_INV_ORDER("interrupted");
    if (!orb_->drain(common_.timeout)) return false;
    const Counters counters = orb_->counters();
    return counters[Counter::messages_expired] + counters[Counter::messages_stopped] +
               counters[Counter::messages_failed] ==
           0;
}

bool Session::is_bus_gone() const {
    const std::lock_guard lock{mutex_};
    if (!orb_) return false;
    const can::ControllerState state = orb_->error_status().state;
    return state == can::ControllerState::stopped || state == can::ControllerState::bus_off;
}

bool Session::is_closed() const {
    const std::lock_guard lock{mutex_};
    return !orb_;
}

void Session::warn_of_duplicate() const {
    const std::lock_guard lock{mutex_};
    if (!orb_ || orb_->counters()[Counter::frames_of_duplicate_node] == 0) return;
    say("another node has the number " + std::to_string(common_.node) +
        ", which this program took: its answers and ours disturb each other. Give a free one with "
        "--node");
}

void Session::close() {
    const std::lock_guard lock{mutex_};
    orb_.reset();
}

int Session::run(const CommonOptions& common, const std::function<int(Session&)>& work) {
    const StopSignals signals;
    std::unique_ptr<Bus> bus;
    std::unique_ptr<Session> session;
    try {
        bus = open_bus(common.bus);
        session.reset(new Session{*bus, common});
    } catch (const BAD_PARAM& exception) {
        return fail(exception.what(), usage_error);
    } catch (const SystemException& exception) {
        return fail(exception.what(), bus_unreachable);
    }
    const can::Signal done;
    int result = success;
    std::thread worker{[&] {
        result = run_guarded(*session, work);
        done.raise();
    }};
    constexpr int soon_ms = 2000;
    auto woken = signals.wait(done.fd(), soon_ms);
    if (woken == StopSignals::Woken::by_time) {
        if (::isatty(STDERR_FILENO) != 0) say("waiting for answers; Ctrl-C ends it");
        woken = signals.wait(done.fd());
    }
    const bool stopped = woken == StopSignals::Woken::by_signal;
    if (stopped) {
        session->close();
    } else {
        session->warn_of_duplicate();
    }
    worker.join();
    return stopped ? interrupted : result;
}

}  // namespace canorb::console
