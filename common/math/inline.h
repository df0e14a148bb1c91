#pragma once

/// Marks every function that a kernel may call. The build compiles kernels once for each
/// instruction set. If the compiler left a shared inline function out of line, each set would have
/// its own copy. The linker would keep any one of the copies, and an old processor could meet new
/// instructions. Forced inlining leaves no copy for the linker to choose.
/// (tests/integration/isa_symbols_test.py checks this.)
#define PARRAY_INLINE __attribute__((always_inline)) inline
