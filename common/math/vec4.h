#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include "common/math/inline.h"

namespace parray {

/// Vec4 numbers side by side, for code that is compiled for any processor: x, y, z and a fourth.
template <typename T>
using Vec4 __attribute__((vector_size(4 * sizeof(T)))) = T;

/// Component-wise. (The compilers know no vector minimum that says what it does with NaN.)
template <typename T>
PARRAY_INLINE Vec4<T> min_of_four(Vec4<T> a, Vec4<T> b) {
  return a < b ? a : b;
}
template <typename T>
PARRAY_INLINE Vec4<T> max_of_four(Vec4<T> a, Vec4<T> b) {
  return a > b ? a : b;
}
#if defined(__SSE2__)
template <>
PARRAY_INLINE Vec4<float> min_of_four<float>(Vec4<float> a, Vec4<float> b) {
  return _mm_min_ps(a, b);
}
template <>
PARRAY_INLINE Vec4<float> max_of_four<float>(Vec4<float> a, Vec4<float> b) {
  return _mm_max_ps(a, b);
}
template <>
PARRAY_INLINE Vec4<double> min_of_four<double>(Vec4<double> a, Vec4<double> b) {
  const __m128d low = _mm_min_pd(_mm_setr_pd(a[0], a[1]), _mm_setr_pd(b[0], b[1]));
  const __m128d high = _mm_min_pd(_mm_setr_pd(a[2], a[3]), _mm_setr_pd(b[2], b[3]));
  return Vec4<double>{low[0], low[1], high[0], high[1]};
}
template <>
PARRAY_INLINE Vec4<double> max_of_four<double>(Vec4<double> a, Vec4<double> b) {
  const __m128d low = _mm_max_pd(_mm_setr_pd(a[0], a[1]), _mm_setr_pd(b[0], b[1]));
  const __m128d high = _mm_max_pd(_mm_setr_pd(a[2], a[3]), _mm_setr_pd(b[2], b[3]));
  return Vec4<double>{low[0], low[1], high[0], high[1]};
}
#endif

}  // namespace parray
