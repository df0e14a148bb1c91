#pragma once

#include <stdexcept>
#include <string>

#include "common/rooms.h"

namespace parray::base {

/// Bad input or bad usage: somebody outside the program can mend it. `what()` is one line that
/// names the file, the place and the remedy. Programs print it and exit with status 2.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The work itself failed (disk full, coordinator gone, job failed). `what()` is one line that
/// says what was being done. Programs print it and exit with status 1.
class RunError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace parray::base
