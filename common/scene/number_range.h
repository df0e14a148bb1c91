#pragma once

namespace parray {

/// Both ends belong to the range.
struct NumberRange {
  double least;
  double most;
};

}  // namespace parray
