#pragma once

#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

namespace parray {

/// Sets the calling thread's floating-point mode for its lifetime: round to nearest, denormals as
/// IEEE 754 has them (no flush to zero), exceptions masked. A library, or a parent thread, may have
/// left another mode behind, and the last bits of a picture would depend on it.
class FloatMode {
 public:
#if defined(__x86_64__)
  FloatMode() : before_(_mm_getcsr()) { _mm_setcsr(ieee); }
  ~FloatMode() { _mm_setcsr(before_); }
#else
  FloatMode() = default;
  ~FloatMode() = default;
#endif
  FloatMode(const FloatMode&) = delete;
  FloatMode& operator=(const FloatMode&) = delete;

 private:
#if defined(__x86_64__)
  static constexpr unsigned ieee = 0x1F80;  // the value after a processor reset
  unsigned before_;
#endif
};

}  // namespace parray
