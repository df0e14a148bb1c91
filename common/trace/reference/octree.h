#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/trace/sphere_search.h"

namespace parray::trace {

/// The accelerator of the program that ParRay started from: an octree whose cells are bounded by
/// seven pairs of parallel planes, searched best first. Kept to repeat that program's comparison
/// with linear search; WideBvh is the one for pictures.
///
/// Built in two passes. From the top, a cube around all centres is halved along every axis, again
/// and again, until each cell holds one sphere; from the bottom, each cell gets the extents of what
/// it holds. The planes are at right angles to the three axes and the four space diagonals.
/// Source: Kay and Kajiya, "Ray tracing complex scenes", SIGGRAPH 1986.
///
/// Any input ends: halvings that part nothing make no cell, so that there are fewer than two cells
/// a sphere, and spheres that `max_depth` - 1 halvings do not part (coincident centres: none do)
/// share a leaf, which is searched in line.
///
/// Same bits as linear search: a cell may be missed only if enters() misses every sphere in it. The
/// computed hit lies within 12 unit roundoffs u of max(radius, distance) of the sphere (see
/// WideBvh), that is within 21 u M of it, where M is the sum of the largest coordinates of sphere,
/// radius included, and of origin. Along a diagonal n = (1, +-1, +-1), of length sqrt(3), that is
/// 36 u M; rounding n.centre +- sqrt(3) radius and n.origin adds 11 u M, the difference of the two
/// and its quotient by n.direction 9 u M. That divisor may cancel to nothing but its sign, so its
/// error counts not by itself but times the way: 2 u |n.way| <= 6 u M. Together 62 u M; planes move
/// outward by 3 x 32 u M, the 3 being the sum of n's components; those of the axes by 32 u M.
/// The sphere's part is added at build, the origin's at the search.
///
/// Immutable after construction. 68 bytes a cell in single precision.
template <typename Real>
class Octree {
 public:
  /// Builds the tree of any number of spheres, even none. Sequential and deterministic.
  explicit Octree(const std::vector<SphereShape<Real>>& spheres);

  void enter(const Ray<Real>& ray, const InsideStack<Real>& sides, Hit<Real>& best) const;

  [[nodiscard]] std::size_t bytes() const {
    return cells_.size() * sizeof(Cell) + spheres_.size() * sizeof(SphereShape<Real>) +
           indices_.size() * sizeof(std::uint32_t);
  }
  /// Returns the number of cells on the longest way down; 0 without spheres.
  [[nodiscard]] std::uint32_t depth() const { return depth_; }

  static constexpr std::uint32_t max_depth = 64;

 private:
  static constexpr std::size_t slab_count = 7;

  /// One number for each of the seven directions.
  using Slabs = std::array<Real, slab_count>;
  struct Extent {
    Slabs lo;
    Slabs hi;
  };
  struct Cell {
    Extent extent;
    std::uint32_t first = 0;  ///< leaf: first sphere; otherwise first of the consecutive children
    std::uint32_t count = 0;  ///< number of spheres or children
    bool is_leaf = false;     ///< a leaf holds one sphere, or spheres that no halving separates
  };
  struct Probe;
  class Builder;

  static Slabs project(const Vec3<Real>& v);
  static Slabs margins(Real size);

  std::vector<Cell> cells_;                 ///< children after their parents
  std::vector<SphereShape<Real>> spheres_;  ///< in leaf order
  std::vector<std::uint32_t> indices_;      ///< input index of each sphere
  std::uint32_t depth_ = 0;
};

extern template class Octree<float>;
extern template class Octree<double>;

}  // namespace parray::trace
