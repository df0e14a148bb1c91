#pragma once

#include <arm_neon.h>

#include <cstdint>

#include "common/math/inline.h"
#include "common/math/lanes.h"

/// Lanes of NEON (aarch64): 4 floats in one register, 4 doubles in two. lanes_scalar.h describes
/// members and functions. (Only multiply_add() is fused: every instruction set must give the same
/// bits. fmin and fmax are not used, because they treat NaN and -0 differently. Eight floats in two
/// registers take as many instructions, or up to a tenth more.)
namespace parray::math::neon {

template <typename T>
struct Register;
template <>
struct Register<float> {
  using Type = float32x4_t;
  using Bits = uint32x4_t;
  static constexpr int count = 1;  ///< registers of 4 lanes
};
template <>
struct Register<double> {
  using Type = float64x2_t;
  using Bits = uint64x2_t;
  static constexpr int count = 2;
};

PARRAY_INLINE float32x4_t broadcast(float all) { return vdupq_n_f32(all); }
PARRAY_INLINE float64x2_t broadcast(double all) { return vdupq_n_f64(all); }
PARRAY_INLINE float32x4_t root(float32x4_t a) { return vsqrtq_f32(a); }
PARRAY_INLINE float64x2_t root(float64x2_t a) { return vsqrtq_f64(a); }
PARRAY_INLINE float32x4_t choose(uint32x4_t mask, float32x4_t a, float32x4_t b) {
  return vbslq_f32(mask, a, b);
}
PARRAY_INLINE float64x2_t choose(uint64x2_t mask, float64x2_t a, float64x2_t b) {
  return vbslq_f64(mask, a, b);
}

/// Returns all ones in lane i if bit i is set.
PARRAY_INLINE uint32x4_t spread(std::uint32_t bits) {
  constexpr uint32x4_t bit{1, 2, 4, 8};
  return vtstq_u32(vdupq_n_u32(bits), bit);
}

/// Lanes of all ones or all zeros.
template <typename T>
struct Mask {
  static constexpr int registers = Register<T>::count;
  typename Register<T>::Bits m[registers];

  /// Convert from and to the mask of 32-bit numbers.
  static PARRAY_INLINE Mask from(uint32x4_t words) {
    if constexpr (registers == 1) {
      return {{words}};
    } else {
      return {{vreinterpretq_u64_u32(vzip1q_u32(words, words)),
               vreinterpretq_u64_u32(vzip2q_u32(words, words))}};
    }
  }
  [[nodiscard]] PARRAY_INLINE uint32x4_t words() const {
    if constexpr (registers == 1) {
      return m[0];
    } else {
      return vuzp1q_u32(vreinterpretq_u32_u64(m[0]), vreinterpretq_u32_u64(m[1]));
    }
  }
  friend PARRAY_INLINE Mask operator&(const Mask& a, const Mask& b) {
    Mask r;
    for (int i = 0; i < registers; ++i) r.m[i] = a.m[i] & b.m[i];
    return r;
  }
  friend PARRAY_INLINE Mask operator|(const Mask& a, const Mask& b) {
    Mask r;
    for (int i = 0; i < registers; ++i) r.m[i] = a.m[i] | b.m[i];
    return r;
  }
};
template <typename T>
PARRAY_INLINE std::uint32_t bits_of(const Mask<T>& mask) {
  constexpr uint32x4_t bit{1, 2, 4, 8};
  return vaddvq_u32(mask.words() & bit);
}
template <typename T>
PARRAY_INLINE bool any(const Mask<T>& mask) {
  return vmaxvq_u32(mask.words()) != 0;
}

/// A result of load_order(): the numbers of the four lanes in bytes 0 to 3.
struct Order {
  uint8x16_t lane;

  /// Returns the source bytes of register `i` if lanes have `Size` bytes and this order.
  template <int Size>
  [[nodiscard]] PARRAY_INLINE uint8x16_t bytes(int i) const {
    constexpr std::uint8_t size = Size;
    constexpr uint8x16_t number{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    const uint8x16_t place = number / size + static_cast<std::uint8_t>(i * (16 / Size));
    return vqtbl1q_u8(lane, place) * size + number % size;
  }
};

/// For compress_store(): entry `set` lists the bytes of the lanes whose bits are set, ascending.
/// Lanes have `Size` bytes.
template <int Size>
struct CompressTable {
  alignas(16) std::uint8_t byte[1 << (16 / Size)][16];

  constexpr CompressTable() : byte{} {
    for (int set = 0; set < 1 << (16 / Size); ++set) {
      int next = 0;
      for (int i = 0; i < 16; ++i) {
        if ((set >> (i / Size) & 1) != 0) byte[set][next++] = static_cast<std::uint8_t>(i);
      }
    }
  }
};
template <int Size>
inline constexpr CompressTable<Size> compress_table;

/// Stores the lanes of a register whose bits in `set` are set, one after the other, and returns
/// their number.
template <typename Element, typename Type>
PARRAY_INLINE int compress_register(Element* to, std::uint32_t set, Type a) {
  constexpr int size = sizeof(Element);
  const std::uint32_t here = set & ((1U << (16 / size)) - 1U);
  const uint8x16_t bytes = vld1q_u8(compress_table<size>.byte[here]);
  const uint8x16_t packed = vqtbl1q_u8(reinterpret_cast<uint8x16_t>(a), bytes);
  vst1q_u8(reinterpret_cast<std::uint8_t*>(to), packed);
  return __builtin_popcount(here);
}

/// Unsigned 32-bit integers, one for each lane of Reals<T>.
template <typename T>
struct Uints {
  uint32x4_t v;

  Uints() = default;
  PARRAY_INLINE explicit Uints(uint32x4_t value) : v(value) {}
  PARRAY_INLINE explicit Uints(std::uint32_t all) : v(vdupq_n_u32(all)) {}
  static PARRAY_INLINE Uints load(const std::uint32_t* from) { return Uints(vld1q_u32(from)); }
  PARRAY_INLINE void store(std::uint32_t* to) const { vst1q_u32(to, v); }
  static PARRAY_INLINE Uints gather(const std::uint32_t* table, Uints index) {
    const uint32x4_t at = index.v;
    return Uints(uint32x4_t{table[at[0]], table[at[1]], table[at[2]], table[at[3]]});
  }
  friend PARRAY_INLINE Uints operator&(Uints a, Uints b) { return Uints(a.v & b.v); }
  friend PARRAY_INLINE Uints operator+(Uints a, Uints b) { return Uints(a.v + b.v); }
  friend PARRAY_INLINE Uints operator^(Uints a, Uints b) { return Uints(a.v ^ b.v); }
  friend PARRAY_INLINE Uints operator*(Uints a, Uints b) { return Uints(a.v * b.v); }
  friend PARRAY_INLINE Uints operator>>(Uints a, int count) { return Uints(a.v >> count); }
  friend PARRAY_INLINE Uints operator<<(Uints a, int count) { return Uints(a.v << count); }
};
// The instruction uses only the lowest byte of the shift.
template <typename T>
PARRAY_INLINE Uints<T> one_shifted_by(Uints<T> count) {
  const uint32x4_t shifted = vshlq_u32(vdupq_n_u32(1), vreinterpretq_s32_u32(count.v));
  return Uints<T>(shifted & vcltq_u32(count.v, vdupq_n_u32(32)));
}
template <typename T>
PARRAY_INLINE WideProduct<Uints<T>> multiply_wide(Uints<T> a, Uints<T> b) {
  const auto low = vreinterpretq_u32_u64(vmull_u32(vget_low_u32(a.v), vget_low_u32(b.v)));
  const auto high = vreinterpretq_u32_u64(vmull_high_u32(a.v, b.v));
  return {Uints<T>(vuzp2q_u32(low, high)), Uints<T>(vuzp1q_u32(low, high))};
}
template <typename T>
PARRAY_INLINE Mask<T> equal(Uints<T> a, Uints<T> b) {
  return Mask<T>::from(vceqq_u32(a.v, b.v));
}
template <typename T>
PARRAY_INLINE Uints<T> select(const Mask<T>& mask, Uints<T> a, Uints<T> b) {
  return Uints<T>(vbslq_u32(mask.words(), a.v, b.v));
}
template <typename T>
PARRAY_INLINE Uints<T> select_bits(std::uint32_t bits, Uints<T> a, Uints<T> b) {
  return Uints<T>(vbslq_u32(spread(bits), a.v, b.v));
}
template <typename T>
PARRAY_INLINE Uints<T> permute(Uints<T> a, Order order) {
  return Uints<T>(vreinterpretq_u32_u8(vqtbl1q_u8(vreinterpretq_u8_u32(a.v), order.bytes<4>(0))));
}
template <typename T>
PARRAY_INLINE void compress_store(std::uint32_t* to, std::uint32_t set, Uints<T> a) {
  compress_register(to, set, a.v);
}

/// Real numbers.
template <typename T>
struct Reals {
  using Scalar = T;
  using Mask = neon::Mask<T>;
  using Uint = Uints<T>;
  using Type = typename Register<T>::Type;
  static constexpr int count = 4;
  static constexpr int registers = Register<T>::count;

  Type v[registers];

  Reals() = default;
  PARRAY_INLINE explicit Reals(Type all) requires(registers == 1) : v{all} {}
  PARRAY_INLINE Reals(Type low, Type high) requires(registers == 2) : v{low, high} {}
  PARRAY_INLINE explicit Reals(T all) {
    for (Type& r : v) r = broadcast(all);
  }
  static PARRAY_INLINE Reals load(const T* from) {
    Reals r;
    __builtin_memcpy(r.v, from, sizeof r.v);
    return r;
  }
  static PARRAY_INLINE Reals load(const float* from) requires(registers == 2) {
    const float32x4_t narrow = vld1q_f32(from);
    return Reals(vcvt_f64_f32(vget_low_f32(narrow)), vcvt_high_f64_f32(narrow));
  }
  static PARRAY_INLINE Reals narrow(const double* from) requires(registers == 1) {
    return Reals(vcvt_high_f32_f64(vcvt_f32_f64(vld1q_f64(from)), vld1q_f64(from + 2)));
  }
  template <typename From>
  static PARRAY_INLINE Reals gather(const From* table, Uint index) {
    const uint32x4_t at = index.v;
    const From found[4] = {table[at[0]], table[at[1]], table[at[2]], table[at[3]]};
    if constexpr (registers == 1) {
      return Reals(float32x4_t{found[0], found[1], found[2], found[3]});
    } else if constexpr (sizeof(From) == 4) {
      return Reals(vcvt_f64_f32(float32x2_t{found[0], found[1]}),
                   vcvt_f64_f32(float32x2_t{found[2], found[3]}));
    } else {
      return Reals(float64x2_t{found[0], found[1]}, float64x2_t{found[2], found[3]});
    }
  }
  static PARRAY_INLINE Reals from(Uint integer) {
    if constexpr (registers == 1) {
      return Reals(vcvtq_f32_u32(integer.v));
    } else {
      return Reals(vcvtq_f64_u64(vmovl_u32(vget_low_u32(integer.v))),
                   vcvtq_f64_u64(vmovl_high_u32(integer.v)));
    }
  }
  PARRAY_INLINE void store(T* to) const { __builtin_memcpy(to, v, sizeof v); }
  static PARRAY_INLINE Order load_order(const std::uint8_t* order) {
    std::uint32_t lanes;
    __builtin_memcpy(&lanes, order, sizeof lanes);
    return {vreinterpretq_u8_u32(vdupq_n_u32(lanes))};
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
#define PARRAY_REALS_COMPARISON(op)                                            \
  friend PARRAY_INLINE Mask operator op(const Reals& a, const Reals& b) {      \
    Mask r;                                                                    \
    for (int i = 0; i < registers; ++i) {                                      \
      r.m[i] = reinterpret_cast<typename Register<T>::Bits>(a.v[i] op b.v[i]); \
    }                                                                          \
    return r;                                                                  \
  }
  PARRAY_REALS_COMPARISON(<)
  PARRAY_REALS_COMPARISON(<=)
  PARRAY_REALS_COMPARISON(>)
  PARRAY_REALS_COMPARISON(>=)
  PARRAY_REALS_COMPARISON(==)
#undef PARRAY_REALS_COMPARISON
  friend PARRAY_INLINE Reals operator-(const Reals& a) {
    Reals r;
    for (int i = 0; i < registers; ++i) r.v[i] = -a.v[i];
    return r;
  }
};
template <typename T>
PARRAY_INLINE Reals<T> select(const Mask<T>& mask, const Reals<T>& a, const Reals<T>& b) {
  Reals<T> r;
  for (int i = 0; i < Reals<T>::registers; ++i) r.v[i] = choose(mask.m[i], a.v[i], b.v[i]);
  return r;
}
template <typename T>
PARRAY_INLINE Reals<T> select_bits(std::uint32_t bits, const Reals<T>& a, const Reals<T>& b) {
  return select(Mask<T>::from(spread(bits)), a, b);
}
template <typename T>
PARRAY_INLINE Reals<T> min_of(const Reals<T>& a, const Reals<T>& b) {
  return select(a < b, a, b);
}
template <typename T>
PARRAY_INLINE Reals<T> max_of(const Reals<T>& a, const Reals<T>& b) {
  return select(a > b, a, b);
}
PARRAY_INLINE float32x4_t fused(float32x4_t a, float32x4_t b, float32x4_t c) {
  return vfmaq_f32(c, a, b);
}
PARRAY_INLINE float64x2_t fused(float64x2_t a, float64x2_t b, float64x2_t c) {
  return vfmaq_f64(c, a, b);
}
template <typename T>
PARRAY_INLINE Reals<T> multiply_add(const Reals<T>& a, const Reals<T>& b, const Reals<T>& c) {
  Reals<T> r;
  for (int i = 0; i < Reals<T>::registers; ++i) r.v[i] = fused(a.v[i], b.v[i], c.v[i]);
  return r;
}
template <typename T>
PARRAY_INLINE Reals<T> square_root(const Reals<T>& a) {
  Reals<T> r;
  for (int i = 0; i < Reals<T>::registers; ++i) r.v[i] = root(a.v[i]);
  return r;
}
// fmin is correct here, because no lane is NaN.
PARRAY_INLINE Reals<float> least_of(const Reals<float>& a) {
  return Reals<float>(vminvq_f32(a.v[0]));
}
PARRAY_INLINE Reals<double> least_of(const Reals<double>& a) {
  return Reals<double>(vminvq_f64(vminq_f64(a.v[0], a.v[1])));
}
template <typename T>
PARRAY_INLINE T first_of(const Reals<T>& a) {
  return a.v[0][0];
}
PARRAY_INLINE Reals<float> permute(const Reals<float>& a, Order order) {
  const uint8x16_t from = vreinterpretq_u8_f32(a.v[0]);
  return Reals<float>(vreinterpretq_f32_u8(vqtbl1q_u8(from, order.bytes<4>(0))));
}
PARRAY_INLINE Reals<double> permute(const Reals<double>& a, Order order) {
  const uint8x16x2_t from{{vreinterpretq_u8_f64(a.v[0]), vreinterpretq_u8_f64(a.v[1])}};
  return Reals<double>(vreinterpretq_f64_u8(vqtbl2q_u8(from, order.bytes<8>(0))),
                       vreinterpretq_f64_u8(vqtbl2q_u8(from, order.bytes<8>(1))));
}
template <typename T>
PARRAY_INLINE void compress_store(T* to, std::uint32_t set, const Reals<T>& a) {
  for (const auto r : a.v) {
    to += compress_register(to, set, r);
    set >>= 4 / Reals<T>::registers;
  }
}

/// The lanes that the kernels use.
using FloatLanes = Reals<float>;
using DoubleLanes = Reals<double>;

}  // namespace parray::math::neon

namespace parray::math {

template <typename T>
struct RealTraits<neon::Reals<T>> : RealTraits<T> {};

}  // namespace parray::math
