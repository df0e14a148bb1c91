#pragma once

#include <cstdint>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include "common/math/inline.h"
#include "common/math/lanes.h"

/// Lanes of any processor: 4 floats in one vector of 16 bytes, 4 doubles in two. The compiler's own
/// vectors become registers if the processor has them, and loops otherwise. Every header of lanes
/// has these members and functions.
namespace parray::math::scalar {

using Words = std::uint32_t __attribute__((vector_size(16)));

/// The vectors that hold four lanes of T.
template <typename T>
struct Register;
template <>
struct Register<float> {
  using Type = float __attribute__((vector_size(16)));
  using Bits = Words;
  static constexpr int count = 1;  ///< vectors of 4 lanes
  static constexpr int lanes = 4;  ///< lanes of one vector
};
template <>
struct Register<double> {
  using Type = double __attribute__((vector_size(16)));
  using Bits = std::uint64_t __attribute__((vector_size(16)));
  static constexpr int count = 2;
  static constexpr int lanes = 2;
};
using Floats = Register<float>::Type;
using HalfFloats = float __attribute__((vector_size(8)));
using Doubles = Register<double>::Type;
using LongWords = Register<double>::Bits;

// Operations that compilers do not find by themselves. smaller(), larger(): b if a or b is NaN.
// signs(): bit i is set if lane i of a mask is set.
#ifdef __SSE2__
PARRAY_INLINE Floats root(Floats a) { return _mm_sqrt_ps(a); }
PARRAY_INLINE Doubles root(Doubles a) { return _mm_sqrt_pd(a); }
PARRAY_INLINE Floats smaller(Floats a, Floats b) { return _mm_min_ps(a, b); }
PARRAY_INLINE Doubles smaller(Doubles a, Doubles b) { return _mm_min_pd(a, b); }
PARRAY_INLINE Floats larger(Floats a, Floats b) { return _mm_max_ps(a, b); }
PARRAY_INLINE Doubles larger(Doubles a, Doubles b) { return _mm_max_pd(a, b); }
PARRAY_INLINE std::uint32_t signs(Words a) {
  return static_cast<std::uint32_t>(_mm_movemask_ps(reinterpret_cast<__m128>(a)));
}
PARRAY_INLINE std::uint32_t signs(LongWords a) {
  return static_cast<std::uint32_t>(_mm_movemask_pd(reinterpret_cast<__m128d>(a)));
}
/// Returns the 64-bit products of lanes 0 and 2.
PARRAY_INLINE Words even_products(Words a, Words b) {
  return reinterpret_cast<Words>(
      _mm_mul_epu32(reinterpret_cast<__m128i>(a), reinterpret_cast<__m128i>(b)));
}
#else
template <typename V>
PARRAY_INLINE V root(V a) {
  for (unsigned i = 0; i < sizeof a / sizeof a[0]; ++i) a[i] = square_root(a[i]);
  return a;
}
template <typename V>
PARRAY_INLINE V smaller(V a, V b) {
  return a < b ? a : b;
}
template <typename V>
PARRAY_INLINE V larger(V a, V b) {
  return a > b ? a : b;
}
PARRAY_INLINE std::uint32_t signs(auto a) {
  std::uint32_t bits = 0;
  for (unsigned i = 0; i < sizeof a / sizeof a[0]; ++i) {
    bits |= (static_cast<std::uint32_t>(a[i]) & 1U) << i;
  }
  return bits;
}
PARRAY_INLINE Words even_products(Words a, Words b) {
  const LongWords products{std::uint64_t{a[0]} * b[0], std::uint64_t{a[2]} * b[2]};
  return reinterpret_cast<Words>(products);
}
#endif

/// Returns `a` where the mask is set, otherwise `b`.
template <typename Bits, typename V>
PARRAY_INLINE V choose(Bits mask, V a, V b) {
  return reinterpret_cast<V>((reinterpret_cast<Bits>(a) & mask) |
                             (reinterpret_cast<Bits>(b) & ~mask));
}

/// Returns all ones in lane i if bit i is set.
PARRAY_INLINE Words spread(std::uint32_t bits) {
  constexpr Words bit{1, 2, 4, 8};
  const Words all{bits, bits, bits, bits};
  return reinterpret_cast<Words>((all & bit) == bit);
}

/// Lanes of all ones or all zeros.
template <typename T>
struct Mask {
  static constexpr int registers = Register<T>::count;
  typename Register<T>::Bits m[registers];

  /// Convert from and to the mask of 32-bit numbers.
  static PARRAY_INLINE Mask from(Words words) {
    if constexpr (registers == 1) {
      return {{words}};
    } else {
      return {{reinterpret_cast<LongWords>(__builtin_shufflevector(words, words, 0, 0, 1, 1)),
               reinterpret_cast<LongWords>(__builtin_shufflevector(words, words, 2, 2, 3, 3))}};
    }
  }
  [[nodiscard]] PARRAY_INLINE Words words() const {
    if constexpr (registers == 1) {
      return m[0];
    } else {
      return __builtin_shufflevector(reinterpret_cast<Words>(m[0]), reinterpret_cast<Words>(m[1]),
                                     0, 2, 4, 6);
    }
  }
  friend PARRAY_INLINE Mask operator&(const Mask& a, const Mask& b) {
    Mask r;
    r.m[0] = a.m[0] & b.m[0];
    if constexpr (registers == 2) r.m[1] = a.m[1] & b.m[1];
    return r;
  }
  friend PARRAY_INLINE Mask operator|(const Mask& a, const Mask& b) {
    Mask r;
    r.m[0] = a.m[0] | b.m[0];
    if constexpr (registers == 2) r.m[1] = a.m[1] | b.m[1];
    return r;
  }
};
/// Returns the mask as an integer, bit i for lane i.
template <typename T>
PARRAY_INLINE std::uint32_t bits_of(const Mask<T>& mask) {
  std::uint32_t bits = signs(mask.m[0]);
  if constexpr (Mask<T>::registers == 2) bits |= signs(mask.m[1]) << Register<T>::lanes;
  return bits;
}
template <typename T>
PARRAY_INLINE bool any(const Mask<T>& mask) {
  return bits_of(mask) != 0;
}

/// Unsigned 32-bit integers, one for each lane of Reals<T>.
template <typename T>
struct Uints {
  Words v;

  Uints() = default;
  PARRAY_INLINE explicit Uints(Words value) : v(value) {}
  PARRAY_INLINE explicit Uints(std::uint32_t all) : v{all, all, all, all} {}
  static PARRAY_INLINE Uints load(const std::uint32_t* from) {
    Uints r;
    __builtin_memcpy(&r.v, from, sizeof r.v);
    return r;
  }
  PARRAY_INLINE void store(std::uint32_t* to) const { __builtin_memcpy(to, &v, sizeof v); }
  /// Returns table[index[i]] in lane i.
  static PARRAY_INLINE Uints gather(const std::uint32_t* table, Uints index) {
    const Words at = index.v;
    return Uints(Words{table[at[0]], table[at[1]], table[at[2]], table[at[3]]});
  }
  friend PARRAY_INLINE Uints operator&(Uints a, Uints b) { return Uints(a.v & b.v); }
  friend PARRAY_INLINE Uints operator+(Uints a, Uints b) { return Uints(a.v + b.v); }
  friend PARRAY_INLINE Uints operator^(Uints a, Uints b) { return Uints(a.v ^ b.v); }
  friend PARRAY_INLINE Uints operator*(Uints a, Uints b) { return Uints(a.v * b.v); }
  friend PARRAY_INLINE Uints operator>>(Uints a, int count) { return Uints(a.v >> count); }
  friend PARRAY_INLINE Uints operator<<(Uints a, int count) { return Uints(a.v << count); }
};
/// Returns 1 << count in each lane; 0 if `count` is 32 or more.
template <typename T>
PARRAY_INLINE Uints<T> one_shifted_by(Uints<T> count) {
  const auto shifted = [](std::uint32_t by) { return by < 32 ? 1U << by : 0U; };
  const Words by = count.v;
  return Uints<T>(Words{shifted(by[0]), shifted(by[1]), shifted(by[2]), shifted(by[3])});
}
template <typename T>
PARRAY_INLINE WideProduct<Uints<T>> multiply_wide(Uints<T> a, Uints<T> b) {
  const Words even = even_products(a.v, b.v);
  const Words odd = even_products(__builtin_shufflevector(a.v, a.v, 1, 1, 3, 3),
                                  __builtin_shufflevector(b.v, b.v, 1, 1, 3, 3));
  return {Uints<T>(__builtin_shufflevector(even, odd, 1, 5, 3, 7)),
          Uints<T>(__builtin_shufflevector(even, odd, 0, 4, 2, 6))};
}
template <typename T>
PARRAY_INLINE Mask<T> equal(Uints<T> a, Uints<T> b) {
  return Mask<T>::from(reinterpret_cast<Words>(a.v == b.v));
}
template <typename T>
PARRAY_INLINE Uints<T> select(const Mask<T>& mask, Uints<T> a, Uints<T> b) {
  return Uints<T>(choose(mask.words(), a.v, b.v));
}
/// Does the same as select() with a mask as bits: bit i for lane i.
template <typename T>
PARRAY_INLINE Uints<T> select_bits(std::uint32_t bits, Uints<T> a, Uints<T> b) {
  return Uints<T>(choose(spread(bits), a.v, b.v));
}
template <typename T>
PARRAY_INLINE Uints<T> permute(Uints<T> a, const std::uint8_t* order) {
  std::uint32_t lane[4];
  a.store(lane);
  return Uints<T>(Words{lane[order[0]], lane[order[1]], lane[order[2]], lane[order[3]]});
}

/// Real numbers.
template <typename T>
struct Reals {
  using Scalar = T;
  using Mask = scalar::Mask<T>;
  using Uint = Uints<T>;
  using Type = typename Register<T>::Type;
  static constexpr int count = 4;
  static constexpr int registers = Register<T>::count;

  Type v[registers];

  Reals() = default;
  PARRAY_INLINE explicit Reals(T all) {
    if constexpr (registers == 1) {
      v[0] = Type{all, all, all, all};
    } else {
      v[0] = v[1] = Type{all, all};
    }
  }
  /// Loads `count` numbers, which need not be aligned.
  static PARRAY_INLINE Reals load(const T* from) {
    Reals r;
    __builtin_memcpy(r.v, from, sizeof r.v);
    return r;
  }
  /// Loads numbers of a narrower type.
  static PARRAY_INLINE Reals load(const float* from) requires(registers == 2) {
    HalfFloats half[2];
    __builtin_memcpy(half, from, sizeof half);
    Reals r;
    r.v[0] = __builtin_convertvector(half[0], Doubles);
    r.v[1] = __builtin_convertvector(half[1], Doubles);
    return r;
  }
  /// Loads numbers of a wider type, rounded to nearest.
  static PARRAY_INLINE Reals narrow(const double* from) requires(registers == 1) {
    Reals r;
    r.v[0] = Floats{static_cast<float>(from[0]), static_cast<float>(from[1]),
                    static_cast<float>(from[2]), static_cast<float>(from[3])};
    return r;
  }
  /// Returns table[index[i]] in lane i; the table's type may be narrower.
  template <typename From>
  static PARRAY_INLINE Reals gather(const From* table, Uint index) {
    const From found[4] = {table[index.v[0]], table[index.v[1]], table[index.v[2]],
                           table[index.v[3]]};
    return load(found);
  }
  /// Converts integers; exact below 2^24.
  static PARRAY_INLINE Reals from(Uint integer) {
    using Signed = std::int32_t __attribute__((vector_size(16)));
    using HalfSigned = std::int32_t __attribute__((vector_size(8)));
    const auto whole = reinterpret_cast<Signed>(integer.v);
    Reals r;
    if constexpr (registers == 1) {
      r.v[0] = __builtin_convertvector(whole, Floats);
    } else {
      r.v[0] = __builtin_convertvector(HalfSigned{whole[0], whole[1]}, Doubles);
      r.v[1] = __builtin_convertvector(HalfSigned{whole[2], whole[3]}, Doubles);
    }
    return r;
  }
  PARRAY_INLINE void store(T* to) const { __builtin_memcpy(to, v, sizeof v); }
  /// Makes an order for permute() from `count` numbers of lanes.
  static PARRAY_INLINE const std::uint8_t* load_order(const std::uint8_t* order) { return order; }

#define PARRAY_REALS_OPERATOR(op)                                          \
  friend PARRAY_INLINE Reals operator op(const Reals& a, const Reals& b) { \
    Reals r;                                                               \
    r.v[0] = a.v[0] op b.v[0];                                             \
    if constexpr (registers == 2) r.v[1] = a.v[1] op b.v[1];               \
    return r;                                                              \
  }
  PARRAY_REALS_OPERATOR(+)
  PARRAY_REALS_OPERATOR(-)
  PARRAY_REALS_OPERATOR(*)
  PARRAY_REALS_OPERATOR(/)
#undef PARRAY_REALS_OPERATOR
#define PARRAY_REALS_COMPARISON(op)                                                  \
  friend PARRAY_INLINE Mask operator op(const Reals& a, const Reals& b) {            \
    Mask r;                                                                          \
    using Bits = typename Register<T>::Bits;                                         \
    r.m[0] = reinterpret_cast<Bits>(a.v[0] op b.v[0]);                               \
    if constexpr (registers == 2) r.m[1] = reinterpret_cast<Bits>(a.v[1] op b.v[1]); \
    return r;                                                                        \
  }
  PARRAY_REALS_COMPARISON(<)
  PARRAY_REALS_COMPARISON(<=)
  PARRAY_REALS_COMPARISON(>)
  PARRAY_REALS_COMPARISON(>=)
  PARRAY_REALS_COMPARISON(==)
#undef PARRAY_REALS_COMPARISON
  friend PARRAY_INLINE Reals operator-(const Reals& a) {
    Reals r;
    r.v[0] = -a.v[0];
    if constexpr (registers == 2) r.v[1] = -a.v[1];
    return r;
  }
};
template <typename T>
PARRAY_INLINE Reals<T> select(const Mask<T>& mask, const Reals<T>& a, const Reals<T>& b) {
  Reals<T> r;
  r.v[0] = choose(mask.m[0], a.v[0], b.v[0]);
  if constexpr (Reals<T>::registers == 2) r.v[1] = choose(mask.m[1], a.v[1], b.v[1]);
  return r;
}
template <typename T>
PARRAY_INLINE Reals<T> select_bits(std::uint32_t bits, const Reals<T>& a, const Reals<T>& b) {
  return select(Mask<T>::from(spread(bits)), a, b);
}
/// Return the minimum and the maximum in each lane, with NaN as in real.h.
template <typename T>
PARRAY_INLINE Reals<T> min_of(const Reals<T>& a, const Reals<T>& b) {
  Reals<T> r;
  r.v[0] = smaller(a.v[0], b.v[0]);
  if constexpr (Reals<T>::registers == 2) r.v[1] = smaller(a.v[1], b.v[1]);
  return r;
}
template <typename T>
PARRAY_INLINE Reals<T> max_of(const Reals<T>& a, const Reals<T>& b) {
  Reals<T> r;
  r.v[0] = larger(a.v[0], b.v[0]);
  if constexpr (Reals<T>::registers == 2) r.v[1] = larger(a.v[1], b.v[1]);
  return r;
}
/// Returns a b + c, rounded once or twice. Use it for bounds only, never for values of the picture.
template <typename T>
PARRAY_INLINE Reals<T> multiply_add(const Reals<T>& a, const Reals<T>& b, const Reals<T>& c) {
  return a * b + c;
}
template <typename T>
PARRAY_INLINE Reals<T> square_root(const Reals<T>& a) {
  Reals<T> r;
  r.v[0] = root(a.v[0]);
  if constexpr (Reals<T>::registers == 2) r.v[1] = root(a.v[1]);
  return r;
}
/// Returns the smallest lane in every lane; no lane may be NaN.
PARRAY_INLINE Reals<float> least_of(const Reals<float>& a) {
  const Floats crossed = __builtin_shufflevector(a.v[0], a.v[0], 2, 3, 0, 1);
  const Floats two = smaller(a.v[0], crossed);
  const Floats one = smaller(two, __builtin_shufflevector(two, two, 1, 0, 3, 2));
  Reals<float> r;
  r.v[0] = one;
  return r;
}
PARRAY_INLINE Reals<double> least_of(const Reals<double>& a) {
  const Doubles two = smaller(a.v[0], a.v[1]);
  const Doubles one = smaller(two, __builtin_shufflevector(two, two, 1, 0));
  Reals<double> r;
  r.v[0] = one;
  r.v[1] = one;
  return r;
}
template <typename T>
PARRAY_INLINE T first_of(const Reals<T>& a) {
  return a.v[0][0];
}
/// Returns lane order[i] of `a` in lane i. `order` comes from load_order() and serves reals and
/// integers.
template <typename T>
PARRAY_INLINE Reals<T> permute(const Reals<T>& a, const std::uint8_t* order) {
  T lane[4];
  a.store(lane);
  const T ordered[4] = {lane[order[0]], lane[order[1]], lane[order[2]], lane[order[3]]};
  return Reals<T>::load(ordered);
}
/// Stores the lanes with set bits one after the other; may write up to `count` elements.
template <typename L, typename T>
PARRAY_INLINE void compress_store(T* to, std::uint32_t set, const L& a) {
  T lane[4];
  a.store(lane);
  for (const T one : lane) {
    *to = one;
    to += set & 1;
    set >>= 1;
  }
}

/// The lanes that the kernels use.
using FloatLanes = Reals<float>;
using DoubleLanes = Reals<double>;

}  // namespace parray::math::scalar

namespace parray::math {

template <typename T>
struct RealTraits<scalar::Reals<T>> : RealTraits<T> {};

}  // namespace parray::math
