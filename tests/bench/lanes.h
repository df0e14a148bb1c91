#pragma once

#include <cmath>
#include <cstdint>
#if defined(__AVX512F__) && defined(__AVX512DQ__)
#include <immintrin.h>
#define PARRAY_BENCH_AVX512 1  // a macro, because an absent instruction must not even be parsed
#endif

/// One number, or sixteen side by side, under the same names: shading code that is a template on F
/// runs one path with F = float and sixteen in vector registers with F = Floats.
///
/// Where AVX-512 is absent the compiler splits the vectors, and loops over lanes stand in for
/// intrinsics.
namespace parray::lanes {

inline constexpr std::size_t width = 16;

using Floats = float __attribute__((vector_size(64)));
using Words = std::uint32_t __attribute__((vector_size(64)));
using Masks = std::int32_t __attribute__((vector_size(64)));  ///< a lane is 0 or -1

template <typename F>
struct Types;
template <>
struct Types<float> {
  using Word = std::uint32_t;
  using Mask = bool;
};
template <>
struct Types<Floats> {
  using Word = Words;
  using Mask = Masks;
};
template <typename F>
using Word = typename Types<F>::Word;
template <typename F>
using Mask = typename Types<F>::Mask;

inline const Words iota = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

inline bool any(bool mask) { return mask; }
inline float select(bool mask, float yes, float no) { return mask ? yes : no; }
inline float to_float(std::uint32_t word) { return static_cast<float>(word); }
inline std::uint32_t truncate(float x) { return static_cast<std::uint32_t>(x); }
inline float square_root(float x) { return std::sqrt(x); }
inline float inverse_square_root(float x) { return 1 / std::sqrt(x); }
inline float gather(const float* table, std::uint32_t index) { return table[index]; }
inline std::uint32_t gather(const std::uint32_t* table, std::uint32_t index) {
  return table[index];
}

inline Floats select(Masks mask, Floats yes, Floats no) { return mask ? yes : no; }
inline Floats to_float(Words words) { return __builtin_convertvector(words, Floats); }
inline Words truncate(Floats x) { return __builtin_convertvector(x, Words); }

/// Halves of the 64-bit product of a word and a constant.
template <typename W>
struct Product {
  W high;
  W low;
};
inline Product<std::uint32_t> multiply(std::uint32_t a, std::uint32_t b) {
  const std::uint64_t product = static_cast<std::uint64_t>(a) * b;
  return {static_cast<std::uint32_t>(product >> 32), static_cast<std::uint32_t>(product)};
}

#if PARRAY_BENCH_AVX512

inline __mmask16 bits(Masks mask) { return _mm512_movepi32_mask(reinterpret_cast<__m512i>(mask)); }
inline Floats square_root(Floats x) { return _mm512_sqrt_ps(x); }
inline Floats inverse_square_root(Floats x) {
  const Floats guess = _mm512_rsqrt14_ps(x);
  return guess * (1.5F - (0.5F * x) * guess * guess);  // one Newton step: about 23 bits
}
inline Floats gather(const float* table, Words index) {
  return _mm512_i32gather_ps(reinterpret_cast<__m512i>(index), table, 4);
}
inline Words gather(const std::uint32_t* table, Words index) {
  return reinterpret_cast<Words>(
      _mm512_i32gather_epi32(reinterpret_cast<__m512i>(index), table, 4));
}
inline Product<Words> multiply(Words a, std::uint32_t b) {
  const __m512i factor = _mm512_set1_epi64(b);
  const auto lanes = reinterpret_cast<__m512i>(a);
  const __m512i even = _mm512_mul_epu32(lanes, factor);
  const __m512i odd = _mm512_mul_epu32(_mm512_srli_epi64(lanes, 32), factor);
  const __m512i high = _mm512_mask_blend_epi32(0xAAAA, _mm512_srli_epi64(even, 32), odd);
  const __m512i low = _mm512_mask_blend_epi32(0xAAAA, even, _mm512_slli_epi64(odd, 32));
  return {reinterpret_cast<Words>(high), reinterpret_cast<Words>(low)};
}
/// Writes the lanes of `mask` one after another; up to 16 elements from `to` on are overwritten.
inline void pack(float* to, __mmask16 mask, Floats values) {
  _mm512_storeu_ps(to, _mm512_maskz_compress_ps(mask, values));
}
inline void pack(std::uint32_t* to, __mmask16 mask, Words values) {
  _mm512_storeu_si512(to, _mm512_maskz_compress_epi32(mask, reinterpret_cast<__m512i>(values)));
}

#else

inline std::uint32_t bits(Masks mask) {
  std::uint32_t result = 0;
  for (std::size_t i = 0; i < width; ++i) {
    result |= static_cast<std::uint32_t>(mask[i] != 0) << i;
  }
  return result;
}
inline Floats square_root(Floats x) {
  for (std::size_t i = 0; i < width; ++i) {
    x[i] = std::sqrt(x[i]);
  }
  return x;
}
inline Floats inverse_square_root(Floats x) { return 1 / square_root(x); }
template <typename T>
auto gather(const T* table, Words index) {
  std::conditional_t<std::is_same_v<T, float>, Floats, Words> result{};
  for (std::size_t i = 0; i < width; ++i) {
    result[i] = table[index[i]];
  }
  return result;
}
inline Product<Words> multiply(Words a, std::uint32_t b) {
  Product<Words> result;
  for (std::size_t i = 0; i < width; ++i) {
    const Product<std::uint32_t> one = multiply(std::uint32_t{a[i]}, b);
    result.high[i] = one.high;
    result.low[i] = one.low;
  }
  return result;
}
template <typename T, typename Vector>
void pack(T* to, std::uint32_t mask, Vector values) {
  for (std::size_t i = 0; i < width; ++i) {
    *to = values[i];
    to += (mask >> i) & 1;
  }
}

#endif

inline bool any(Masks mask) { return bits(mask) != 0; }

template <typename Vector, typename T>
Vector load(const T* from) {
  Vector result;
  __builtin_memcpy(&result, from, sizeof result);
  return result;
}

}  // namespace parray::lanes
