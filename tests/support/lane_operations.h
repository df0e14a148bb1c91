#pragma once

#include <cstdint>

#include "common/math/philox.h"
#include "common/trace/integrator/isa_kernels.h"
#include "tests/support/rooms.h"

/// Every operation of lanes, on one set of inputs. The build compiles the calling file once for
/// each instruction set. Inputs and results are plain arrays, so that no shared function contains
/// instructions of a newer processor.
namespace parray::test {

inline constexpr int most_lanes = 16;

template <typename T>
struct LaneInputs {
  T a[most_lanes];  ///< any bits
  T b[most_lanes];
  T ordered[most_lanes];       ///< none is NaN
  float narrower[most_lanes];  ///< to become double
  double wider[most_lanes];    ///< to become float
  T table[64];
  std::uint32_t p[most_lanes];  ///< any bits
  std::uint32_t q[most_lanes];
  std::uint32_t index[most_lanes];  ///< into `table`
  std::uint32_t place[most_lanes];  ///< into `narrower` and `q`
  std::uint32_t small[most_lanes];  ///< below 2^24
  std::uint32_t shift[most_lanes];  ///< arbitrary bits, often a number below 64
  std::uint8_t order[most_lanes];   ///< numbers of lanes
  std::uint32_t set;                ///< bit i: lane i
};

/// Permitted difference between the results of lanes and of scalars.
enum class Free : std::uint8_t {
  nothing,
  nan,   ///< the bits of a NaN, which IEEE 754 does not specify
  zero,  ///< the sign of zero
};

struct Operation {
  const char* name;
  Free free = Free::nothing;
};
inline constexpr Operation real_operations[] = {{"+", Free::nan},
                                                {"-", Free::nan},
                                                {"*", Free::nan},
                                                {"/", Free::nan},
                                                {"multiply_add", Free::nan},
                                                {"square_root", Free::nan},
                                                {"convert", Free::nan},
                                                {"gather narrower", Free::nan},
                                                {"negate"},
                                                {"load"},
                                                {"broadcast"},
                                                {"select"},
                                                {"select_bits"},
                                                {"min_of"},
                                                {"max_of"},
                                                {"gather"},
                                                {"from"},
                                                {"permute"},
                                                {"compress_store"},
                                                {"least_of", Free::zero},
                                                {"first_of"}};
inline constexpr int real_rows = sizeof real_operations / sizeof real_operations[0];

/// Masks are stored as bits, in lane 0.
inline constexpr Operation mask_operations[] = {{"<"}, {"<="}, {">"},     {">="},      {"=="},
                                                {"&"}, {"|"},  {"equal"}, {"any not"}, {"any"}};
inline constexpr int mask_rows = sizeof mask_operations / sizeof mask_operations[0];

inline constexpr Operation uint_operations[] = {{"load"},
                                                {"broadcast"},
                                                {"+"},
                                                {"*"},
                                                {"^"},
                                                {"&"},
                                                {">> 1"},
                                                {">> 8"},
                                                {">> 31"},
                                                {"<< 1"},
                                                {"<< 8"},
                                                {"<< 31"},
                                                {"high"},
                                                {"low"},
                                                {"select"},
                                                {"select_bits"},
                                                {"gather"},
                                                {"permute"},
                                                {"compress_store"},
                                                {"philox a"},
                                                {"philox b"},
                                                {"philox c"},
                                                {"philox d"},
                                                {"one_shifted_by"}};
inline constexpr int uint_rows = sizeof uint_operations / sizeof uint_operations[0];

/// One row of results for each operation.
template <typename T>
struct LaneResults {
  T real[real_rows][most_lanes];
  std::uint32_t mask[mask_rows];
  std::uint32_t uint[uint_rows][most_lanes];
};

template <typename L, typename T>
PARRAY_INLINE L converted(const LaneInputs<T>& in) {
  if constexpr (sizeof(T) == sizeof(float)) {
    return L::narrow(in.wider);
  } else {
    return L::load(in.narrower);
  }
}

/// Fills the first L::count lanes of every row.
template <typename L, typename T>
PARRAY_INLINE void operate_on_reals(const LaneInputs<T>& in, LaneResults<T>& out) {
  const L a = L::load(in.a);
  const L b = L::load(in.b);
  T(*row)[most_lanes] = out.real;
  (a + b).store(*row++);
  (a - b).store(*row++);
  (a * b).store(*row++);
  (a / b).store(*row++);
  multiply_add(a, b, L::load(in.table)).store(*row++);
  square_root(a).store(*row++);
  converted<L>(in).store(*row++);
  L::gather(in.narrower, L::Uint::load(in.place)).store(*row++);
  (-a).store(*row++);
  a.store(*row++);
  L(in.a[0]).store(*row++);
  select(a < b, a, b).store(*row++);
  select_bits(in.set, a, b).store(*row++);
  min_of(a, b).store(*row++);
  max_of(a, b).store(*row++);
  L::gather(in.table, L::Uint::load(in.index)).store(*row++);
  real_from<L>(L::Uint::load(in.small)).store(*row++);
  permute(a, L::load_order(in.order)).store(*row++);
  compress_store(*row++, in.set, a);
  least_of(L::load(in.ordered)).store(*row++);
  (*row)[0] = first_of(a);
}

template <typename L, typename T>
PARRAY_INLINE void operate_on_masks(const LaneInputs<T>& in, LaneResults<T>& out) {
  const L a = L::load(in.a);
  const L b = L::load(in.b);
  std::uint32_t* to = out.mask;
  *to++ = bits_of(a < b);
  *to++ = bits_of(a <= b);
  *to++ = bits_of(a > b);
  *to++ = bits_of(a >= b);
  *to++ = bits_of(a == b);
  *to++ = bits_of((a <= b) & (a >= b));
  *to++ = bits_of((a < b) | (a > b));
  *to++ = bits_of(equal(L::Uint::load(in.p), L::Uint::load(in.q)));
  *to++ = any((a < b) & (a > b)) ? 1 : 0;
  *to = any(a < b) ? 1 : 0;
}

template <typename L, typename T>
PARRAY_INLINE void operate_on_uints(const LaneInputs<T>& in, LaneResults<T>& out) {
  using Uint = typename L::Uint;
  const Uint p = Uint::load(in.p);
  const Uint q = Uint::load(in.q);
  std::uint32_t(*row)[most_lanes] = out.uint;
  p.store(*row++);
  Uint(in.p[0]).store(*row++);
  (p + q).store(*row++);
  (p * q).store(*row++);
  (p ^ q).store(*row++);
  (p & q).store(*row++);
  (p >> 1).store(*row++);
  (p >> 8).store(*row++);
  (p >> 31).store(*row++);
  (p << 1).store(*row++);
  (p << 8).store(*row++);
  (p << 31).store(*row++);
  const WideProduct<Uint> product = multiply_wide(p, q);
  product.high.store(*row++);
  product.low.store(*row++);
  select(L::load(in.a) < L::load(in.b), p, q).store(*row++);
  select_bits(in.set, p, q).store(*row++);
  Uint::gather(in.q, Uint::load(in.place)).store(*row++);
  permute(p, L::load_order(in.order)).store(*row++);
  compress_store(*row++, in.set, p);
  const PhiloxBlock<Uint> block = philox4x32<Uint>({p, q, q, p}, {in.set, 77});
  block.a.store(*row++);
  block.b.store(*row++);
  block.c.store(*row++);
  block.d.store(*row++);
  one_shifted_by(Uint::load(in.shift)).store(*row);
}

#define PARRAY_DECLARE_OPERATE(isa)                                     \
  namespace isa {                                                       \
  void operate(const LaneInputs<float>& in, LaneResults<float>& out);   \
  void operate(const LaneInputs<double>& in, LaneResults<double>& out); \
  }
PARRAY_DECLARE_OPERATE(scalar)
PARRAY_DECLARE_OPERATE(avx2)
PARRAY_DECLARE_OPERATE(avx512)
PARRAY_DECLARE_OPERATE(neon)
#undef PARRAY_DECLARE_OPERATE

}  // namespace parray::test
