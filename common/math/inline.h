#pragma once

/// Marks every function that a kernel may call. Kernels are compiled once for each instruction set;
/// a shared inline function that the compiler leaves out of line would exist once a set, the linker
/// would keep any one of them, and an old processor could meet new instructions. Inlined by force,
/// none is left for the linker to pick. (tests/integration/isa_symbols_test.py looks.)
#define PARRAY_INLINE __attribute__((always_inline)) inline
