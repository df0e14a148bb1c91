#pragma once

#include <arm_neon.h>

#include <cstdint>

#include "common/math/inline.h"
#include "common/math/lanes.h"

/// Lanes of NEON (aarch64): registers of 4 floats or 2 doubles, several to a number of lanes.
/// Members and functions as in lanes.h. (No fused multiply-add: every instruction set has to give
/// the same bits; and no fmin or fmax, which have other ideas of NaN and -0.)
namespace parray::neon {

template <typename T>
struct Register;
template <>
struct Register<float> {
  using Type = float32x4_t;
  using Bits = uint32x4_t;
};
template <>
struct Register<double> {
  using Type = float64x2_t;
  using Bits = uint64x2_t;
};

PARRAY_INLINE float32x4_t broadcast(float all) { return vdupq_n_f32(all); }
PARRAY_INLINE float64x2_t broadcast(double all) { return vdupq_n_f64(all); }

PARRAY_INLINE float32x4_t choose(uint32x4_t mask, float32x4_t a, float32x4_t b) {
  return vbslq_f32(mask, a, b);
}
PARRAY_INLINE float64x2_t choose(uint64x2_t mask, float64x2_t a, float64x2_t b) {
  return vbslq_f64(mask, a, b);
}
PARRAY_INLINE uint32x4_t choose(uint32x4_t mask, uint32x4_t a, uint32x4_t b) {
  return vbslq_u32(mask, a, b);
}

/// Lane i: whether bit `first` + i of `bits` is set.
PARRAY_INLINE void spread(std::uint32_t bits, int first, uint32x4_t& mask) {
  constexpr uint32x4_t bit{1, 2, 4, 8};
  mask = vtstq_u32(vdupq_n_u32(bits >> first), bit);
}
PARRAY_INLINE void spread(std::uint32_t bits, int first, uint64x2_t& mask) {
  constexpr uint64x2_t bit{1, 2};
  mask = vtstq_u64(vdupq_n_u64(bits >> first), bit);
}

/// Lanes of all ones or all zeros.
template <typename T, int N>
struct Mask {
  using Bits = typename Register<T>::Bits;
  static constexpr int registers = N * int{sizeof(T)} / 16;

  Bits m[registers];

  static PARRAY_INLINE Mask from_bits(std::uint32_t bits) {
    Mask r;
    for (int i = 0; i < registers; ++i) {
      spread(bits, i * N / registers, r.m[i]);
    }
    return r;
  }
  /// The lanes [4 i, 4 i + 4) as those of 32-bit numbers.
  [[nodiscard]] PARRAY_INLINE uint32x4_t words(int i) const {
    if constexpr (sizeof(T) == 4) {
      return m[i];
    } else {
      return vuzp1q_u32(vreinterpretq_u32_u64(m[2 * i]), vreinterpretq_u32_u64(m[2 * i + 1]));
    }
  }
  friend PARRAY_INLINE Mask operator&(const Mask& a, const Mask& b) {
    Mask r;
    for (int i = 0; i < registers; ++i) {
      r.m[i] = a.m[i] & b.m[i];
    }
    return r;
  }
  friend PARRAY_INLINE Mask operator|(const Mask& a, const Mask& b) {
    Mask r;
    for (int i = 0; i < registers; ++i) {
      r.m[i] = a.m[i] | b.m[i];
    }
    return r;
  }
};
template <typename T, int N>
PARRAY_INLINE std::uint32_t bits_of(const Mask<T, N>& mask) {
  uint32x4_t set{};
  for (int i = 0; i < N / 4; ++i) {
    constexpr uint32x4_t bit{1, 2, 4, 8};
    set |= mask.words(i) & (bit << (4 * i));
  }
  return vaddvq_u32(set);
}
template <typename T, int N>
PARRAY_INLINE bool any(const Mask<T, N>& mask) {
  auto some = mask.m[0];
  for (int i = 1; i < Mask<T, N>::registers; ++i) {
    some |= mask.m[i];
  }
  return vmaxvq_u32(reinterpret_cast<uint32x4_t>(some)) != 0;
}

/// An order of lanes, as bytes.
struct Order {
  uint8x16_t lane;

  /// Bytes of the i-th register that `Size`-byte lanes in this order fill.
  template <int Size>
  [[nodiscard]] PARRAY_INLINE uint8x16_t bytes(int i) const {
    constexpr uint8x16_t number{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    constexpr std::uint8_t size = Size;
    const uint8x16_t place = number / size + static_cast<std::uint8_t>(i * (16 / Size));
    return vqtbl1q_u8(lane, place) * size + number % size;
  }
};

template <int Registers, typename Type>
PARRAY_INLINE uint8x16_t pick(const Type (&from)[Registers], uint8x16_t bytes) {
  static_assert(Registers == 1 || Registers == 2 || Registers == 4);
  if constexpr (Registers == 1) {
    return vqtbl1q_u8(reinterpret_cast<uint8x16_t>(from[0]), bytes);
  } else if constexpr (Registers == 2) {
    return vqtbl2q_u8(
        {{reinterpret_cast<uint8x16_t>(from[0]), reinterpret_cast<uint8x16_t>(from[1])}}, bytes);
  } else {
    return vqtbl4q_u8(
        {{reinterpret_cast<uint8x16_t>(from[0]), reinterpret_cast<uint8x16_t>(from[1]),
          reinterpret_cast<uint8x16_t>(from[2]), reinterpret_cast<uint8x16_t>(from[3])}},
        bytes);
  }
}

/// Bytes that a register's lanes of `Size` bytes leave when they are stored one after the other:
/// entry `set` has those of its set bits.
template <int Size>
struct CompressTable {
  static constexpr int lanes = 16 / Size;
  alignas(16) std::uint8_t byte[1 << lanes][16];

  constexpr CompressTable() : byte{} {
    for (int set = 0; set < 1 << lanes; ++set) {
      int next = 0;
      for (int i = 0; i < 16; ++i) {
        if ((set >> (i / Size) & 1) != 0) {
          byte[set][next++] = static_cast<std::uint8_t>(i);
        }
      }
    }
  }
};
template <int Size>
inline constexpr CompressTable<Size> compress_table;

template <int Registers, typename Type, typename Element>
PARRAY_INLINE void compress_registers(const Type (&from)[Registers], std::uint32_t set,
                                      Element* to) {
  constexpr int size = sizeof(Element);
  constexpr int lanes = 16 / size;
  for (int i = 0; i < Registers; ++i) {
    const std::uint32_t here = set >> (i * lanes) & ((1U << lanes) - 1U);
    const uint8x16_t packed = vqtbl1q_u8(reinterpret_cast<uint8x16_t>(from[i]),
                                         vld1q_u8(compress_table<size>.byte[here]));
    vst1q_u8(reinterpret_cast<std::uint8_t*>(to), packed);
    to += __builtin_popcount(here);
  }
}

/// Integers beside lanes of T.
template <typename T, int N>
struct Uints {
  static constexpr int registers = N / 4;
  uint32x4_t v[registers];

  Uints() = default;
  PARRAY_INLINE explicit Uints(std::uint32_t all) {
    for (uint32x4_t& r : v) {
      r = vdupq_n_u32(all);
    }
  }
  static PARRAY_INLINE Uints load(const std::uint32_t* from) {
    Uints r;
    for (int i = 0; i < registers; ++i) {
      r.v[i] = vld1q_u32(from + 4 * i);
    }
    return r;
  }
  PARRAY_INLINE void store(std::uint32_t* to) const {
    for (int i = 0; i < registers; ++i) {
      vst1q_u32(to + 4 * i, v[i]);
    }
  }
  static PARRAY_INLINE Uints gather(const std::uint32_t* table, const Uints& index) {
    Uints r;
    for (int i = 0; i < registers; ++i) {
      const uint32x4_t at = index.v[i];
      r.v[i] = uint32x4_t{table[at[0]], table[at[1]], table[at[2]], table[at[3]]};
    }
    return r;
  }
#define PARRAY_UINTS_OPERATOR(op)                                          \
  friend PARRAY_INLINE Uints operator op(const Uints& a, const Uints& b) { \
    Uints r;                                                               \
    for (int i = 0; i < registers; ++i) {                                  \
      r.v[i] = a.v[i] op b.v[i];                                           \
    }                                                                      \
    return r;                                                              \
  }
  PARRAY_UINTS_OPERATOR(&)
  PARRAY_UINTS_OPERATOR(+)
  PARRAY_UINTS_OPERATOR(^)
  PARRAY_UINTS_OPERATOR(*)
#undef PARRAY_UINTS_OPERATOR
  friend PARRAY_INLINE Uints operator>>(const Uints& a, int count) {
    Uints r;
    for (int i = 0; i < registers; ++i) {
      r.v[i] = a.v[i] >> count;
    }
    return r;
  }
  friend PARRAY_INLINE Uints operator<<(const Uints& a, int count) {
    Uints r;
    for (int i = 0; i < registers; ++i) {
      r.v[i] = a.v[i] << count;
    }
    return r;
  }
};
template <typename T, int N>
PARRAY_INLINE WideProduct<Uints<T, N>> multiply_wide(const Uints<T, N>& a, const Uints<T, N>& b) {
  WideProduct<Uints<T, N>> r;
  for (int i = 0; i < N / 4; ++i) {
    const auto low = vreinterpretq_u32_u64(vmull_u32(vget_low_u32(a.v[i]), vget_low_u32(b.v[i])));
    const auto high = vreinterpretq_u32_u64(vmull_high_u32(a.v[i], b.v[i]));
    r.high.v[i] = vuzp2q_u32(low, high);
    r.low.v[i] = vuzp1q_u32(low, high);
  }
  return r;
}
template <typename T, int N>
PARRAY_INLINE Mask<T, N> equal(const Uints<T, N>& a, const Uints<T, N>& b) {
  Mask<T, N> r;
  for (int i = 0; i < N / 4; ++i) {
    const uint32x4_t same = vceqq_u32(a.v[i], b.v[i]);
    if constexpr (sizeof(T) == 4) {
      r.m[i] = same;
    } else {
      r.m[2 * i] = vreinterpretq_u64_u32(vzip1q_u32(same, same));
      r.m[2 * i + 1] = vreinterpretq_u64_u32(vzip2q_u32(same, same));
    }
  }
  return r;
}
template <typename T, int N>
PARRAY_INLINE Uints<T, N> select(const Mask<T, N>& mask, const Uints<T, N>& a,
                                 const Uints<T, N>& b) {
  Uints<T, N> r;
  for (int i = 0; i < N / 4; ++i) {
    r.v[i] = choose(mask.words(i), a.v[i], b.v[i]);
  }
  return r;
}
template <typename T, int N>
PARRAY_INLINE Uints<T, N> select_bits(std::uint32_t bits, const Uints<T, N>& a,
                                      const Uints<T, N>& b) {
  Uints<T, N> r;
  for (int i = 0; i < N / 4; ++i) {
    uint32x4_t mask;
    spread(bits, 4 * i, mask);
    r.v[i] = choose(mask, a.v[i], b.v[i]);
  }
  return r;
}
template <typename T, int N>
PARRAY_INLINE Uints<T, N> permute(const Uints<T, N>& a, const Order& order) {
  Uints<T, N> r;
  for (int i = 0; i < N / 4; ++i) {
    r.v[i] = reinterpret_cast<uint32x4_t>(pick(a.v, order.bytes<4>(i)));
  }
  return r;
}
template <typename T, int N>
PARRAY_INLINE void compress_store(std::uint32_t* to, std::uint32_t set, const Uints<T, N>& a) {
  compress_registers(a.v, set, to);
}

/// Real numbers, N of them.
template <typename T, int N>
struct Reals {
  using Scalar = T;
  using Mask = neon::Mask<T, N>;
  using Uint = Uints<T, N>;
  using Type = typename Register<T>::Type;
  using Bits = typename Register<T>::Bits;
  static constexpr int count = N;
  static constexpr int registers = Mask::registers;

  Type v[registers];

  Reals() = default;
  PARRAY_INLINE explicit Reals(T all) {
    for (Type& r : v) {
      r = broadcast(all);
    }
  }
  static PARRAY_INLINE Reals load(const T* from) {
    Reals r;
    for (int i = 0; i < registers; ++i) {
      __builtin_memcpy(&r.v[i], from + i * N / registers, 16);
    }
    return r;
  }
  static PARRAY_INLINE Reals load(const float* from) requires(sizeof(T) == 8) {
    Reals r;
    for (int i = 0; i < registers; ++i) {
      r.v[i] = vcvt_f64_f32(vld1_f32(from + 2 * i));
    }
    return r;
  }
  static PARRAY_INLINE Reals narrow(const double* from) requires(sizeof(T) == 4) {
    Reals r;
    for (int i = 0; i < registers; ++i) {
      r.v[i] =
          vcvt_high_f32_f64(vcvt_f32_f64(vld1q_f64(from + 4 * i)), vld1q_f64(from + 4 * i + 2));
    }
    return r;
  }
  template <typename From>
  static PARRAY_INLINE Reals gather(const From* table, const Uint& index) {
    const auto at = [&](int i) { return table[index.v[i / 4][i % 4]]; };
    Reals r;
    for (int i = 0; i < registers; ++i) {
      if constexpr (sizeof(T) == 4) {
        r.v[i] = float32x4_t{at(4 * i), at(4 * i + 1), at(4 * i + 2), at(4 * i + 3)};
      } else if constexpr (sizeof(From) == 4) {
        r.v[i] = vcvt_f64_f32(float32x2_t{at(2 * i), at(2 * i + 1)});
      } else {
        r.v[i] = float64x2_t{at(2 * i), at(2 * i + 1)};
      }
    }
    return r;
  }
  static PARRAY_INLINE Reals from(const Uint& integer) {
    Reals r;
    for (int i = 0; i < N / 4; ++i) {
      if constexpr (sizeof(T) == 4) {
        r.v[i] = vcvtq_f32_u32(integer.v[i]);
      } else {
        r.v[2 * i] = vcvtq_f64_u64(vmovl_u32(vget_low_u32(integer.v[i])));
        r.v[2 * i + 1] = vcvtq_f64_u64(vmovl_high_u32(integer.v[i]));
      }
    }
    return r;
  }
  PARRAY_INLINE void store(T* to) const { __builtin_memcpy(to, v, sizeof v); }
  static PARRAY_INLINE Order load_order(const std::uint8_t* order) {
    if constexpr (N == 8) {
      return {vcombine_u8(vld1_u8(order), vdup_n_u8(0))};
    } else {
      static_assert(N == 4);
      std::uint32_t lanes;
      __builtin_memcpy(&lanes, order, sizeof lanes);
      return {vreinterpretq_u8_u32(vdupq_n_u32(lanes))};
    }
  }

#define PARRAY_REALS_OPERATOR(op)                                          \
  friend PARRAY_INLINE Reals operator op(const Reals& a, const Reals& b) { \
    Reals r;                                                               \
    for (int i = 0; i < registers; ++i) {                                  \
      r.v[i] = a.v[i] op b.v[i];                                           \
    }                                                                      \
    return r;                                                              \
  }
  PARRAY_REALS_OPERATOR(+)
  PARRAY_REALS_OPERATOR(-)
  PARRAY_REALS_OPERATOR(*)
  PARRAY_REALS_OPERATOR(/)
#undef PARRAY_REALS_OPERATOR
#define PARRAY_REALS_COMPARISON(op)                                       \
  friend PARRAY_INLINE Mask operator op(const Reals& a, const Reals& b) { \
    Mask r;                                                               \
    for (int i = 0; i < registers; ++i) {                                 \
      r.m[i] = reinterpret_cast<Bits>(a.v[i] op b.v[i]);                  \
    }                                                                     \
    return r;                                                             \
  }
  PARRAY_REALS_COMPARISON(<)
  PARRAY_REALS_COMPARISON(<=)
  PARRAY_REALS_COMPARISON(>)
  PARRAY_REALS_COMPARISON(>=)
  PARRAY_REALS_COMPARISON(==)
#undef PARRAY_REALS_COMPARISON
  friend PARRAY_INLINE Reals operator-(const Reals& a) {
    Reals r;
    for (int i = 0; i < registers; ++i) {
      r.v[i] = -a.v[i];
    }
    return r;
  }
};
template <typename T, int N>
PARRAY_INLINE Reals<T, N> select(const Mask<T, N>& mask, const Reals<T, N>& a,
                                 const Reals<T, N>& b) {
  Reals<T, N> r;
  for (int i = 0; i < Reals<T, N>::registers; ++i) {
    r.v[i] = choose(mask.m[i], a.v[i], b.v[i]);
  }
  return r;
}
template <typename T, int N>
PARRAY_INLINE Reals<T, N> select_bits(std::uint32_t bits, const Reals<T, N>& a,
                                      const Reals<T, N>& b) {
  return select(Mask<T, N>::from_bits(bits), a, b);
}
template <typename T, int N>
PARRAY_INLINE Reals<T, N> min_of(const Reals<T, N>& a, const Reals<T, N>& b) {
  return select(a < b, a, b);
}
template <typename T, int N>
PARRAY_INLINE Reals<T, N> max_of(const Reals<T, N>& a, const Reals<T, N>& b) {
  return select(a > b, a, b);
}
template <int N>
PARRAY_INLINE Reals<float, N> square_root(const Reals<float, N>& a) {
  Reals<float, N> r;
  for (int i = 0; i < N / 4; ++i) {
    r.v[i] = vsqrtq_f32(a.v[i]);
  }
  return r;
}
template <int N>
PARRAY_INLINE Reals<double, N> square_root(const Reals<double, N>& a) {
  Reals<double, N> r;
  for (int i = 0; i < N / 2; ++i) {
    r.v[i] = vsqrtq_f64(a.v[i]);
  }
  return r;
}
// Here fmin is right: none is NaN.
template <int N>
PARRAY_INLINE Reals<float, N> least_of(const Reals<float, N>& a) {
  float32x4_t least = a.v[0];
  for (int i = 1; i < N / 4; ++i) {
    least = vminq_f32(least, a.v[i]);
  }
  return Reals<float, N>(vminvq_f32(least));
}
template <int N>
PARRAY_INLINE Reals<double, N> least_of(const Reals<double, N>& a) {
  float64x2_t least = a.v[0];
  for (int i = 1; i < N / 2; ++i) {
    least = vminq_f64(least, a.v[i]);
  }
  return Reals<double, N>(vminvq_f64(least));
}
template <typename T, int N>
PARRAY_INLINE T first_of(const Reals<T, N>& a) {
  return a.v[0][0];
}
template <typename T, int N>
PARRAY_INLINE Reals<T, N> permute(const Reals<T, N>& a, const Order& order) {
  Reals<T, N> r;
  for (int i = 0; i < Reals<T, N>::registers; ++i) {
    r.v[i] = reinterpret_cast<typename Register<T>::Type>(pick(a.v, order.bytes<sizeof(T)>(i)));
  }
  return r;
}
template <typename T, int N>
PARRAY_INLINE void compress_store(T* to, std::uint32_t set, const Reals<T, N>& a) {
  compress_registers(a.v, set, to);
}

/// Those of the kernels.
using FloatLanes = Reals<float, 8>;
using DoubleLanes = Reals<double, 4>;

}  // namespace parray::neon

namespace parray {

template <typename T, int N>
struct RealTraits<neon::Reals<T, N>> : RealTraits<T> {};

}  // namespace parray
