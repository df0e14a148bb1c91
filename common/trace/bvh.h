#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/trace/accelerator.h"

namespace parray {

/// Box of a node, inflated so that it holds every point that enters() may compute for a sphere
/// inside, rounding included (see Bvh).
template <typename Real>
struct Box {
  Vec3<Real> lo;
  Vec3<Real> hi;
};

/// Binary bounding volume hierarchy, built top-down by the surface area heuristic.
///
/// Same bits as linear search: a ray may miss a box only if enters() misses every sphere in it.
/// enters() is exact to 6 ulp of max(radius, distance) [measured, Haines 2019], so boxes grow by
/// 32 unit roundoffs of their spheres' own coordinates at build and of the ray's origin at
/// traversal: a bound on rounding, in proportion to the numbers that are rounded.
///
/// Immutable after construction. 32 bytes a node in single precision, two nodes a leaf of up to
/// `leaf_size` spheres at most. Depth is at most `max_depth`, whatever the input.
template <typename Real>
class Bvh {
 public:
  /// Any number of spheres, none included. Sequential and deterministic.
  explicit Bvh(const std::vector<SphereShape<Real>>& spheres);

  void enter(const Ray<Real>& ray, const Sides<Real>& sides, Hit<Real>& best) const;

  [[nodiscard]] std::size_t bytes() const {
    return nodes_.size() * sizeof(Node) + spheres_.size() * sizeof(SphereShape<Real>) +
           indices_.size() * sizeof(std::uint32_t);
  }
  [[nodiscard]] std::uint32_t depth() const { return depth_; }

  static constexpr std::uint32_t leaf_size = 4;
  static constexpr std::uint32_t max_depth = 60;

 private:
  struct Node {
    Box<Real> box;
    std::uint32_t first = 0;  ///< leaf: first sphere; inner: left child, the right one follows it
    std::uint32_t count = 0;  ///< spheres of a leaf; 0: inner node
  };
  struct Probe;
  class Builder;

  std::vector<Node> nodes_;
  std::vector<SphereShape<Real>> spheres_;  ///< in leaf order
  std::vector<std::uint32_t> indices_;      ///< input index of each
  std::uint32_t depth_ = 0;
};

/// A ray prepared for box tests: plane origins moved outward by the ray's share of the rounding.
template <typename Real>
struct Bvh<Real>::Probe {
  explicit Probe(const Ray<Real>& ray) {
    const auto& o = ray.origin;
    const Real reach =
        max_of(max_of(o.x < 0 ? -o.x : o.x, o.y < 0 ? -o.y : o.y), o.z < 0 ? -o.z : o.z);
    const Real margin = Real(32) * RealTraits<Real>::unit_roundoff * reach;
    const Vec3<Real> grow{margin, margin, margin};
    for_lo = o + grow;
    for_hi = o - grow;
    inverse = {Real(1) / ray.direction.x, Real(1) / ray.direction.y, Real(1) / ray.direction.z};
  }

  /// Parameter at which the ray reaches the box, infinity if it does not before `t_max`. A NaN
  /// (the origin on a plane that the ray runs along) constrains nothing: see min_of and max_of.
  [[nodiscard]] Real reach(const Box<Real>& box, Real t_max) const {
    Real near = Real(0);
    Real far = t_max;
    clip(box.lo.x - for_lo.x, box.hi.x - for_hi.x, inverse.x, near, far);
    clip(box.lo.y - for_lo.y, box.hi.y - for_hi.y, inverse.y, near, far);
    clip(box.lo.z - for_lo.z, box.hi.z - for_hi.z, inverse.z, near, far);
    return near <= far ? near : std::numeric_limits<Real>::infinity();
  }

  static void clip(Real to_lo, Real to_hi, Real inverse, Real& near, Real& far) {
    const Real t_lo = to_lo * inverse;
    const Real t_hi = to_hi * inverse;
    near = max_of(min_of(t_lo, t_hi), near);
    far = min_of(max_of(t_lo, t_hi), far);
  }

  Vec3<Real> for_lo;
  Vec3<Real> for_hi;
  Vec3<Real> inverse;
};

template <typename Real>
void Bvh<Real>::enter(const Ray<Real>& ray, const Sides<Real>& sides, Hit<Real>& best) const {
  if (nodes_.empty()) {
    return;
  }
  constexpr Real miss = std::numeric_limits<Real>::infinity();
  struct Pending {
    std::uint32_t node;
    Real t;
  };
  std::array<Pending, max_depth + 1> stack;
  std::size_t pending = 0;
  const Probe probe(ray);
  std::uint32_t index = 0;
  Real t = probe.reach(nodes_[0].box, best.t);
  for (;;) {
    if (t <= best.t && t != miss) {  // <=: an equal distance may win by its index
      const Node& node = nodes_[index];
      if (node.count == 0) {
        const Real left = probe.reach(nodes_[node.first].box, best.t);
        const Real right = probe.reach(nodes_[node.first + 1].box, best.t);
        const bool left_first = left <= right;
        const Real far = left_first ? right : left;
        if (far != miss) {
          stack[pending++] = {node.first + (left_first ? 1U : 0U), far};
        }
        index = node.first + (left_first ? 0U : 1U);
        t = left_first ? left : right;
        continue;
      }
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        try_sphere(ray, spheres_[i], indices_[i], sides, best);
      }
    }
    if (pending == 0) {
      return;
    }
    --pending;
    index = stack[pending].node;
    t = stack[pending].t;
  }
}

}  // namespace parray

#include "common/trace/bvh_build.h"
