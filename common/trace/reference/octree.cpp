#include "common/trace/reference/octree.h"

#include <memory_resource>
#include <queue>

#include "common/trace/reference/octree_build.h"

namespace parray::trace {

/// A ray prepared for tests of cells: the plane origins are moved outward by the ray's part of the
/// margins.
template <typename Real>
struct Octree<Real>::Probe {
  explicit Probe(const Ray<Real>& ray) {
    const Slabs origin = project(ray.origin);
    const Slabs direction = project(ray.direction);
    const Slabs margin = margins(largest_component(ray.origin));
    for (std::size_t k = 0; k < slab_count; ++k) {
      for_lo[k] = origin[k] + margin[k];
      for_hi[k] = origin[k] - margin[k];
      inverse[k] = Real(1) / direction[k];
    }
  }

  /// Returns the parameter at which the ray reaches the cell; infinity if it does not before
  /// `t_max`. A NaN (the origin on a plane that the ray runs along) does not constrain the result:
  /// see min_of and max_of.
  [[nodiscard]] Real reach(const Extent& extent, Real t_max) const {
    Real near = Real(0);
    Real far = t_max;
    for (std::size_t k = 0; k < slab_count; ++k) {
      const Real t_lo = (extent.lo[k] - for_lo[k]) * inverse[k];
      const Real t_hi = (extent.hi[k] - for_hi[k]) * inverse[k];
      const bool backward = inverse[k] < 0;
      near = max_of(backward ? t_hi : t_lo, near);
      far = min_of(backward ? t_lo : t_hi, far);
    }
    return near <= far ? near : std::numeric_limits<Real>::infinity();
  }

  Slabs for_lo;
  Slabs for_hi;
  Slabs inverse;
};

template <typename Real>
void Octree<Real>::enter(const Ray<Real>& ray, const InsideStack<Real>& sides,
                         Hit<Real>& best) const {
  struct Pending {
    std::uint32_t cell;
    Real t;
    bool operator<(const Pending& other) const { return t > other.t; }  // the nearest on top
  };
  if (cells_.empty()) return;
  // Enough for nearly every search. A scene in which very many cells overlap also uses the heap.
  alignas(Pending) std::array<std::byte, 256 * sizeof(Pending)> room;
  std::pmr::monotonic_buffer_resource memory(room.data(), room.size());
  std::pmr::vector<Pending> container(&memory);
  container.reserve(room.size() / sizeof(Pending));
  std::priority_queue queue(std::less<Pending>{}, std::move(container));

  constexpr Real miss = std::numeric_limits<Real>::infinity();
  const Probe probe(ray);
  const auto offer = [&](std::uint32_t cell) {
    const Real t = probe.reach(cells_[cell].extent, best.t);
    if (t != miss) queue.push({cell, t});
  };
  offer(0);
  while (!queue.empty() && queue.top().t <= best.t) {  // <=: an equal distance may win by its index
    const Cell& cell = cells_[queue.top().cell];
    queue.pop();
    for (std::uint32_t i = cell.first; i < cell.first + cell.count; ++i) {
      if (cell.is_leaf) {
        try_shape(ray, spheres_[i], indices_[i], sides, best);
      } else {
        offer(i);
      }
    }
  }
}

template class Octree<float>;
template class Octree<double>;

}  // namespace parray::trace
