#pragma once

#include <immintrin.h>

#include <cstdint>

#include "common/math/inline.h"
#include "common/math/lanes.h"

/// Lanes of AVX-512 (F, DQ, VL, BW): 16 floats, 8 doubles. lanes_scalar.h describes members and
/// functions.
namespace parray::math::avx512 {

template <int N>
struct Mask {
  static_assert(N == 8 || N == 16);
  __mmask16 k;

  friend PARRAY_INLINE Mask operator&(Mask a, Mask b) {
    return {static_cast<__mmask16>(a.k & b.k)};
  }
  friend PARRAY_INLINE Mask operator|(Mask a, Mask b) {
    return {static_cast<__mmask16>(a.k | b.k)};
  }
};
template <int N>
PARRAY_INLINE bool any(Mask<N> mask) {
  return mask.k != 0;
}
template <int N>
PARRAY_INLINE std::uint32_t bits_of(Mask<N> mask) {
  return mask.k;
}

struct Uint16 {
  __m512i v;

  Uint16() = default;
  PARRAY_INLINE explicit Uint16(__m512i value) : v(value) {}
  PARRAY_INLINE explicit Uint16(std::uint32_t all) : v(_mm512_set1_epi32(static_cast<int>(all))) {}
  static PARRAY_INLINE Uint16 load(const std::uint32_t* from) {
    return Uint16(_mm512_loadu_si512(from));
  }
  PARRAY_INLINE void store(std::uint32_t* to) const { _mm512_storeu_si512(to, v); }

  static PARRAY_INLINE Uint16 gather(const std::uint32_t* table, Uint16 index) {
    return Uint16(_mm512_i32gather_epi32(index.v, table, 4));
  }
  PARRAY_LANES_OPERATOR(Uint16, &, _mm512_and_si512)
  PARRAY_LANES_OPERATOR(Uint16, +, _mm512_add_epi32)
  PARRAY_LANES_OPERATOR(Uint16, ^, _mm512_xor_si512)
  PARRAY_LANES_OPERATOR(Uint16, *, _mm512_mullo_epi32)
  PARRAY_LANES_SHIFT(Uint16, >>, _mm512_srli_epi32, unsigned)
  PARRAY_LANES_SHIFT(Uint16, <<, _mm512_slli_epi32, unsigned)
};
PARRAY_INLINE WideProduct<Uint16> multiply_wide(Uint16 a, Uint16 b) {
  const __m512i even = _mm512_mul_epu32(a.v, b.v);
  const __m512i odd = _mm512_mul_epu32(_mm512_srli_epi64(a.v, 32), _mm512_srli_epi64(b.v, 32));
  return {Uint16(_mm512_mask_blend_epi32(0xAAAA, _mm512_srli_epi64(even, 32), odd)),
          Uint16(_mm512_mask_blend_epi32(0xAAAA, even, _mm512_slli_epi64(odd, 32)))};
}

struct Uint8 {
  __m256i v;

  Uint8() = default;
  PARRAY_INLINE explicit Uint8(__m256i value) : v(value) {}
  PARRAY_INLINE explicit Uint8(std::uint32_t all) : v(_mm256_set1_epi32(static_cast<int>(all))) {}
  static PARRAY_INLINE Uint8 load(const std::uint32_t* from) {
    return Uint8(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(from)));
  }
  PARRAY_INLINE void store(std::uint32_t* to) const {
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), v);
  }

  static PARRAY_INLINE Uint8 gather(const std::uint32_t* table, Uint8 index) {
    return Uint8(_mm256_i32gather_epi32(reinterpret_cast<const int*>(table), index.v, 4));
  }
  PARRAY_LANES_OPERATOR(Uint8, &, _mm256_and_si256)
  PARRAY_LANES_OPERATOR(Uint8, +, _mm256_add_epi32)
  PARRAY_LANES_OPERATOR(Uint8, ^, _mm256_xor_si256)
  PARRAY_LANES_OPERATOR(Uint8, *, _mm256_mullo_epi32)
  PARRAY_LANES_SHIFT(Uint8, >>, _mm256_srli_epi32, int)
  PARRAY_LANES_SHIFT(Uint8, <<, _mm256_slli_epi32, int)
};
PARRAY_INLINE WideProduct<Uint8> multiply_wide(Uint8 a, Uint8 b) {
  const __m256i even = _mm256_mul_epu32(a.v, b.v);
  const __m256i odd = _mm256_mul_epu32(_mm256_srli_epi64(a.v, 32), _mm256_srli_epi64(b.v, 32));
  return {Uint8(_mm256_blend_epi32(_mm256_srli_epi64(even, 32), odd, 0xAA)),
          Uint8(_mm256_blend_epi32(even, _mm256_slli_epi64(odd, 32), 0xAA))};
}

PARRAY_INLINE Mask<16> equal(Uint16 a, Uint16 b) { return {_mm512_cmpeq_epi32_mask(a.v, b.v)}; }
PARRAY_INLINE Mask<8> equal(Uint8 a, Uint8 b) { return {_mm256_cmpeq_epi32_mask(a.v, b.v)}; }
PARRAY_INLINE Uint16 select(Mask<16> mask, Uint16 a, Uint16 b) {
  return Uint16(_mm512_mask_blend_epi32(mask.k, b.v, a.v));
}
PARRAY_INLINE Uint8 select(Mask<8> mask, Uint8 a, Uint8 b) {
  return Uint8(_mm256_mask_blend_epi32(static_cast<__mmask8>(mask.k), b.v, a.v));
}

PARRAY_INLINE Uint16 select_bits(std::uint32_t bits, Uint16 a, Uint16 b) {
  return select(Mask<16>{static_cast<__mmask16>(bits)}, a, b);
}
PARRAY_INLINE Uint8 select_bits(std::uint32_t bits, Uint8 a, Uint8 b) {
  return select(Mask<8>{static_cast<__mmask16>(bits)}, a, b);
}

PARRAY_INLINE Uint16 one_shifted_by(Uint16 count) {
  return Uint16(_mm512_sllv_epi32(_mm512_set1_epi32(1), count.v));
}
PARRAY_INLINE Uint8 one_shifted_by(Uint8 count) {
  return Uint8(_mm256_sllv_epi32(_mm256_set1_epi32(1), count.v));
}

/// Results of load_order(): the numbers of lanes as 32-bit integers.
struct Order16 {
  __m512i lane;
};
struct Order8 {
  __m256i lane;
};

struct Float16 {
  using Scalar = float;
  using Mask = avx512::Mask<16>;
  using Uint = Uint16;
  static constexpr int count = 16;

  __m512 v;

  Float16() = default;
  PARRAY_INLINE explicit Float16(__m512 value) : v(value) {}
  PARRAY_INLINE explicit Float16(float all) : v(_mm512_set1_ps(all)) {}
  static PARRAY_INLINE Float16 load(const float* from) { return Float16(_mm512_loadu_ps(from)); }
  static PARRAY_INLINE Float16 narrow(const double* from) {
    const __m256 low = _mm512_cvtpd_ps(_mm512_loadu_pd(from));
    const __m256 high = _mm512_cvtpd_ps(_mm512_loadu_pd(from + 8));
    return Float16(_mm512_insertf32x8(_mm512_castps256_ps512(low), high, 1));
  }
  static PARRAY_INLINE Float16 gather(const float* table, Uint16 index) {
    return Float16(_mm512_i32gather_ps(index.v, table, 4));
  }
  static PARRAY_INLINE Float16 from(Uint16 integer) {
    return Float16(_mm512_cvtepi32_ps(integer.v));
  }
  PARRAY_INLINE void store(float* to) const { _mm512_storeu_ps(to, v); }
  static PARRAY_INLINE Order16 load_order(const std::uint8_t* order) {
    return {_mm512_cvtepu8_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(order)))};
  }

  PARRAY_LANES_OPERATOR(Float16, +, _mm512_add_ps)
  PARRAY_LANES_OPERATOR(Float16, -, _mm512_sub_ps)
  PARRAY_LANES_OPERATOR(Float16, *, _mm512_mul_ps)
  PARRAY_LANES_OPERATOR(Float16, /, _mm512_div_ps)
  friend PARRAY_INLINE Float16 operator-(Float16 a) {
    return Float16(_mm512_xor_ps(a.v, _mm512_set1_ps(-0.0F)));
  }
  PARRAY_LANES_COMPARISONS(Float16, _mm512_cmp_ps_mask)
};
PARRAY_INLINE Float16 select(Mask<16> mask, Float16 a, Float16 b) {
  return Float16(_mm512_mask_blend_ps(mask.k, b.v, a.v));
}
PARRAY_INLINE Float16 select_bits(std::uint32_t bits, Float16 a, Float16 b) {
  return select(Mask<16>{static_cast<__mmask16>(bits)}, a, b);
}
PARRAY_INLINE Float16 min_of(Float16 a, Float16 b) { return Float16(_mm512_min_ps(a.v, b.v)); }
PARRAY_INLINE Float16 max_of(Float16 a, Float16 b) { return Float16(_mm512_max_ps(a.v, b.v)); }
PARRAY_INLINE Float16 multiply_add(Float16 a, Float16 b, Float16 c) {
  return Float16(_mm512_fmadd_ps(a.v, b.v, c.v));
}
PARRAY_INLINE Float16 square_root(Float16 a) { return Float16(_mm512_sqrt_ps(a.v)); }
PARRAY_INLINE Float16 least_of(Float16 a) {
  __m512 m = _mm512_min_ps(a.v, _mm512_shuffle_f32x4(a.v, a.v, 0x4E));
  m = _mm512_min_ps(m, _mm512_shuffle_f32x4(m, m, 0xB1));
  m = _mm512_min_ps(m, _mm512_permute_ps(m, 0x4E));
  return Float16(_mm512_min_ps(m, _mm512_permute_ps(m, 0xB1)));
}
PARRAY_INLINE float first_of(Float16 a) { return _mm512_cvtss_f32(a.v); }

struct Double8 {
  using Scalar = double;
  using Mask = avx512::Mask<8>;
  using Uint = Uint8;
  static constexpr int count = 8;

  __m512d v;

  Double8() = default;
  PARRAY_INLINE explicit Double8(__m512d value) : v(value) {}
  PARRAY_INLINE explicit Double8(double all) : v(_mm512_set1_pd(all)) {}
  static PARRAY_INLINE Double8 load(const double* from) { return Double8(_mm512_loadu_pd(from)); }
  static PARRAY_INLINE Double8 load(const float* from) {
    return Double8(_mm512_cvtps_pd(_mm256_loadu_ps(from)));
  }
  static PARRAY_INLINE Double8 gather(const double* table, Uint8 index) {
    return Double8(_mm512_i32gather_pd(index.v, table, 8));
  }
  static PARRAY_INLINE Double8 gather(const float* table, Uint8 index) {
    return Double8(_mm512_cvtps_pd(_mm256_i32gather_ps(table, index.v, 4)));
  }
  static PARRAY_INLINE Double8 from(Uint8 integer) {
    return Double8(_mm512_cvtepi32_pd(integer.v));
  }
  PARRAY_INLINE void store(double* to) const { _mm512_storeu_pd(to, v); }
  static PARRAY_INLINE Order8 load_order(const std::uint8_t* order) {
    return {_mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(order)))};
  }

  PARRAY_LANES_OPERATOR(Double8, +, _mm512_add_pd)
  PARRAY_LANES_OPERATOR(Double8, -, _mm512_sub_pd)
  PARRAY_LANES_OPERATOR(Double8, *, _mm512_mul_pd)
  PARRAY_LANES_OPERATOR(Double8, /, _mm512_div_pd)
  friend PARRAY_INLINE Double8 operator-(Double8 a) {
    return Double8(_mm512_xor_pd(a.v, _mm512_set1_pd(-0.0)));
  }
  PARRAY_LANES_COMPARISONS(Double8, _mm512_cmp_pd_mask)
};
PARRAY_INLINE Double8 select(Mask<8> mask, Double8 a, Double8 b) {
  return Double8(_mm512_mask_blend_pd(static_cast<__mmask8>(mask.k), b.v, a.v));
}
PARRAY_INLINE Double8 select_bits(std::uint32_t bits, Double8 a, Double8 b) {
  return select(Mask<8>{static_cast<__mmask16>(bits)}, a, b);
}
PARRAY_INLINE Double8 min_of(Double8 a, Double8 b) { return Double8(_mm512_min_pd(a.v, b.v)); }
PARRAY_INLINE Double8 max_of(Double8 a, Double8 b) { return Double8(_mm512_max_pd(a.v, b.v)); }
PARRAY_INLINE Double8 multiply_add(Double8 a, Double8 b, Double8 c) {
  return Double8(_mm512_fmadd_pd(a.v, b.v, c.v));
}
PARRAY_INLINE Double8 square_root(Double8 a) { return Double8(_mm512_sqrt_pd(a.v)); }
PARRAY_INLINE Double8 least_of(Double8 a) {
  __m512d m = _mm512_min_pd(a.v, _mm512_shuffle_f64x2(a.v, a.v, 0x4E));
  m = _mm512_min_pd(m, _mm512_shuffle_f64x2(m, m, 0xB1));
  return Double8(_mm512_min_pd(m, _mm512_permute_pd(m, 0x55)));
}
PARRAY_INLINE double first_of(Double8 a) { return _mm512_cvtsd_f64(a.v); }

PARRAY_INLINE Float16 permute(Float16 a, Order16 order) {
  return Float16(_mm512_permutexvar_ps(order.lane, a.v));
}
PARRAY_INLINE Uint16 permute(Uint16 a, Order16 order) {
  return Uint16(_mm512_permutexvar_epi32(order.lane, a.v));
}
PARRAY_INLINE Double8 permute(Double8 a, Order8 order) {
  return Double8(_mm512_permutexvar_pd(_mm512_cvtepu32_epi64(order.lane), a.v));
}
PARRAY_INLINE Uint8 permute(Uint8 a, Order8 order) {
  return Uint8(_mm256_permutevar8x32_epi32(a.v, order.lane));
}
// Compresses in a register first: the instruction that compresses into memory is slow on AMD
// processors.
PARRAY_INLINE void compress_store(float* to, std::uint32_t set, Float16 a) {
  _mm512_storeu_ps(to, _mm512_maskz_compress_ps(static_cast<__mmask16>(set), a.v));
}
PARRAY_INLINE void compress_store(std::uint32_t* to, std::uint32_t set, Uint16 a) {
  _mm512_storeu_si512(to, _mm512_maskz_compress_epi32(static_cast<__mmask16>(set), a.v));
}
PARRAY_INLINE void compress_store(double* to, std::uint32_t set, Double8 a) {
  _mm512_storeu_pd(to, _mm512_maskz_compress_pd(static_cast<__mmask8>(set), a.v));
}
PARRAY_INLINE void compress_store(std::uint32_t* to, std::uint32_t set, Uint8 a) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to),
                      _mm256_maskz_compress_epi32(static_cast<__mmask8>(set), a.v));
}

/// The lanes that the kernels use.
using FloatLanes = Float16;
using DoubleLanes = Double8;

}  // namespace parray::math::avx512

namespace parray::math {

template <>
struct RealTraits<avx512::Float16> : RealTraits<float> {};
template <>
struct RealTraits<avx512::Double8> : RealTraits<double> {};

}  // namespace parray::math
