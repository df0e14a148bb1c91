#pragma once

#include <chrono>

#include "common/rooms.h"

namespace parray::proto {

/// A moment, as the time since an arbitrary start, or a duration. `now`, deadlines and the results
/// of tick() are moments. `timeout`, `limit` and `patience` are durations. State machines take the
/// moment as an argument and never read a clock.
using Time = std::chrono::nanoseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

/// No deadline.
inline constexpr Time never = Time::max();

/// Returns seconds as a real number, for rates and reports.
inline double to_seconds(Time t) { return std::chrono::duration<double>(t).count(); }
/// Returns a duration. `t`: seconds, less than 2^63 nanoseconds (292 years).
inline Time from_seconds(double t) {
  return std::chrono::duration_cast<Time>(std::chrono::duration<double>(t));
}

/// The source of time for the loops. Tests replace it by their own clock.
class Clock {
 public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual Time now() const = 0;
};

/// The machine's monotonic clock.
class SteadyClock final : public Clock {
 public:
  [[nodiscard]] Time now() const override {
    return std::chrono::steady_clock::now().time_since_epoch();
  }
};

}  // namespace parray::proto
