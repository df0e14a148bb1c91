#pragma once

#include <algorithm>

#include "proto/clock.h"

namespace parray::coordinator {

/// Limits the referee's processor time to a share of one core on average. Unused time accumulates
/// up to `burst` seconds. A question may take more than is left; then the next one waits until the
/// budget has recovered. Not thread-safe. `now` must never decrease.
class RefereeBudget {
 public:
  /// `share`: of a core, above 0. `burst`: seconds at the beginning, and the maximum.
  RefereeBudget(double share, double burst) : share_(share), burst_(burst), left_(burst) {}

  /// Returns the seconds that are left. Negative after a question that took more.
  [[nodiscard]] double left(Time now) const {
    return std::min(burst_, left_ + share_ * to_seconds(now - since_));
  }
  /// Subtracts the processor time of a question, in seconds.
  void spend(Time now, double took) {
    left_ = left(now) - took;
    since_ = now;
  }
  /// Returns when min(`wanted`, `burst`) seconds will be left.
  [[nodiscard]] Time when(Time now, double wanted) const {
    const double lacking = std::min(wanted, burst_) - left(now);
    return lacking <= 0 ? now
                        : now + std::chrono::ceil<milliseconds>(
                                    std::chrono::duration<double>(lacking / share_));
  }
  [[nodiscard]] double burst() const { return burst_; }

 private:
  double share_;
  double burst_;
  double left_;
  Time since_{};
};

}  // namespace parray::coordinator
