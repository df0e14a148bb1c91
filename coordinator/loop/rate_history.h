#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "proto/clock.h"

namespace parray::coordinator {

/// Counts what happens in intervals of ten seconds, which begin when the time is a multiple of ten
/// seconds. So they are the same for all objects. Remembers the last hour. Not thread-safe.
class RateHistory {
 public:
  static constexpr Time interval = seconds(10);
  static constexpr std::size_t most = 360;  ///< intervals remembered

  /// Returns the number of the interval of a time.
  static std::int64_t number_of(Time now) { return now / interval; }

  /// Counts `amount` at `now`, which must not be earlier than in the previous call.
  void add(Time now, double amount);
  /// Returns `count` numbers: the mean amounts per second of the intervals before number `end`,
  /// oldest first. 0 for intervals that are forgotten or had nothing to count.
  [[nodiscard]] std::vector<float> before(std::int64_t end, std::size_t count) const;
  /// Returns the mean amount per second of the present interval and the six before it, that is 60
  /// to 70 s. If counting began later, at `since`, divides by the time since then, at least 1 s.
  [[nodiscard]] double last_minute(Time now, Time since) const;

 private:
  [[nodiscard]] double amount_of(std::int64_t number) const;

  std::int64_t number_ = -1;   ///< of the latest interval with an amount; -1: none
  double amount_ = 0;          ///< in that interval
  std::deque<float> earlier_;  ///< amounts of the intervals before it, oldest first
};

}  // namespace parray::coordinator
