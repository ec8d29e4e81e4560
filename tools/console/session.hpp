#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "canorb/orb.hpp"
#include "tools/console/commands.hpp"

namespace canorb::console {

/// The console as a node of the bus.
///
///     return Session::run(common, [&](Session& session) {
///         session.object("corbaloc:caniop:3/1")._non_existent();
///         return success;
///     });
///
/// Its functions may be called from any thread.
class Session {
  public:
    /// Opens the bus, runs `work` in a thread of its own, and leaves the bus; in good order, too,
    /// when Ctrl-C, SIGTERM or SIGHUP comes meanwhile: calls then throw BAD_INV_ORDER. The exit
    /// code is that of `work`, or the one for what it threw, which is said.
    static int run(const CommonOptions& common, const std::function<int(Session&)>& work);

    /// As Orb::string_to_object(), with the timeout of the options.
    ObjectRef object(std::string_view text);
    /// Waits until all that was called is sent, for the timeout of the options. False: it is not.
    [[nodiscard]] bool send_all();
    /// The controller is off the bus, or the link down.
    bool is_bus_gone() const;
    /// Ctrl-C came, and nothing more is to be said.
    bool is_closed() const;

    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

  private:
    Session(Bus& bus, const CommonOptions& common);
    void warn_of_duplicate() const;
    void close();

    const CommonOptions& common_;
    mutable std::mutex mutex_;
    std::optional<Orb> orb_;  ///< nothing: closed
};

/// A system exception in words: what it says itself, and what may be behind it.
std::string describe(const SystemException& exception);

}  // namespace canorb::console
