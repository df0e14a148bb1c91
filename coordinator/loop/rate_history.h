#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "proto/clock.h"

namespace parray::coordinator {

/// Counts what happens in intervals of ten seconds, which begin at the same times for all objects.
/// Remembers the last hour. Not thread-safe.
class RateHistory {
 public:
  static constexpr Time interval = seconds(10);
  static constexpr std::size_t most = 360;  ///< intervals remembered

  /// Returns the number of the interval of a time.
  static std::int64_t number_of(Time now) { return now / interval; }

  /// Counts `amount` at `now`, which never goes back.
  void add(Time now, double amount);
  /// Returns the mean amounts per second of the `count` intervals before number `end`, oldest
  /// first.
  [[nodiscard]] std::vector<float> before(std::int64_t end, std::size_t count) const;
  /// Returns the mean amount per second of the last 60 to 70 s, or since `since`, when counting
  /// began, if that is shorter.
  [[nodiscard]] double last_minute(Time now, Time since) const;

 private:
  [[nodiscard]] double amount_of(std::int64_t number) const;

  std::int64_t number_ = -1;   ///< of the latest interval with an amount; -1: none
  double amount_ = 0;          ///< in that interval
  std::deque<float> earlier_;  ///< amounts of the intervals before it, oldest first
};

}  // namespace parray::coordinator
