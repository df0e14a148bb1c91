#pragma once

#include <memory>
#include <span>
#include <type_traits>
#include <vector>

#include "common/trace/sphere_search.h"
#include "tests/support/lane_search.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// The best lane kernels of this machine, as a SphereSearch for one ray at a time.
template <typename Real>
class LaneTree {
 public:
  explicit LaneTree(const std::vector<SphereShape<Real>>& spheres)
      : search_(lane_search<Precision>(best_isa(), spheres, true, true)) {}

  void enter(const Ray<Real>& ray, const InsideStack<Real>& sides, Hit<Real>& best) const {
    const Query<Real> query{ray, sides, {}};
    const Hit<Real> found = search_->find(std::span(&query, 1)).front();
    if (!found.leaving && best.loses_to(found.t, found.shape)) best = found;
  }

  [[nodiscard]] std::size_t bytes() const { return 0; }

 private:
  using Precision =
      std::conditional_t<std::is_same_v<Real, float>, SinglePrecision, DoublePrecision>;
  std::unique_ptr<LaneSearch<Real>> search_;
};

}  // namespace parray::test
