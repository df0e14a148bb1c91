#pragma once

#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

#include "common/rooms.h"

namespace parray::math {

/// The control word of a thread's floating point (x86-64: MXCSR, aarch64: FPCR): its value for IEEE
/// 754, and the bits that deviate from it. On other processors the word is unknown and left alone.
namespace float_control {

#if defined(__x86_64__)
inline constexpr unsigned ieee = 0x1F80;               ///< the value after a processor reset
inline constexpr unsigned denormal_results = 0x8000;   ///< denormal results become 0
inline constexpr unsigned denormal_operands = 0x0040;  ///< denormal operands count as 0
inline constexpr unsigned rounding = 0x6000;           ///< rounding other than to nearest
/// Bits that control whether exceptions stop the program.
inline constexpr unsigned exceptions = 0x1F80;
inline unsigned read() { return _mm_getcsr(); }
inline void write(unsigned control) { _mm_setcsr(control); }
#elif defined(__aarch64__)
inline constexpr unsigned ieee = 0;
inline constexpr unsigned denormal_results = 0x0100'0000;
inline constexpr unsigned denormal_operands = 0x0100'0001;
inline constexpr unsigned rounding = 0x00C0'0000;
inline constexpr unsigned exceptions = 0x9F00;
inline unsigned read() {
  unsigned long control;
  asm volatile("mrs %0, fpcr" : "=r"(control));
  return static_cast<unsigned>(control);
}
inline void write(unsigned control) {
  asm volatile("msr fpcr, %0" : : "r"(static_cast<unsigned long>(control)) : "memory");
}
#else
inline constexpr unsigned ieee = 0;
inline constexpr unsigned denormal_results = 0;
inline constexpr unsigned denormal_operands = 0;
inline constexpr unsigned rounding = 0;
inline constexpr unsigned exceptions = 0;
inline unsigned read() { return ieee; }
inline void write(unsigned) {}
#endif

}  // namespace float_control

/// Sets the calling thread's floating-point mode while the object exists: round to nearest,
/// denormals by IEEE 754 (no flush to zero), exceptions masked. A library or a parent thread may
/// have left another mode, and the last bits of a picture would depend on it.
class FloatMode {
 public:
  FloatMode() : before_(float_control::read()) { float_control::write(float_control::ieee); }
  ~FloatMode() { float_control::write(before_); }
  FloatMode& operator=(FloatMode&&) = delete;

 private:
  unsigned before_;
};

}  // namespace parray::math
