#pragma once

#include "common/rooms.h"

namespace parray::plan {

/// Time in seconds: wall-clock time, and processor time of all threads together.
struct Effort {
  double wall = 0;
  double cpu = 0;

  friend Effort operator+(Effort a, Effort b) { return {a.wall + b.wall, a.cpu + b.cpu}; }
  friend Effort operator-(Effort a, Effort b) { return {a.wall - b.wall, a.cpu - b.cpu}; }
  friend Effort operator*(double factor, Effort a) { return {factor * a.wall, factor * a.cpu}; }
};

/// Returns the time since an arbitrary start. The difference of two calls is the time between them.
Effort effort_now();

}  // namespace parray::plan
