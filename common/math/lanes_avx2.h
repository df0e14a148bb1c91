#pragma once

#include <immintrin.h>

#include <cstdint>

#include "common/math/inline.h"
#include "common/math/lanes.h"

/// Lanes of AVX2: 8 floats, 4 doubles. lanes_scalar.h describes members and functions. (Only
/// multiply_add() is fused: every instruction set must give the same bits.)
namespace parray::math::avx2 {

/// For compress_store(): entry `set` lists the numbers of the set bits of `set`, ascending.
struct CompressTable {
  std::uint8_t lane[256][8];

  constexpr CompressTable() : lane{} {
    for (int set = 0; set < 256; ++set) {
      int next = 0;
      for (int bit = 0; bit < 8; ++bit) {
        if ((set >> bit & 1) != 0) lane[set][next++] = static_cast<std::uint8_t>(bit);
      }
    }
  }
};
inline constexpr CompressTable compress_table;

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

struct Uint4 {
  __m128i v;

  Uint4() = default;
  PARRAY_INLINE explicit Uint4(__m128i value) : v(value) {}
  PARRAY_INLINE explicit Uint4(std::uint32_t all) : v(_mm_set1_epi32(static_cast<int>(all))) {}
  static PARRAY_INLINE Uint4 load(const std::uint32_t* from) {
    return Uint4(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from)));
  }
  PARRAY_INLINE void store(std::uint32_t* to) const {
    _mm_storeu_si128(reinterpret_cast<__m128i*>(to), v);
  }

  static PARRAY_INLINE Uint4 gather(const std::uint32_t* table, Uint4 index) {
    return Uint4(_mm_i32gather_epi32(reinterpret_cast<const int*>(table), index.v, 4));
  }
  PARRAY_LANES_OPERATOR(Uint4, &, _mm_and_si128)
  PARRAY_LANES_OPERATOR(Uint4, +, _mm_add_epi32)
  PARRAY_LANES_OPERATOR(Uint4, ^, _mm_xor_si128)
  PARRAY_LANES_OPERATOR(Uint4, *, _mm_mullo_epi32)
  PARRAY_LANES_SHIFT(Uint4, >>, _mm_srli_epi32, int)
  PARRAY_LANES_SHIFT(Uint4, <<, _mm_slli_epi32, int)
};
PARRAY_INLINE WideProduct<Uint4> multiply_wide(Uint4 a, Uint4 b) {
  const __m128i even = _mm_mul_epu32(a.v, b.v);
  const __m128i odd = _mm_mul_epu32(_mm_srli_epi64(a.v, 32), _mm_srli_epi64(b.v, 32));
  return {Uint4(_mm_blend_epi32(_mm_srli_epi64(even, 32), odd, 0xA)),
          Uint4(_mm_blend_epi32(even, _mm_slli_epi64(odd, 32), 0xA))};
}

PARRAY_INLINE Uint8 one_shifted_by(Uint8 count) {
  return Uint8(_mm256_sllv_epi32(_mm256_set1_epi32(1), count.v));
}
PARRAY_INLINE Uint4 one_shifted_by(Uint4 count) {
  return Uint4(_mm_sllv_epi32(_mm_set1_epi32(1), count.v));
}

/// Mask of Float8: lanes of all ones or all zeros.
struct Mask8 {
  __m256 m;

  friend PARRAY_INLINE Mask8 operator&(Mask8 a, Mask8 b) { return {_mm256_and_ps(a.m, b.m)}; }
  friend PARRAY_INLINE Mask8 operator|(Mask8 a, Mask8 b) { return {_mm256_or_ps(a.m, b.m)}; }
};
PARRAY_INLINE bool any(Mask8 mask) { return _mm256_movemask_ps(mask.m) != 0; }
PARRAY_INLINE std::uint32_t bits_of(Mask8 mask) {
  return static_cast<std::uint32_t>(_mm256_movemask_ps(mask.m));
}

/// Results of load_order(): the numbers of lanes as 32-bit integers.
struct Order8 {
  __m256i lane;
};
struct Order4 {
  __m128i lane;
};

struct Float8 {
  using Scalar = float;
  using Mask = Mask8;
  using Uint = Uint8;
  static constexpr int count = 8;

  __m256 v;

  Float8() = default;
  PARRAY_INLINE explicit Float8(__m256 value) : v(value) {}
  PARRAY_INLINE explicit Float8(float all) : v(_mm256_set1_ps(all)) {}
  static PARRAY_INLINE Float8 load(const float* from) { return Float8(_mm256_loadu_ps(from)); }
  static PARRAY_INLINE Float8 narrow(const double* from) {
    const __m128 low = _mm256_cvtpd_ps(_mm256_loadu_pd(from));
    const __m128 high = _mm256_cvtpd_ps(_mm256_loadu_pd(from + 4));
    return Float8(_mm256_set_m128(high, low));
  }
  static PARRAY_INLINE Float8 gather(const float* table, Uint8 index) {
    return Float8(_mm256_i32gather_ps(table, index.v, 4));
  }
  static PARRAY_INLINE Float8 from(Uint8 integer) { return Float8(_mm256_cvtepi32_ps(integer.v)); }
  PARRAY_INLINE void store(float* to) const { _mm256_storeu_ps(to, v); }
  static PARRAY_INLINE Order8 load_order(const std::uint8_t* order) {
    return {_mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(order)))};
  }

  PARRAY_LANES_OPERATOR(Float8, +, _mm256_add_ps)
  PARRAY_LANES_OPERATOR(Float8, -, _mm256_sub_ps)
  PARRAY_LANES_OPERATOR(Float8, *, _mm256_mul_ps)
  PARRAY_LANES_OPERATOR(Float8, /, _mm256_div_ps)
  friend PARRAY_INLINE Float8 operator-(Float8 a) {
    return Float8(_mm256_xor_ps(a.v, _mm256_set1_ps(-0.0F)));
  }
  PARRAY_LANES_COMPARISONS(Float8, _mm256_cmp_ps)
};
PARRAY_INLINE Float8 select(Mask8 mask, Float8 a, Float8 b) {
  return Float8(_mm256_blendv_ps(b.v, a.v, mask.m));
}
PARRAY_INLINE Float8 select_bits(std::uint32_t bits, Float8 a, Float8 b) {
  const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
  const __m256i set = _mm256_and_si256(_mm256_set1_epi32(static_cast<int>(bits)), bit);
  return select(Mask8{_mm256_castsi256_ps(_mm256_cmpeq_epi32(set, bit))}, a, b);
}
PARRAY_INLINE Float8 min_of(Float8 a, Float8 b) { return Float8(_mm256_min_ps(a.v, b.v)); }
PARRAY_INLINE Float8 max_of(Float8 a, Float8 b) { return Float8(_mm256_max_ps(a.v, b.v)); }
PARRAY_INLINE Float8 multiply_add(Float8 a, Float8 b, Float8 c) {
  return Float8(_mm256_fmadd_ps(a.v, b.v, c.v));
}
PARRAY_INLINE Float8 square_root(Float8 a) { return Float8(_mm256_sqrt_ps(a.v)); }
PARRAY_INLINE Mask8 equal(Uint8 a, Uint8 b) {
  return {_mm256_castsi256_ps(_mm256_cmpeq_epi32(a.v, b.v))};
}
PARRAY_INLINE Uint8 select(Mask8 mask, Uint8 a, Uint8 b) {
  return Uint8(_mm256_blendv_epi8(b.v, a.v, _mm256_castps_si256(mask.m)));
}
PARRAY_INLINE Uint8 select_bits(std::uint32_t bits, Uint8 a, Uint8 b) {
  const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
  const __m256i set = _mm256_and_si256(_mm256_set1_epi32(static_cast<int>(bits)), bit);
  return Uint8(_mm256_blendv_epi8(b.v, a.v, _mm256_cmpeq_epi32(set, bit)));
}
PARRAY_INLINE Float8 least_of(Float8 a) {
  __m256 m = _mm256_min_ps(a.v, _mm256_permute2f128_ps(a.v, a.v, 1));
  m = _mm256_min_ps(m, _mm256_permute_ps(m, 0x4E));
  return Float8(_mm256_min_ps(m, _mm256_permute_ps(m, 0xB1)));
}
PARRAY_INLINE float first_of(Float8 a) { return _mm256_cvtss_f32(a.v); }

/// Mask of Double4: lanes of all ones or all zeros.
struct Mask4 {
  __m256d m;

  friend PARRAY_INLINE Mask4 operator&(Mask4 a, Mask4 b) { return {_mm256_and_pd(a.m, b.m)}; }
  friend PARRAY_INLINE Mask4 operator|(Mask4 a, Mask4 b) { return {_mm256_or_pd(a.m, b.m)}; }
};
PARRAY_INLINE bool any(Mask4 mask) { return _mm256_movemask_pd(mask.m) != 0; }
PARRAY_INLINE std::uint32_t bits_of(Mask4 mask) {
  return static_cast<std::uint32_t>(_mm256_movemask_pd(mask.m));
}

struct Double4 {
  using Scalar = double;
  using Mask = Mask4;
  using Uint = Uint4;
  static constexpr int count = 4;

  __m256d v;

  Double4() = default;
  PARRAY_INLINE explicit Double4(__m256d value) : v(value) {}
  PARRAY_INLINE explicit Double4(double all) : v(_mm256_set1_pd(all)) {}
  static PARRAY_INLINE Double4 load(const double* from) { return Double4(_mm256_loadu_pd(from)); }
  static PARRAY_INLINE Double4 load(const float* from) {
    return Double4(_mm256_cvtps_pd(_mm_loadu_ps(from)));
  }
  static PARRAY_INLINE Double4 gather(const double* table, Uint4 index) {
    return Double4(_mm256_i32gather_pd(table, index.v, 8));
  }
  static PARRAY_INLINE Double4 gather(const float* table, Uint4 index) {
    return Double4(_mm256_cvtps_pd(_mm_i32gather_ps(table, index.v, 4)));
  }
  static PARRAY_INLINE Double4 from(Uint4 integer) {
    return Double4(_mm256_cvtepi32_pd(integer.v));
  }
  PARRAY_INLINE void store(double* to) const { _mm256_storeu_pd(to, v); }
  static PARRAY_INLINE Order4 load_order(const std::uint8_t* order) {
    int packed;
    __builtin_memcpy(&packed, order, 4);
    return {_mm_cvtepu8_epi32(_mm_cvtsi32_si128(packed))};
  }

  PARRAY_LANES_OPERATOR(Double4, +, _mm256_add_pd)
  PARRAY_LANES_OPERATOR(Double4, -, _mm256_sub_pd)
  PARRAY_LANES_OPERATOR(Double4, *, _mm256_mul_pd)
  PARRAY_LANES_OPERATOR(Double4, /, _mm256_div_pd)
  friend PARRAY_INLINE Double4 operator-(Double4 a) {
    return Double4(_mm256_xor_pd(a.v, _mm256_set1_pd(-0.0)));
  }
  PARRAY_LANES_COMPARISONS(Double4, _mm256_cmp_pd)
};
PARRAY_INLINE Double4 select(Mask4 mask, Double4 a, Double4 b) {
  return Double4(_mm256_blendv_pd(b.v, a.v, mask.m));
}
PARRAY_INLINE Double4 select_bits(std::uint32_t bits, Double4 a, Double4 b) {
  const __m256i bit = _mm256_setr_epi64x(1, 2, 4, 8);
  const __m256i set = _mm256_and_si256(_mm256_set1_epi64x(static_cast<long long>(bits)), bit);
  return select(Mask4{_mm256_castsi256_pd(_mm256_cmpeq_epi64(set, bit))}, a, b);
}
PARRAY_INLINE Double4 min_of(Double4 a, Double4 b) { return Double4(_mm256_min_pd(a.v, b.v)); }
PARRAY_INLINE Double4 max_of(Double4 a, Double4 b) { return Double4(_mm256_max_pd(a.v, b.v)); }
PARRAY_INLINE Double4 multiply_add(Double4 a, Double4 b, Double4 c) {
  return Double4(_mm256_fmadd_pd(a.v, b.v, c.v));
}
PARRAY_INLINE Double4 square_root(Double4 a) { return Double4(_mm256_sqrt_pd(a.v)); }
PARRAY_INLINE Mask4 equal(Uint4 a, Uint4 b) {
  return {_mm256_castsi256_pd(_mm256_cvtepi32_epi64(_mm_cmpeq_epi32(a.v, b.v)))};
}
PARRAY_INLINE Uint4 select(Mask4 mask, Uint4 a, Uint4 b) {
  const __m256i wide = _mm256_castpd_si256(mask.m);
  const __m256i even = _mm256_permutevar8x32_epi32(wide, _mm256_setr_epi32(0, 2, 4, 6, 0, 2, 4, 6));
  return Uint4(_mm_blendv_epi8(b.v, a.v, _mm256_castsi256_si128(even)));
}
PARRAY_INLINE Uint4 select_bits(std::uint32_t bits, Uint4 a, Uint4 b) {
  const __m128i bit = _mm_setr_epi32(1, 2, 4, 8);
  const __m128i set = _mm_and_si128(_mm_set1_epi32(static_cast<int>(bits)), bit);
  return Uint4(_mm_blendv_epi8(b.v, a.v, _mm_cmpeq_epi32(set, bit)));
}
PARRAY_INLINE Double4 least_of(Double4 a) {
  const __m256d m = _mm256_min_pd(a.v, _mm256_permute2f128_pd(a.v, a.v, 1));
  return Double4(_mm256_min_pd(m, _mm256_permute_pd(m, 0x5)));
}
PARRAY_INLINE double first_of(Double4 a) { return _mm256_cvtsd_f64(a.v); }

PARRAY_INLINE Float8 permute(Float8 a, Order8 order) {
  return Float8(_mm256_permutevar8x32_ps(a.v, order.lane));
}
PARRAY_INLINE Uint8 permute(Uint8 a, Order8 order) {
  return Uint8(_mm256_permutevar8x32_epi32(a.v, order.lane));
}
/// Doubles move as pairs of 32-bit halves.
PARRAY_INLINE Double4 permute(Double4 a, Order4 order) {
  const __m256i lane = _mm256_cvtepu32_epi64(order.lane);
  const __m256i low = _mm256_add_epi64(lane, lane);
  const __m256i high = _mm256_add_epi64(low, _mm256_set1_epi64x(1));
  const __m256i halves = _mm256_or_si256(low, _mm256_slli_epi64(high, 32));
  return Double4(_mm256_castps_pd(_mm256_permutevar8x32_ps(_mm256_castpd_ps(a.v), halves)));
}
PARRAY_INLINE Uint4 permute(Uint4 a, Order4 order) {
  return Uint4(_mm_castps_si128(_mm_permutevar_ps(_mm_castsi128_ps(a.v), order.lane)));
}
PARRAY_INLINE void compress_store(float* to, std::uint32_t set, Float8 a) {
  permute(a, Float8::load_order(compress_table.lane[set])).store(to);
}
PARRAY_INLINE void compress_store(std::uint32_t* to, std::uint32_t set, Uint8 a) {
  permute(a, Float8::load_order(compress_table.lane[set])).store(to);
}
PARRAY_INLINE void compress_store(double* to, std::uint32_t set, Double4 a) {
  permute(a, Double4::load_order(compress_table.lane[set])).store(to);
}
PARRAY_INLINE void compress_store(std::uint32_t* to, std::uint32_t set, Uint4 a) {
  permute(a, Double4::load_order(compress_table.lane[set])).store(to);
}

/// The lanes that the kernels use.
using FloatLanes = Float8;
using DoubleLanes = Double4;

}  // namespace parray::math::avx2

namespace parray::math {

template <>
struct RealTraits<avx2::Float8> : RealTraits<float> {};
template <>
struct RealTraits<avx2::Double4> : RealTraits<double> {};

}  // namespace parray::math
