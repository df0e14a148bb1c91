#pragma once

#include <immintrin.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "tests/support/rooms.h"

/// One number, or a register full side by side, under the same names: shading code that is a
/// template on F runs one path with F = float and `width` paths with F = Floats. AVX-512 or AVX2,
/// whichever this file is compiled for.
namespace parray::lanes {

#if defined(__AVX512F__) && defined(__AVX512DQ__)
inline constexpr std::size_t width = 16;
#else
inline constexpr std::size_t width = 8;
#endif

using Floats = float __attribute__((vector_size(4 * width)));
using Words = std::uint32_t __attribute__((vector_size(4 * width)));
using Masks = std::int32_t __attribute__((vector_size(4 * width)));  ///< a lane is 0 or -1

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

inline bool any(bool mask) { return mask; }
inline float select(bool mask, float yes, float no) { return mask ? yes : no; }
inline float to_float(std::uint32_t word) { return static_cast<float>(word); }
inline std::uint32_t truncate(float x) { return static_cast<std::uint32_t>(x); }
inline float square_root(float x) { return std::sqrt(x); }
inline float inverse_square_root(float x) { return 1 / std::sqrt(x); }
inline float gather(const float* table, std::uint32_t index) { return table[index]; }

inline Floats select(Masks mask, Floats yes, Floats no) { return mask ? yes : no; }
/// Of words below 2^31: signed conversion is one instruction everywhere.
inline Floats to_float(Words words) {
  return __builtin_convertvector(reinterpret_cast<Masks>(words), Floats);
}
inline Words truncate(Floats x) {
  return reinterpret_cast<Words>(__builtin_convertvector(x, Masks));
}

/// Halves of the 64-bit product of a word and a constant.
template <typename W>
struct Product {
  W high;
  W low;
};
inline Product<std::uint32_t> multiply(std::uint32_t a, std::uint32_t b) {
  const std::uint64_t product = std::uint64_t{a} * b;
  return {static_cast<std::uint32_t>(product >> 32), static_cast<std::uint32_t>(product)};
}

template <typename Vector, typename T>
Vector load(const T* from) {
  Vector result;
  __builtin_memcpy(&result, from, sizeof result);
  return result;
}
template <typename Vector, typename T>
void store(T* to, const Vector& from) {
  __builtin_memcpy(to, &from, sizeof from);
}

/// 0, 1, 2, ...
inline Words iota() {
  constexpr std::array<std::uint32_t, 16> numbers{0, 1, 2,  3,  4,  5,  6,  7,
                                                  8, 9, 10, 11, 12, 13, 14, 15};
  return load<Words>(numbers.data());
}

/// 1 / sqrt(x) from a guess of 12 bits or more: one Newton step.
inline Floats refine_inverse_root(Floats x, Floats guess) {
  return guess * (1.5F - (0.5F * x) * guess * guess);
}

#if defined(__AVX512F__) && defined(__AVX512DQ__)

/// A bit for each lane.
inline unsigned bits(Masks mask) { return _mm512_movepi32_mask(reinterpret_cast<__m512i>(mask)); }
inline Floats square_root(Floats x) { return _mm512_sqrt_ps(x); }
inline Floats inverse_square_root(Floats x) { return refine_inverse_root(x, _mm512_rsqrt14_ps(x)); }
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
/// Moves the lanes of `mask` to the front.
inline Floats pack(Floats values, unsigned mask) {
  return _mm512_maskz_compress_ps(static_cast<__mmask16>(mask), values);
}

#else

inline unsigned bits(Masks mask) {
  return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
}
inline Floats square_root(Floats x) { return _mm256_sqrt_ps(x); }
inline Floats inverse_square_root(Floats x) { return refine_inverse_root(x, _mm256_rsqrt_ps(x)); }
inline Floats gather(const float* table, Words index) {
  return _mm256_i32gather_ps(table, reinterpret_cast<__m256i>(index), 4);
}
inline Words gather(const std::uint32_t* table, Words index) {
  return reinterpret_cast<Words>(_mm256_i32gather_epi32(reinterpret_cast<const int*>(table),
                                                        reinterpret_cast<__m256i>(index), 4));
}
inline Product<Words> multiply(Words a, std::uint32_t b) {
  const __m256i factor = _mm256_set1_epi64x(b);
  const auto lanes = reinterpret_cast<__m256i>(a);
  const __m256i even = _mm256_mul_epu32(lanes, factor);
  const __m256i odd = _mm256_mul_epu32(_mm256_srli_epi64(lanes, 32), factor);
  const __m256i high = _mm256_blend_epi32(_mm256_srli_epi64(even, 32), odd, 0xAA);
  const __m256i low = _mm256_blend_epi32(even, _mm256_slli_epi64(odd, 32), 0xAA);
  return {reinterpret_cast<Words>(high), reinterpret_cast<Words>(low)};
}
/// For each mask, its lanes in order.
inline constexpr auto lanes_of_mask = [] {
  std::array<std::array<std::uint32_t, width>, 1 << width> table{};
  for (std::size_t mask = 0; mask < table.size(); ++mask) {
    std::size_t next = 0;
    for (std::uint32_t lane = 0; lane < width; ++lane) {
      if ((mask >> lane & 1) != 0) table[mask][next++] = lane;
    }
  }
  return table;
}();
inline Floats pack(Floats values, unsigned mask) {
  return _mm256_permutevar8x32_ps(values, load<__m256i>(lanes_of_mask[mask].data()));
}

#endif

inline Words pack(Words values, unsigned mask) {
  return reinterpret_cast<Words>(pack(reinterpret_cast<Floats>(values), mask));
}

inline bool any(Masks mask) { return bits(mask) != 0; }

}  // namespace parray::lanes
