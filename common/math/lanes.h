#pragma once

#include <cstdint>

#include "common/math/inline.h"
#include "common/math/real.h"

/// Numbers side by side. The arithmetic of a path is written once, as templates on a type that
/// behaves like a real number: float, double, a wider type as an oracle, or lanes of them, which
/// hold `count` numbers and do to each what the scalar does, to the bit. This file has the lanes
/// that any compiler can translate; lanes_avx2.h and lanes_avx512.h have those of one instruction
/// set, with the same members and functions.
///
/// A comparison of lanes yields a mask; `select(mask, a, b)` is a where the mask is set. For
/// scalars a mask is bool.
namespace parray::math {

/// What comparing two of them yields.
template <typename Real>
using MaskOf = decltype(Real{} < Real{});

PARRAY_INLINE bool any(bool mask) { return mask; }

template <typename Real>
requires(!requires(Real real) { real.x; })  // those with components choose one by one: see vec.h
    PARRAY_INLINE Real select(bool mask, const Real& a, const Real& b) {
  return mask ? a : b;
}

/// Mask of portable lanes: bit i belongs to lane i.
template <int N>
struct LaneMask {
  std::uint32_t set;

  friend PARRAY_INLINE LaneMask operator&(LaneMask a, LaneMask b) { return {a.set & b.set}; }
  friend PARRAY_INLINE LaneMask operator|(LaneMask a, LaneMask b) { return {a.set | b.set}; }
};
template <int N>
PARRAY_INLINE bool any(LaneMask<N> mask) {
  return mask.set != 0;
}
/// The mask as an integer, bit i for lane i.
template <int N>
PARRAY_INLINE std::uint32_t bits_of(LaneMask<N> mask) {
  return mask.set;
}

/// 32-bit unsigned integers side by side: indices and random bits.
template <int N>
struct UintLanes {
  std::uint32_t v[N];

  UintLanes() = default;
  PARRAY_INLINE explicit UintLanes(std::uint32_t all) {
    for (int i = 0; i < N; ++i) {
      v[i] = all;
    }
  }
  static PARRAY_INLINE UintLanes load(const std::uint32_t* from) {
    UintLanes r;
    for (int i = 0; i < N; ++i) {
      r.v[i] = from[i];
    }
    return r;
  }
  PARRAY_INLINE void store(std::uint32_t* to) const {
    for (int i = 0; i < N; ++i) {
      to[i] = v[i];
    }
  }
  /// table[index[i]] in lane i.
  static PARRAY_INLINE UintLanes gather(const std::uint32_t* table, const UintLanes& index) {
    UintLanes r;
    for (int i = 0; i < N; ++i) {
      r.v[i] = table[index.v[i]];
    }
    return r;
  }
  friend PARRAY_INLINE UintLanes operator&(const UintLanes& a, const UintLanes& b) {
    UintLanes r;
    for (int i = 0; i < N; ++i) {
      r.v[i] = a.v[i] & b.v[i];
    }
    return r;
  }
  friend PARRAY_INLINE UintLanes operator+(const UintLanes& a, const UintLanes& b) {
    UintLanes r;
    for (int i = 0; i < N; ++i) {
      r.v[i] = a.v[i] + b.v[i];
    }
    return r;
  }
  friend PARRAY_INLINE UintLanes operator^(const UintLanes& a, const UintLanes& b) {
    UintLanes r;
    for (int i = 0; i < N; ++i) {
      r.v[i] = a.v[i] ^ b.v[i];
    }
    return r;
  }
  friend PARRAY_INLINE UintLanes operator*(const UintLanes& a, const UintLanes& b) {
    UintLanes r;
    for (int i = 0; i < N; ++i) {
      r.v[i] = a.v[i] * b.v[i];
    }
    return r;
  }
  friend PARRAY_INLINE UintLanes operator>>(const UintLanes& a, int count) {
    UintLanes r;
    for (int i = 0; i < N; ++i) {
      r.v[i] = a.v[i] >> count;
    }
    return r;
  }
  friend PARRAY_INLINE UintLanes operator<<(const UintLanes& a, int count) {
    UintLanes r;
    for (int i = 0; i < N; ++i) {
      r.v[i] = a.v[i] << count;
    }
    return r;
  }
};

template <int N>
PARRAY_INLINE LaneMask<N> equal(const UintLanes<N>& a, const UintLanes<N>& b) {
  LaneMask<N> r{0};
  for (int i = 0; i < N; ++i) {
    r.set |= static_cast<std::uint32_t>(a.v[i] == b.v[i]) << i;
  }
  return r;
}
template <int N>
PARRAY_INLINE UintLanes<N> select(LaneMask<N> mask, const UintLanes<N>& a, const UintLanes<N>& b) {
  UintLanes<N> r;
  for (int i = 0; i < N; ++i) {
    r.v[i] = (mask.set >> i & 1) != 0 ? a.v[i] : b.v[i];
  }
  return r;
}

/// The same with a mask as bits.
template <int N>
PARRAY_INLINE UintLanes<N> select_bits(std::uint32_t bits, const UintLanes<N>& a,
                                       const UintLanes<N>& b) {
  return select(LaneMask<N>{bits}, a, b);
}

/// `first`, `first` + 1 ...
template <typename Uint>
PARRAY_INLINE Uint counting_from(std::uint32_t first) {
  alignas(64) static constexpr std::uint32_t numbers[16] = {0, 1, 2,  3,  4,  5,  6,  7,
                                                            8, 9, 10, 11, 12, 13, 14, 15};
  return Uint::load(numbers) + Uint(first);
}

/// 1 << count in each lane; 0 where `count` is 32 or more.
template <int N>
PARRAY_INLINE UintLanes<N> one_shifted_by(const UintLanes<N>& count) {
  UintLanes<N> r;
  for (int i = 0; i < N; ++i) {
    r.v[i] = count.v[i] < 32 ? 1U << count.v[i] : 0U;
  }
  return r;
}

/// Both halves of the 64-bit products a b.
template <typename Uint>
struct WideProduct {
  Uint high;
  Uint low;
};
PARRAY_INLINE WideProduct<std::uint32_t> multiply_wide(std::uint32_t a, std::uint32_t b) {
  const std::uint64_t product = std::uint64_t{a} * b;
  return {static_cast<std::uint32_t>(product >> 32), static_cast<std::uint32_t>(product)};
}
template <int N>
PARRAY_INLINE WideProduct<UintLanes<N>> multiply_wide(const UintLanes<N>& a,
                                                      const UintLanes<N>& b) {
  WideProduct<UintLanes<N>> r;
  for (int i = 0; i < N; ++i) {
    const WideProduct<std::uint32_t> one = multiply_wide(a.v[i], b.v[i]);
    r.high.v[i] = one.high;
    r.low.v[i] = one.low;
  }
  return r;
}

/// Real numbers side by side.
template <typename T, int N>
struct Lanes {
  using Scalar = T;
  using Mask = LaneMask<N>;
  using Uint = UintLanes<N>;
  static constexpr int count = N;

  T v[N];

  Lanes() = default;
  PARRAY_INLINE explicit Lanes(T all) {
    for (int i = 0; i < N; ++i) {
      v[i] = all;
    }
  }
  /// `count` numbers of this or of a narrower type; no alignment asked for.
  template <typename From>
  static PARRAY_INLINE Lanes load(const From* from) {
    Lanes r;
    for (int i = 0; i < N; ++i) {
      r.v[i] = static_cast<T>(from[i]);
    }
    return r;
  }
  /// `count` numbers of a wider type, rounded to nearest.
  template <typename From>
  static PARRAY_INLINE Lanes narrow(const From* from) {
    return load(from);
  }
  /// table[index[i]] in lane i; the table's type may be narrower.
  template <typename From>
  static PARRAY_INLINE Lanes gather(const From* table, const Uint& index) {
    Lanes r;
    for (int i = 0; i < N; ++i) {
      r.v[i] = static_cast<T>(table[index.v[i]]);
    }
    return r;
  }
  /// Exact for integers below 2^24.
  static PARRAY_INLINE Lanes from(const Uint& integer) {
    Lanes r;
    for (int i = 0; i < N; ++i) {
      r.v[i] = static_cast<T>(integer.v[i]);
    }
    return r;
  }
  PARRAY_INLINE void store(T* to) const {
    for (int i = 0; i < N; ++i) {
      to[i] = v[i];
    }
  }
  /// An order of the lanes, as permute() wants it, from the lanes' numbers.
  static PARRAY_INLINE const std::uint8_t* load_order(const std::uint8_t* order) { return order; }

#define PARRAY_LANES_OPERATOR(op)                                          \
  friend PARRAY_INLINE Lanes operator op(const Lanes& a, const Lanes& b) { \
    Lanes r;                                                               \
    for (int i = 0; i < N; ++i) {                                          \
      r.v[i] = a.v[i] op b.v[i];                                           \
    }                                                                      \
    return r;                                                              \
  }
  PARRAY_LANES_OPERATOR(+)
  PARRAY_LANES_OPERATOR(-)
  PARRAY_LANES_OPERATOR(*)
  PARRAY_LANES_OPERATOR(/)
#undef PARRAY_LANES_OPERATOR
#define PARRAY_LANES_COMPARISON(op)                                       \
  friend PARRAY_INLINE Mask operator op(const Lanes& a, const Lanes& b) { \
    Mask r{0};                                                            \
    for (int i = 0; i < N; ++i) {                                         \
      r.set |= static_cast<std::uint32_t>(a.v[i] op b.v[i]) << i;         \
    }                                                                     \
    return r;                                                             \
  }
  PARRAY_LANES_COMPARISON(<)
  PARRAY_LANES_COMPARISON(<=)
  PARRAY_LANES_COMPARISON(>)
  PARRAY_LANES_COMPARISON(>=)
  PARRAY_LANES_COMPARISON(==)
#undef PARRAY_LANES_COMPARISON
  friend PARRAY_INLINE Lanes operator-(const Lanes& a) {
    Lanes r;
    for (int i = 0; i < N; ++i) {
      r.v[i] = -a.v[i];
    }
    return r;
  }
};

template <typename T, int N>
PARRAY_INLINE Lanes<T, N> select(LaneMask<N> mask, const Lanes<T, N>& a, const Lanes<T, N>& b) {
  Lanes<T, N> r;
  for (int i = 0; i < N; ++i) {
    r.v[i] = (mask.set >> i & 1) != 0 ? a.v[i] : b.v[i];
  }
  return r;
}
/// The same with a mask as bits.
template <typename T, int N>
PARRAY_INLINE Lanes<T, N> select_bits(std::uint32_t bits, const Lanes<T, N>& a,
                                      const Lanes<T, N>& b) {
  return select(LaneMask<N>{bits}, a, b);
}
template <typename T, int N>
PARRAY_INLINE Lanes<T, N> min_of(const Lanes<T, N>& a, const Lanes<T, N>& b) {
  return select(a < b, a, b);
}
template <typename T, int N>
PARRAY_INLINE Lanes<T, N> max_of(const Lanes<T, N>& a, const Lanes<T, N>& b) {
  return select(a > b, a, b);
}
/// a b + c, rounded once or twice: for bounds only, never for what a picture is made of.
template <typename T, int N>
PARRAY_INLINE Lanes<T, N> multiply_add(const Lanes<T, N>& a, const Lanes<T, N>& b,
                                       const Lanes<T, N>& c) {
  return a * b + c;
}
template <typename T, int N>
PARRAY_INLINE Lanes<T, N> square_root(const Lanes<T, N>& a) {
  Lanes<T, N> r;
  for (int i = 0; i < N; ++i) {
    r.v[i] = square_root(a.v[i]);
  }
  return r;
}
/// The least of the lanes, in every lane; none is NaN.
template <typename T, int N>
PARRAY_INLINE Lanes<T, N> least_of(const Lanes<T, N>& a) {
  T least = a.v[0];
  for (int i = 1; i < N; ++i) {
    least = min_of(a.v[i], least);
  }
  return Lanes<T, N>(least);
}
template <typename T, int N>
PARRAY_INLINE T first_of(const Lanes<T, N>& a) {
  return a.v[0];
}
/// Lane order[i] of `a` in lane i. One order serves reals and integers.
template <typename T, int N>
PARRAY_INLINE Lanes<T, N> permute(const Lanes<T, N>& a, const std::uint8_t* order) {
  Lanes<T, N> r;
  for (int i = 0; i < N; ++i) {
    r.v[i] = a.v[order[i]];
  }
  return r;
}
template <int N>
PARRAY_INLINE UintLanes<N> permute(const UintLanes<N>& a, const std::uint8_t* order) {
  UintLanes<N> r;
  for (int i = 0; i < N; ++i) {
    r.v[i] = a.v[order[i]];
  }
  return r;
}
/// Stores the lanes whose bit is set one after the other; may write up to `count` elements.
template <typename L, typename T>
PARRAY_INLINE void compress_store(T* to, std::uint32_t set, const L& a) {
  for (const T lane : a.v) {
    *to = lane;
    to += set & 1;
    set >>= 1;
  }
}

/// An integer below 2^24, or lanes of them, as reals.
template <typename Real, typename Uint>
PARRAY_INLINE Real real_from(const Uint& integer) {
  if constexpr (requires { Real::from(integer); }) {
    return Real::from(integer);
  } else {
    return static_cast<Real>(integer);
  }
}

template <typename T, int N>
struct RealTraits<Lanes<T, N>> {
  static constexpr T unit_roundoff = RealTraits<T>::unit_roundoff;
  static constexpr int sine_terms = RealTraits<T>::sine_terms;
};

}  // namespace parray::math
