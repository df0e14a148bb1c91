#pragma once

#include <cstdint>
#include <limits>

#include "common/trace/bvh/bvh_view.h"
#include "common/trace/bvh/ray_columns.h"

namespace parray::trace {

/// Keeps the nearest crossing of each ray and improves it with several lanes of shapes at a time.
/// `L` are lanes of the real type.
template <typename L, typename Store>
class NearestCrossings {
 public:
  using Real = typename L::Scalar;

  /// `labels` are those of slots `first_slot`, `first_slot` + 1 ...
  PARRAY_INLINE NearestCrossings(const SlotLabels& labels, std::uint32_t first_slot,
                                 Queries<Real, Store>& queries)
      : labels_(labels), first_slot_(first_slot), queries_(queries) {}

  /// Returns whether the shape in `slot` precedes that in `other` at the same distance. The order
  /// of the input decides; spheres precede capsules.
  PARRAY_INLINE bool wins_tie(std::uint32_t slot, std::uint32_t other) const {
    if (other == no_shape) return true;
    if (other < first_slot_) return false;
    return labels_.index(slot - first_slot_) < labels_.index(other - first_slot_);
  }

  /// Takes in the shapes that ray `i` enters at `t`: the lanes with set bits in `candidates`.
  /// `before` is the parameter of the ray's nearest crossing so far, in every lane. Returns that of
  /// the new nearest crossing, in every lane. `slot_of(lane)` returns a shape's slot.
  PARRAY_INLINE L take(std::uint32_t i, const L& t, std::uint32_t candidates, const L& before,
                       const auto& slot_of) {
    const L valid = select_bits(candidates, t, L(infinity));
    const L nearest = least_of(valid);
    const std::uint32_t equal = bits_of(valid == nearest) & candidates;
    const std::uint32_t tied = (equal & (equal - 1)) | (equal & bits_of(nearest == before));
    if (tied != 0) [[unlikely]] {
      take_tied(i, first_of(nearest), equal, slot_of);
      return L(queries_.t[i]);
    }
    // Bits instead of a branch, because the branch would be unpredictable.
    const std::uint32_t better = -(bits_of(nearest < before) & 1U);
    const std::uint32_t slot =
        slot_of(static_cast<std::uint32_t>(__builtin_ctz(equal | 1U << (L::count - 1))));
    const L after = min_of(nearest, before);
    queries_.t[i] = first_of(after);
    queries_.slot[i] = (slot & better) | (queries_.slot[i] & ~better);
    queries_.leaving[i] &= ~better;
    return after;
  }

 private:
  /// Does the same as take() if several crossings are equally near: shapes in the lanes `equal`, at
  /// `nearest`, and perhaps the crossing so far.
  void take_tied(std::uint32_t i, Real nearest, std::uint32_t equal, const auto& slot_of) {
    for (; equal != 0; equal &= equal - 1) {
      const std::uint32_t slot = slot_of(static_cast<std::uint32_t>(__builtin_ctz(equal)));
      const Real before = queries_.t[i];
      if (nearest < before || (nearest == before && wins_tie(slot, queries_.slot[i]))) {
        queries_.t[i] = nearest;
        queries_.slot[i] = slot;
        queries_.leaving[i] = 0;
      }
    }
  }

  static constexpr Real infinity = std::numeric_limits<Real>::infinity();

  SlotLabels labels_;
  std::uint32_t first_slot_;
  Queries<Real, Store>& queries_;
};

}  // namespace parray::trace
