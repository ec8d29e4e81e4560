#pragma once

#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "orb/can/link/link.hpp"
#include "tests/can/pseudo_terminal.hpp"

namespace canorb::can::test {

/// A LAWICEL adapter on a pseudo-terminal, as the manual describes it, with a node of a local: bus
/// behind it and a thread of its own. It has room for one frame: the next is answered when that one
/// has gone out, or with BEL when that takes long.
class SlcanAdapter {
  public:
    explicit SlcanAdapter(const std::string& bus_address);
    ~SlcanAdapter();
    SlcanAdapter(const SlcanAdapter&) = delete;
    SlcanAdapter& operator=(const SlcanAdapter&) = delete;

    const std::string& device() const { return line_.device(); }
    bool is_in_use() const { return line_.is_in_use(); }
    bool is_open() const;
    bool listens_only() const;

  private:
    enum class Channel { closed, open, listening };

    void run();
    void read_commands();
    void obey(std::string_view command);
    void set_channel(Channel channel);
    void transmit(const Frame& frame);
    void take_events();
    void answer(std::string_view text);
    void write();

    PseudoTerminal line_;
    mutable std::mutex mutex_;
    std::unique_ptr<Controller> controller_;  ///< silent unless the channel is open
    Channel channel_ = Channel::closed;
    bool bitrate_set_ = false;
    bool overrun_ = false;
    std::optional<TransmitHandle> on_its_way_;
    std::optional<Frame> waiting_;  ///< the next one, not answered yet
    TimePoint refuse_at_ = never;
    std::string command_;
    std::string output_;
    Signal stop_;
    std::thread thread_;
};

}  // namespace canorb::can::test
