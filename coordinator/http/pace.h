#pragma once

#include <algorithm>
#include <cstddef>

#include "proto/clock.h"

namespace parray::http {

/// How long the other side of a connection may keep this one waiting while bytes are due from it
/// or to it. It has an allowance of time: waiting spends it, bytes that move give time back, and it
/// never exceeds `patience`. So a side that is slower than `rate` is given up after a while,
/// however evenly its bytes come.
class Pace {
 public:
  /// `rate`: bytes a second, > 0.
  Pace(Time patience, double rate) : patience_(patience), rate_(rate), left_(patience) {}

  void waited(Time time) { left_ -= time; }
  void moved(std::size_t bytes) {
    const double earned = static_cast<double>(bytes) / rate_;
    if (earned >= to_seconds(patience_ - left_)) {
      left_ = patience_;
    } else {
      left_ += std::chrono::duration_cast<Time>(std::chrono::duration<double>(earned));
    }
  }
  void restart() { left_ = patience_; }

  [[nodiscard]] Time left() const { return std::max(left_, Time(0)); }
  [[nodiscard]] bool over() const { return left_ <= Time(0); }

 private:
  Time patience_;
  double rate_;
  Time left_;
};

}  // namespace parray::http
