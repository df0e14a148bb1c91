#pragma once

#include <cstdint>
#include <vector>

#include "common/trace/sphere_search.h"

namespace parray::trace {

/// Linear search: tests every sphere for every ray. The other accelerators must give its bits.
template <typename Real>
class Linear {
 public:
  explicit Linear(const std::vector<SphereShape<Real>>& spheres) : spheres_(spheres) {}

  void enter(const Ray<Real>& ray, const InsideStack<Real>& sides, Hit<Real>& best) const {
    for (std::uint32_t i = 0; i < spheres_.size(); ++i) try_shape(ray, spheres_[i], i, sides, best);
  }

  [[nodiscard]] std::size_t bytes() const { return spheres_.size() * sizeof(SphereShape<Real>); }

 private:
  std::vector<SphereShape<Real>> spheres_;
};

}  // namespace parray::trace
