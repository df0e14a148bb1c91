#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "proto/clock.h"

namespace parray::http {

/// The number of a connection. Numbers are not reused.
using ConnectionId = std::uint64_t;

/// Limits of connections and of their times.
struct SeatLimits {
  std::size_t connections = 1024;  ///< regular connections
  std::size_t of_address = 256;    ///< regular connections per address
  std::size_t reserve = 32;        ///< additional connections, for quick answers only
  Time head_time = seconds(10);    ///< limit for a head, and its body up to small_body bytes
  Time idle_time = seconds(15);    ///< limit without any byte of a request
  Time reserve_time = seconds(2);  ///< in the reserve, replaces head_time and idle_time
};

/// Tracks all connections and decides which one to close when a limit is reached. A seat is the
/// place that one connection takes. Connections whose request is not being answered make room for
/// new ones: first those whose last answer was sent, then those that have waited longest for a
/// request or for the rest of one. Not thread-safe. Does no I/O. An address is an
/// owner_of_address().
class Seats {
 public:
  explicit Seats(SeatLimits limits) : limits_(limits) {}

  /// The outcome of enter().
  struct Admission {
    bool reserve = false;  ///< the new connection is in the reserve, as all regular ones are used
    /// A connection that the caller must close; this object has removed it already. If it is the
    /// new connection, there was no room for it.
    std::optional<ConnectionId> displaced;
  };
  /// Adds a new connection. Its first request is awaited.
  Admission enter(Time now, ConnectionId id, const std::string& address);
  /// Removes a connection. Does nothing for an unknown one.
  void leave(ConnectionId id);

  /// Records the first byte of a request.
  void begins_head(Time now, ConnectionId id);
  /// Records that the request is ready to be answered. The connection has no deadline until
  /// awaits_head().
  void has_asked(ConnectionId id) { seats_.at(id).phase = Phase::asked; }
  /// Records that the request was answered and the next one is awaited.
  void awaits_head(Time now, ConnectionId id) { begin(Phase::idle, now, id); }
  /// Records that the last answer was sent. The connection is the first to make room.
  void has_ended(Time now, ConnectionId id) { begin(Phase::ended, now, id); }

  /// Returns the connections that exceed a time limit. They stay until leave().
  [[nodiscard]] std::vector<ConnectionId> late(Time now) const;

 private:
  enum class Phase : std::uint8_t { idle, head, asked, ended };
  struct Seat {
    std::string address;
    bool reserve = false;
    Phase phase = Phase::idle;
    Time since{};
  };
  void begin(Phase phase, Time now, ConnectionId id);
  [[nodiscard]] std::optional<ConnectionId> first_to_go(bool reserve,
                                                        const std::string* address) const;
  [[nodiscard]] Time deadline(const Seat& seat) const;

  const SeatLimits limits_;
  std::map<ConnectionId, Seat> seats_;
  std::map<std::string, std::size_t> of_address_;  ///< regular connections per address
  std::size_t ordinary_ = 0;
};

/// Returns the name under which an address is counted: the address, or the /64 network of an IPv6
/// address, because one machine may own all addresses of that network.
std::string owner_of_address(const std::string& address);

}  // namespace parray::http
