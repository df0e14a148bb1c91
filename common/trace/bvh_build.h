#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

#include "common/trace/bvh.h"

namespace parray {

/// Top-down construction with 16 bins an axis.
/// Source: Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007.
template <typename Real>
class Bvh<Real>::Builder {
 public:
  Builder(const std::vector<SphereShape<Real>>& spheres, Bvh& bvh) : spheres_(spheres), bvh_(bvh) {
    boxes_.reserve(spheres.size());
    for (const auto& sphere : spheres) {
      boxes_.push_back(box_of(sphere));
    }
    bvh_.indices_.resize(spheres.size());
    std::iota(bvh_.indices_.begin(), bvh_.indices_.end(), 0U);
  }

  void run() {
    bvh_.nodes_.reserve(spheres_.size());
    bvh_.nodes_.emplace_back();
    split(0, 0, static_cast<std::uint32_t>(spheres_.size()), 1);
    bvh_.nodes_.shrink_to_fit();
    bvh_.spheres_.reserve(spheres_.size());
    for (const std::uint32_t index : bvh_.indices_) {
      bvh_.spheres_.push_back(spheres_[index]);
    }
  }

 private:
  static constexpr std::size_t bin_count = 16;

  struct Bin {
    Box<Real> box = empty_box();
    std::uint32_t count = 0;
  };

  /// Where to cut a range: bins below `bin` of `axis` go left. axis < 0: no useful plane.
  struct Plane {
    int axis = -1;
    std::size_t bin = 0;
    Real cost = std::numeric_limits<Real>::infinity();
  };

  static Real component(const Vec3<Real>& v, int axis) {
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
  }

  static Box<Real> empty_box() {
    constexpr Real inf = std::numeric_limits<Real>::infinity();
    return {{inf, inf, inf}, {-inf, -inf, -inf}};
  }

  /// Bounds with the sphere's own share of the rounding (see Bvh).
  static Box<Real> box_of(const SphereShape<Real>& sphere) {
    const auto& c = sphere.center;
    const Real size = max_of(max_of(std::abs(c.x), std::abs(c.y)), std::abs(c.z)) + sphere.radius;
    const Real reach = sphere.radius + Real(32) * RealTraits<Real>::unit_roundoff * size;
    const Vec3<Real> extent{reach, reach, reach};
    return {c - extent, c + extent};
  }

  static void include(Box<Real>& box, const Box<Real>& other) {
    box.lo = {min_of(box.lo.x, other.lo.x), min_of(box.lo.y, other.lo.y),
              min_of(box.lo.z, other.lo.z)};
    box.hi = {max_of(box.hi.x, other.hi.x), max_of(box.hi.y, other.hi.y),
              max_of(box.hi.z, other.hi.z)};
  }

  static Real half_area(const Box<Real>& box) {
    const Vec3<Real> d = box.hi - box.lo;
    return d.x * d.y + d.y * d.z + d.z * d.x;
  }

  void split(std::uint32_t node, std::uint32_t begin, std::uint32_t end, std::uint32_t level) {
    Box<Real> box = empty_box();
    Box<Real> centers = empty_box();
    for (std::uint32_t i = begin; i < end; ++i) {
      const std::uint32_t index = bvh_.indices_[i];
      include(box, boxes_[index]);
      include(centers, {spheres_[index].center, spheres_[index].center});
    }
    bvh_.depth_ = std::max(bvh_.depth_, level);
    bvh_.nodes_[node].box = box;
    const std::uint32_t count = end - begin;
    if (count <= 2) {
      make_leaf(node, begin, count);
      return;
    }
    const Plane plane = best_plane(begin, end, centers);
    const Real leaf_cost = static_cast<Real>(count) * half_area(box);
    if (count <= leaf_size && !(plane.cost + half_area(box) < leaf_cost)) {
      make_leaf(node, begin, count);
      return;
    }
    const std::uint32_t middle = partition(begin, end, centers, plane, level);
    const auto left = static_cast<std::uint32_t>(bvh_.nodes_.size());
    bvh_.nodes_[node].first = left;
    bvh_.nodes_.resize(bvh_.nodes_.size() + 2);
    split(left, begin, middle, level + 1);
    split(left + 1, middle, end, level + 1);
  }

  void make_leaf(std::uint32_t node, std::uint32_t begin, std::uint32_t count) {
    bvh_.nodes_[node].first = begin;
    bvh_.nodes_[node].count = count;
  }

  static std::size_t bin_of(Real center, Real lo, Real hi) {
    const Real scaled = static_cast<Real>(bin_count) * ((center - lo) / (hi - lo));
    return std::min(static_cast<std::size_t>(scaled), bin_count - 1);
  }

  Plane best_plane(std::uint32_t begin, std::uint32_t end, const Box<Real>& centers) const {
    Plane best;
    for (int axis = 0; axis < 3; ++axis) {
      const Real lo = component(centers.lo, axis);
      const Real hi = component(centers.hi, axis);
      if (!(hi > lo)) {
        continue;
      }
      std::array<Bin, bin_count> bins;
      for (std::uint32_t i = begin; i < end; ++i) {
        const std::uint32_t index = bvh_.indices_[i];
        Bin& bin = bins[bin_of(component(spheres_[index].center, axis), lo, hi)];
        include(bin.box, boxes_[index]);
        ++bin.count;
      }
      sweep(bins, axis, best);
    }
    return best;
  }

  /// Cost of each cut: area times count on both sides.
  static void sweep(const std::array<Bin, bin_count>& bins, int axis, Plane& best) {
    std::array<Real, bin_count> right_cost{};
    Box<Real> box = empty_box();
    std::uint32_t count = 0;
    for (std::size_t b = bin_count - 1; b > 0; --b) {
      include(box, bins[b].box);
      count += bins[b].count;
      right_cost[b] = count == 0 ? Real(0) : half_area(box) * static_cast<Real>(count);
    }
    box = empty_box();
    const std::uint32_t total = count + bins[0].count;
    count = 0;
    for (std::size_t b = 1; b < bin_count; ++b) {
      include(box, bins[b - 1].box);
      count += bins[b - 1].count;
      if (count == 0 || count == total) {
        continue;
      }
      const Real cost = half_area(box) * static_cast<Real>(count) + right_cost[b];
      if (cost < best.cost) {
        best = {axis, b, cost};
      }
    }
  }

  /// Reorders [begin, end) by the plane; in the middle where no plane separates anything
  /// (coincident centres) or where the depth left is only enough for halving.
  std::uint32_t partition(std::uint32_t begin, std::uint32_t end, const Box<Real>& centers,
                          const Plane& plane, std::uint32_t level) {
    constexpr std::uint32_t halving_from = max_depth - 32;
    if (plane.axis < 0 || level >= halving_from) {
      return begin + (end - begin) / 2;
    }
    const Real lo = component(centers.lo, plane.axis);
    const Real hi = component(centers.hi, plane.axis);
    const auto first = bvh_.indices_.begin();
    const auto cut = std::stable_partition(first + begin, first + end, [&](std::uint32_t index) {
      return bin_of(component(spheres_[index].center, plane.axis), lo, hi) < plane.bin;
    });
    return static_cast<std::uint32_t>(cut - first);
  }

  const std::vector<SphereShape<Real>>& spheres_;
  Bvh& bvh_;
  std::vector<Box<Real>> boxes_;
};

template <typename Real>
Bvh<Real>::Bvh(const std::vector<SphereShape<Real>>& spheres) {
  if (!spheres.empty()) {
    Builder(spheres, *this).run();
  }
}

}  // namespace parray
