#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "proto/clock.h"

namespace parray::http {

/// The number of a connection. Numbers are not used twice.
using ConnectionId = std::uint64_t;

struct SeatLimits {
  std::size_t connections = 1024;
  std::size_t of_address = 256;
  std::size_t reserve = 32;        ///< beyond these, for requests that are answered at once
  Time head_time = seconds(10);    ///< from the first to the last byte of a head
  Time idle_time = seconds(15);    ///< without any byte of a request
  Time reserve_time = seconds(2);  ///< for the head of a connection in the reserve
};

/// Which connections there are, and which has to go. Whoever has not said yet what it wants makes
/// room for who comes later. One thread; does no I/O.
class Seats {
 public:
  explicit Seats(SeatLimits limits) : limits_(limits) {}

  struct Admission {
    bool reserve = false;                   ///< all ordinary seats are taken
    std::optional<ConnectionId> displaced;  ///< is to be closed; has left already
  };
  /// A connection has come; it is waited for its first request.
  Admission enter(Time now, ConnectionId id, const std::string& address);
  void leave(ConnectionId id);

  /// The first byte of a request has come.
  void begins_head(Time now, ConnectionId id);
  /// Its head is whole: it has no deadline here until awaits_head().
  void has_asked(ConnectionId id);
  /// It has been answered; its next request is waited for.
  void awaits_head(Time now, ConnectionId id);
  /// Its last answer has been sent: it makes room before anybody else.
  void has_ended(Time now, ConnectionId id);

  /// Those that have taken too long; they are there until leave().
  [[nodiscard]] std::vector<ConnectionId> late(Time now) const;

 private:
  enum class Phase : std::uint8_t { idle, head, asked, ended };
  struct Seat {
    std::string address;
    bool reserve = false;
    Phase phase = Phase::idle;
    Time since{};
  };
  [[nodiscard]] std::optional<ConnectionId> first_to_go(bool reserve,
                                                        const std::string* address) const;
  [[nodiscard]] Time deadline(const Seat& seat) const;

  const SeatLimits limits_;
  std::map<ConnectionId, Seat> seats_;
  std::map<std::string, std::size_t> of_address_;  ///< ordinary ones
  std::size_t ordinary_ = 0;
};

/// Whom an address is counted as: itself, or, of IPv6, its network of 64 bits, which one machine
/// may have all of.
std::string owner_of_address(const std::string& address);

}  // namespace parray::http
