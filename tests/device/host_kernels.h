#pragma once

#include <cstdint>

#include "tests/support/device_picture.h"

namespace parray::test {

/// Runs a kernel as an ordinary C++ function, in the thread's floating-point mode. Throws
/// std::out_of_range for an unknown kernel.
void launch_on_host(const Launch& launch);

/// Does the same with kernels that can store `most_inside` shapes: 0, 1, 2 or 8.
void launch_on_host(const Launch& launch, std::uint32_t most_inside);

}  // namespace parray::test
