#pragma once

#include <algorithm>
#include <cstddef>

#include "proto/clock.h"

namespace parray::http {

/// Limits how long the peer of a connection may delay the transfer of bytes. It is an
/// allowance of time: waiting spends it, and transferred bytes restore it, up to `patience`. A peer
/// that stays slower than `rate` exhausts it, however evenly its bytes arrive.
class Pace {
 public:
  /// `rate`: bytes per second, > 0.
  Pace(Time patience, double rate) : patience_(patience), rate_(rate), left_(patience) {}

  /// Subtracts time that passed without a transfer.
  void waited(Time time) { left_ -= time; }
  /// Adds the time that `bytes` take at `rate`.
  void moved(std::size_t bytes) {
    const double earned = static_cast<double>(bytes) / rate_;
    if (earned >= to_seconds(patience_ - left_)) {
      left_ = patience_;
    } else {
      left_ += from_seconds(earned);
    }
  }
  /// Restores the full allowance.
  void restart() { left_ = patience_; }

  /// Returns the time that is left, >= 0.
  [[nodiscard]] Time left() const { return std::max(left_, Time(0)); }
  /// Returns whether no time is left.
  [[nodiscard]] bool over() const { return left_ <= Time(0); }

 private:
  Time patience_;
  double rate_;
  Time left_;
};

}  // namespace parray::http
