#pragma once

#include "common/rooms.h"

namespace parray::plan {

/// Time that something takes, in seconds: by the clock on the wall, and of all threads together.
struct Effort {
  double wall = 0;
  double cpu = 0;

  friend Effort operator+(Effort a, Effort b) { return {a.wall + b.wall, a.cpu + b.cpu}; }
  friend Effort operator-(Effort a, Effort b) { return {a.wall - b.wall, a.cpu - b.cpu}; }
  friend Effort operator*(double factor, Effort a) { return {factor * a.wall, factor * a.cpu}; }
};

/// Since some start: differences are what took place between two calls.
Effort effort_now();

}  // namespace parray::plan
