#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/trace/sphere_search.h"

namespace parray::trace {

/// The accelerator of the program that ParRay started from: an octree whose cells are bounded by
/// seven pairs of parallel planes. A ray visits the nearest cell first. The octree serves to repeat
/// that program's comparison with linear search; pictures are normally traced with WideBvh.
///
/// The octree is built in two passes. The first pass starts with a cube around all centres. It
/// halves a cell along every axis, again and again, until each cell holds one sphere. The second
/// pass starts at the leaves and computes the extent of what each cell holds. The planes are at
/// right angles to the three axes and the four space diagonals. Source: Kay and Kajiya, "Ray
/// tracing complex scenes", SIGGRAPH 1986.
///
/// The first pass ends for every input. A halving that separates no spheres makes no cell, so there
/// are fewer than two cells per sphere. Spheres that `max_depth` - 1 halvings do not separate share
/// a leaf, and so do spheres with the same centre. A ray tests the spheres of such a leaf one after
/// the other.
///
/// The octree gives the same bits as linear search: a ray may miss a cell only if enters() misses
/// every sphere in it. Let u be the unit roundoff, and M the largest coordinate of the sphere,
/// radius included, plus that of the ray's origin. The computed hit lies within 12 u max(radius,
/// distance) of the sphere (see WideBvh), which is less than 21 u M. Along a diagonal n = (1, +-1,
/// +-1), whose length is sqrt(3), that is 36 u M. Rounding n.centre +- sqrt(3) radius and n.origin
/// adds 11 u M. Their difference and its quotient by n.direction add 9 u M. Cancellation may leave
/// nothing of that divisor but its sign. Therefore its absolute error counts, times the distance:
/// at most 6 u M. The sum is 62 u M. Planes across a diagonal move outward by 3 x 32 u M, where 3
/// is the sum of the absolute components of n. Planes across an axis move by 32 u M. The
/// construction adds the sphere's part of this margin, the search the origin's part.
///
/// Immutable after construction. A cell takes 68 bytes in single precision.
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
  /// Returns the number of cells on the longest path from the root to a leaf; 0 without spheres.
  [[nodiscard]] std::uint32_t depth() const { return depth_; }

  static constexpr std::uint32_t max_depth = 64;  ///< largest depth()

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
