#pragma once

#include <algorithm>

#include "proto/clock.h"

namespace parray::coordinator {

/// Processor time that the referee may take: a share of one core on average. What it does not take
/// is saved, up to `burst` seconds. One question may take more than is left; then the next one
/// waits until that is made up for. Plain state; `now` never goes back.
class RefereeBudget {
 public:
  /// `share`: of a core, above 0. `burst`: seconds that are there at the beginning, and at most.
  RefereeBudget(double share, double burst) : share_(share), burst_(burst), left_(burst) {}

  /// Seconds that are left; below 0 after a question that took more.
  [[nodiscard]] double left(Time now) const {
    return std::min(burst_, left_ + share_ * to_seconds(now - since_));
  }
  /// A question took so many seconds of processor time.
  void spend(Time now, double took) {
    left_ = left(now) - took;
    since_ = now;
  }
  /// When so many seconds, at most `burst`, are left.
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
