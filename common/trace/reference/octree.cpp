#include "common/trace/reference/octree.h"

#include <algorithm>
#include <limits>
#include <memory_resource>
#include <numeric>
#include <queue>
#include <utility>

#include "common/math/largest_component.h"

namespace parray::trace {

/// Returns the components of `v` along x, y, z and the diagonals (1, 1, 1), (1, 1, -1), (1, -1, 1),
/// (1, -1, -1).
template <typename Real>
typename Octree<Real>::Slabs Octree<Real>::project(const Vec3<Real>& v) {
  const Real sum = v.x + v.y;
  const Real difference = v.x - v.y;
  return {v.x, v.y, v.z, sum + v.z, sum - v.z, difference + v.z, difference - v.z};
}

/// Returns the part of the planes' margins for numbers up to `size` (see Octree).
template <typename Real>
typename Octree<Real>::Slabs Octree<Real>::margins(Real size) {
  const Real axis = Real(32) * RealTraits<Real>::unit_roundoff * size;
  const Real diagonal = Real(3) * axis;
  return {axis, axis, axis, diagonal, diagonal, diagonal, diagonal};
}

/// The two passes that build an octree.
template <typename Real>
class Octree<Real>::Builder {
 public:
  Builder(const std::vector<SphereShape<Real>>& spheres, Octree& tree)
      : spheres_(spheres), tree_(tree), indices_(spheres.size()), sorted_(spheres.size()) {
    std::iota(indices_.begin(), indices_.end(), 0U);
  }

  void run() {
    tree_.cells_.emplace_back();
    divide(0, {0, static_cast<std::uint32_t>(spheres_.size())}, cube_around_centers(), 1);
    tree_.cells_.shrink_to_fit();
    tree_.spheres_.reserve(spheres_.size());
    for (const std::uint32_t index : indices_) tree_.spheres_.push_back(spheres_[index]);
    bound_cells();
    tree_.indices_ = std::move(indices_);
  }

 private:
  static constexpr std::size_t octants = 8;

  /// Places [begin, end) in the order of the spheres.
  struct Range {
    std::uint32_t begin;
    std::uint32_t end;
  };

  struct Cube {
    Vec3<Real> middle;
    Real half;  ///< half of the cell's side
    std::uint32_t halvings = 0;

    /// Bits 0, 1, 2: the upper half in x, y, z.
    [[nodiscard]] std::size_t octant_of(const Vec3<Real>& p) const {
      return (p.x >= middle.x ? 1U : 0U) + (p.y >= middle.y ? 2U : 0U) +
             (p.z >= middle.z ? 4U : 0U);
    }
    [[nodiscard]] Cube octant(std::size_t number) const {
      const Real quarter = half / 2;
      const auto step = [&](std::size_t bit) { return (number & bit) != 0 ? quarter : -quarter; };
      return {middle + Vec3<Real>{step(1), step(2), step(4)}, quarter, halvings + 1};
    }
  };

  Cube cube_around_centers() const {
    Vec3<Real> lo = spheres_[0].center;
    Vec3<Real> hi = lo;
    for (const auto& [c, radius] : spheres_) {
      lo = {min_of(lo.x, c.x), min_of(lo.y, c.y), min_of(lo.z, c.z)};
      hi = {max_of(hi.x, c.x), max_of(hi.y, c.y), max_of(hi.z, c.z)};
    }
    return {Real(0.5) * (lo + hi), largest_component(hi - lo) / 2};
  }

  // --- first pass, from the top

  void divide(std::uint32_t cell, Range range, Cube cube, std::uint32_t level) {
    tree_.depth_ = std::max(tree_.depth_, level);
    if (centers_coincide(range)) {
      make_leaf(cell, range);
      return;
    }
    auto parts = sort_by_octant(range, cube);
    while (occupied(parts) == 1 && cube.halvings < max_depth - 1) {
      cube = cube.octant(cube.octant_of(spheres_[indices_[range.begin]].center));
      parts = sort_by_octant(range, cube);
    }
    if (cube.halvings >= max_depth - 1) {
      make_leaf(cell, range);
      return;
    }
    const auto first = static_cast<std::uint32_t>(tree_.cells_.size());
    tree_.cells_.resize(first + occupied(parts));
    tree_.cells_[cell].first = first;
    tree_.cells_[cell].count = static_cast<std::uint32_t>(tree_.cells_.size()) - first;
    std::uint32_t child = first;
    for (std::size_t octant = 0; octant < octants; ++octant) {
      if (parts[octant].begin < parts[octant].end) {
        divide(child++, parts[octant], cube.octant(octant), level + 1);
      }
    }
  }

  void make_leaf(std::uint32_t cell, Range range) {
    tree_.cells_[cell].first = range.begin;
    tree_.cells_[cell].count = range.end - range.begin;
    tree_.cells_[cell].is_leaf = true;
  }

  /// Returns whether all centres of the range are equal, as for a single sphere.
  [[nodiscard]] bool centers_coincide(Range range) const {
    const Vec3<Real>& first = spheres_[indices_[range.begin]].center;
    return std::all_of(indices_.begin() + range.begin, indices_.begin() + range.end,
                       [&](std::uint32_t index) { return spheres_[index].center == first; });
  }

  using Parts = std::array<Range, octants>;

  static std::size_t occupied(const Parts& parts) {
    return static_cast<std::size_t>(
        std::ranges::count_if(parts, [](Range part) { return part.begin < part.end; }));
  }

  /// Reorders a range so that each octant's spheres are together, in input order.
  Parts sort_by_octant(Range range, const Cube& cube) {
    const auto octant_at = [&](std::uint32_t place) {
      return cube.octant_of(spheres_[indices_[place]].center);
    };
    std::array<std::uint32_t, octants> counts{};
    for (std::uint32_t i = range.begin; i < range.end; ++i) ++counts[octant_at(i)];
    Parts parts;
    std::uint32_t place = range.begin;
    for (std::size_t octant = 0; octant < octants; ++octant) {
      parts[octant] = {place, place};
      place += counts[octant];
    }
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      sorted_[parts[octant_at(i)].end++] = indices_[i];
    }
    std::copy(sorted_.begin() + range.begin, sorted_.begin() + range.end,
              indices_.begin() + range.begin);
    return parts;
  }

  // --- second pass, from the bottom

  /// Children come after their parents. So in reverse order the children of each cell are ready.
  void bound_cells() {
    for (auto cell = tree_.cells_.rbegin(); cell != tree_.cells_.rend(); ++cell) {
      cell->extent.lo.fill(std::numeric_limits<Real>::infinity());
      cell->extent.hi.fill(-std::numeric_limits<Real>::infinity());
      for (std::uint32_t i = cell->first; i < cell->first + cell->count; ++i) {
        include(cell->extent,
                cell->is_leaf ? extent_of(tree_.spheres_[i]) : tree_.cells_[i].extent);
      }
    }
  }

  /// Returns the bounds with the sphere's own part of the rounding (see Octree).
  static Extent extent_of(const SphereShape<Real>& sphere) {
    constexpr auto root_of_3 = static_cast<Real>(1.7320509);  // rounded up
    const Slabs center = project(sphere.center);
    const Slabs margin = margins(largest_component(sphere.center) + sphere.radius);
    Extent extent;
    for (std::size_t k = 0; k < slab_count; ++k) {
      const Real reach = (k < 3 ? Real(1) : root_of_3) * sphere.radius + margin[k];
      extent.lo[k] = center[k] - reach;
      extent.hi[k] = center[k] + reach;
    }
    return extent;
  }

  static void include(Extent& extent, const Extent& other) {
    for (std::size_t k = 0; k < slab_count; ++k) {
      extent.lo[k] = min_of(extent.lo[k], other.lo[k]);
      extent.hi[k] = max_of(extent.hi[k], other.hi[k]);
    }
  }

  const std::vector<SphereShape<Real>>& spheres_;
  Octree& tree_;
  std::vector<std::uint32_t> indices_;  ///< input index at each place
  std::vector<std::uint32_t> sorted_;   ///< scratch
};

template <typename Real>
Octree<Real>::Octree(const std::vector<SphereShape<Real>>& spheres) {
  if (!spheres.empty()) Builder(spheres, *this).run();
}

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
