#pragma once

#include <vector>

#include "common/scene/setting_choices.h"

/// Applies X(isa) to the name of each instruction set with kernels in this build: see
/// common/CMakeLists.txt.
#if defined(__x86_64__)
#define PARRAY_FOR_EACH_ISA(X) X(scalar) X(avx2) X(avx512)
#elif defined(__aarch64__)
#define PARRAY_FOR_EACH_ISA(X) X(scalar) X(neon)
#else
#define PARRAY_FOR_EACH_ISA(X) X(scalar)
#endif

namespace parray::trace {

/// Returns whether this processor and its operating system can run `isa`; true for `automatic`.
bool runs_on_this_machine(Isa isa);

/// Returns the instruction sets that this machine can run, the best one last.
std::vector<Isa> instruction_sets();
/// Returns the last of instruction_sets().
Isa best_isa();

}  // namespace parray::trace
