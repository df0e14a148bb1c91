#pragma once

#include <vector>

#include "common/scene/settings.h"

/// X(isa) for each instruction set that kernels are compiled for here, by name: see
/// common/CMakeLists.txt.
#if defined(__x86_64__)
#define PARRAY_FOR_EACH_ISA(X) X(scalar) X(avx2) X(avx512)
#elif defined(__aarch64__)
#define PARRAY_FOR_EACH_ISA(X) X(scalar) X(neon)
#else
#define PARRAY_FOR_EACH_ISA(X) X(scalar)
#endif

namespace parray::trace {

/// Whether this processor, and its operating system, can run it.
bool runs_on_this_machine(Isa isa);

/// Those that it can, the best one last.
std::vector<Isa> instruction_sets();
Isa best_isa();

}  // namespace parray::trace
