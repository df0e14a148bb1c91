#pragma once

#include <stdexcept>

#include "common/rooms.h"

namespace parray::base {

/// Bad input or bad usage, which the user can correct. `what()` is one line with the file, the
/// place and the remedy. Programs print it and exit with status 2.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A failure of the work itself (disk full, coordinator gone, job failed). `what()` is one line
/// that says which operation failed. Programs print it and exit with status 1.
class RunError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace parray::base
