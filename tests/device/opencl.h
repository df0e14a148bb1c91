#pragma once

#include <memory>
#include <string>

#include "tests/support/device_picture.h"

namespace parray::test {

/// Kernels on an OpenCL device, which may be the processor (pocl). One thread may use it.
class OpenCl {
 public:
  /// Loads a file in the form SPIR 1.2 to the first device that can take it: one that rounds
  /// division and square root correctly and keeps denormals. Throws std::runtime_error, which says
  /// what is missing or what failed.
  explicit OpenCl(const std::string& file);
  ~OpenCl();
  OpenCl& operator=(OpenCl&&) = delete;

  /// Traces all items of a launch.
  void run(const Launch& launch);

  /// Returns why no OpenCL device can run the file; empty: one can.
  static std::string reason_without(const std::string& file);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace parray::test
