#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/cuda/cuda_functions.h"

/// The kernels of the stand-in for CUDA's driver library: device code as ordinary C++ functions.
namespace parray::test::stand_in {

/// A block of memory that a kernel's parameter must point to.
struct BufferUse {
  cuda::Pointer address;
  std::size_t bytes;      ///< fewest bytes from the address on
  std::size_t alignment;  ///< of the address
};

/// A launch with its parameters.
struct BoundKernel {
  std::vector<BufferUse> buffers;                        ///< the last one holds the results
  std::function<void(std::uint32_t thread)> run_thread;  ///< a thread of the grid
};

/// Reads the parameters of a launch.
using KernelBinder = BoundKernel (*)(void** parameters);

/// Returns the kernel with this name, or null.
KernelBinder find_kernel(const std::string& name);

}  // namespace parray::test::stand_in
