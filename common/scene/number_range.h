#pragma once

#include "common/rooms.h"

namespace parray::scene {

/// Both ends belong to the range.
struct NumberRange {
  double least;
  double most;
};

}  // namespace parray::scene
