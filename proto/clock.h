#pragma once

#include <chrono>

#include "common/rooms.h"

namespace parray::proto {

/// Time since an arbitrary start. State machines take it as an argument and never ask for it.
using Time = std::chrono::nanoseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

/// No deadline.
inline constexpr Time never = Time::max();

/// Seconds as a real number, for rates and reports.
inline double to_seconds(Time t) { return std::chrono::duration<double>(t).count(); }

/// Where the loops get the time from. Tests put a clock of their own in its place.
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
