#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include <cstddef>

#include "common/math/inline.h"
#include "common/rooms.h"

namespace parray::math {

/// Numbers that fill 16 bytes, a vector size that all processors have.
template <typename T>
using Vector16 __attribute__((vector_size(16))) = T;

// Return the minimum and the maximum, component by component; `b` if `a` or `b` is NaN. (Compilers
// have no vector minimum with this rule.)
template <typename V>
PARRAY_INLINE V least(V a, V b) {
  return a < b ? a : b;
}
template <typename V>
PARRAY_INLINE V largest(V a, V b) {
  return a > b ? a : b;
}
#if defined(__SSE2__)
template <>
PARRAY_INLINE Vector16<float> least(Vector16<float> a, Vector16<float> b) {
  return _mm_min_ps(a, b);
}
template <>
PARRAY_INLINE Vector16<float> largest(Vector16<float> a, Vector16<float> b) {
  return _mm_max_ps(a, b);
}
template <>
PARRAY_INLINE Vector16<double> least(Vector16<double> a, Vector16<double> b) {
  return _mm_min_pd(a, b);
}
template <>
PARRAY_INLINE Vector16<double> largest(Vector16<double> a, Vector16<double> b) {
  return _mm_max_pd(a, b);
}
#endif

/// Four numbers in one vector, x, y, z and one more, for code that is compiled for any processor.
/// (If a processor has no vectors of 32 bytes, compilers split them into single numbers.)
template <typename T>
struct Vec4;

template <>
struct Vec4<float> {
  Vector16<float> all;

  Vec4() = default;
  PARRAY_INLINE explicit Vec4(Vector16<float> values) : all(values) {}
  PARRAY_INLINE explicit Vec4(float same) : all{same, same, same, same} {}
  PARRAY_INLINE Vec4(float x, float y, float z, float w) : all{x, y, z, w} {}
  static PARRAY_INLINE Vec4 load(const float* from) {
    Vec4 loaded;
    __builtin_memcpy(&loaded.all, from, sizeof loaded.all);
    return loaded;
  }
  PARRAY_INLINE void store(float* to) const { __builtin_memcpy(to, &all, sizeof all); }
  PARRAY_INLINE float operator[](std::size_t i) const { return all[i]; }
  /// Returns the first 16 bytes: all four numbers.
  [[nodiscard]] PARRAY_INLINE Vector16<float> first() const { return all; }

  /// Returns the results of function(a, b), which is called with vectors of 16 bytes.
  static PARRAY_INLINE Vec4 each(const Vec4& a, const Vec4& b, const auto& function) {
    return Vec4(function(a.all, b.all));
  }
};

template <>
struct Vec4<double> {
  Vector16<double> half[2];

  Vec4() = default;
  PARRAY_INLINE Vec4(Vector16<double> xy, Vector16<double> zw) : half{xy, zw} {}
  PARRAY_INLINE explicit Vec4(double same) : half{{same, same}, {same, same}} {}
  PARRAY_INLINE Vec4(double x, double y, double z, double w) : half{{x, y}, {z, w}} {}
  static PARRAY_INLINE Vec4 load(const double* from) {
    Vec4 loaded;
    __builtin_memcpy(loaded.half, from, sizeof loaded.half);
    return loaded;
  }
  PARRAY_INLINE void store(double* to) const { __builtin_memcpy(to, half, sizeof half); }
  PARRAY_INLINE double operator[](std::size_t i) const { return half[i / 2][i % 2]; }
  /// Returns the first 16 bytes: x and y.
  [[nodiscard]] PARRAY_INLINE Vector16<double> first() const { return half[0]; }

  static PARRAY_INLINE Vec4 each(const Vec4& a, const Vec4& b, const auto& function) {
    return {function(a.half[0], b.half[0]), function(a.half[1], b.half[1])};
  }
};

template <typename T>
PARRAY_INLINE Vec4<T> operator+(const Vec4<T>& a, const Vec4<T>& b) {
  return Vec4<T>::each(a, b, [](auto x, auto y) { return x + y; });
}
template <typename T>
PARRAY_INLINE Vec4<T> operator-(const Vec4<T>& a, const Vec4<T>& b) {
  return Vec4<T>::each(a, b, [](auto x, auto y) { return x - y; });
}
template <typename T>
PARRAY_INLINE Vec4<T> operator*(const Vec4<T>& a, const Vec4<T>& b) {
  return Vec4<T>::each(a, b, [](auto x, auto y) { return x * y; });
}
template <typename T>
PARRAY_INLINE Vec4<T> min_of(const Vec4<T>& a, const Vec4<T>& b) {
  return Vec4<T>::each(a, b, [](auto x, auto y) { return least(x, y); });
}
template <typename T>
PARRAY_INLINE Vec4<T> max_of(const Vec4<T>& a, const Vec4<T>& b) {
  return Vec4<T>::each(a, b, [](auto x, auto y) { return largest(x, y); });
}
/// Returns `a` if number < limit, otherwise `b`, without a branch.
template <typename T>
PARRAY_INLINE Vec4<T> select_below(T number, T limit, const Vec4<T>& a, const Vec4<T>& b) {
  const auto below = Vec4<T>(number).first() < Vec4<T>(limit).first();
  return Vec4<T>::each(a, b, [&](auto x, auto y) { return below ? x : y; });
}

}  // namespace parray::math
