#pragma once

#include <cstdint>

#include "common/trace/bvh/ray_groups.h"
#include "common/trace/device/device_view.h"
#include "common/trace/sphere_search.h"

/// Searches in the tables of a device (a GPU), for one ray at a time. They meet the concept
/// EntrySearch (sphere_search.h).
namespace parray::trace {

/// Tests all spheres in input order. first_crossing() tests the capsules.
template <typename Real, typename Store>
class DeviceLinear {
 public:
  explicit DeviceLinear(const void* scene) : scene_(scene) {}

  template <typename List>
  void enter(const Ray<Real>& ray, const InsideStack<Real, List>& sides, Hit<Real>& best) const {
    for (std::uint32_t i = 0; i < scene_.spheres.size(); ++i) {
      try_shape<Real>(ray, scene_.spheres[i], i, sides, best);
    }
  }

 private:
  DeviceSceneView<Real, Store> scene_;
};

/// A ray for the tests of boxes, in the type of boxes. The planes of boxes move outward by 32
/// roundoffs of the ray's origin: see wide_bvh.h and Slab.
template <typename Store>
struct BoxRay {
  template <typename Real>
  explicit BoxRay(const Ray<Real>& ray)
      : BoxRay(vec_cast<Store>(ray.origin), vec_cast<Store>(ray.direction)) {}

  /// Returns the ray parameter, >= 0, at which the ray enters the box of child `k` of a node.
  /// Returns infinity if the ray misses the box or enters it beyond `bound`.
  [[nodiscard]] Store enters_at(const WideNode<Store, device_width>& node, int k,
                                Store bound) const {
    const auto plane = [&](int axis, bool far_side) {
      return node.planes[axis][(octant >> axis & 1) ^ (far_side ? 1U : 0U)][k];
    };
    const Store near =
        max_of(max_of(plane(0, false) * x.inverse + x.near, plane(1, false) * y.inverse + y.near),
               max_of(plane(2, false) * z.inverse + z.near, Store(0)));
    const Store far =
        min_of(min_of(plane(0, true) * x.inverse + x.far, plane(1, true) * y.inverse + y.far),
               min_of(plane(2, true) * z.inverse + z.far, bound));
    return near <= far ? near : RealTraits<Store>::infinity;
  }

  Slab<Store> x, y, z;
  std::uint32_t octant;  ///< bits 0, 1 and 2: the direction is negative along x, y and z
  bool is_number;        ///< false: a NaN, which meets nothing

 private:
  BoxRay(const Vec3<Store>& o, const Vec3<Store>& d) : BoxRay(o, d, reach_of(o)) {}
  BoxRay(const Vec3<Store>& o, const Vec3<Store>& d, Store reach)
      : BoxRay(o, d, Store(32) * RealTraits<Store>::unit_roundoff * reach,
               Slab<Store>::steepest(reach)) {}
  BoxRay(const Vec3<Store>& o, const Vec3<Store>& d, Store margin, Store steepest)
      : x(o.x, d.x, margin, steepest),
        y(o.y, d.y, margin, steepest),
        z(o.z, d.z, margin, steepest),
        octant((x.down ? 1U : 0U) + (y.down ? 2U : 0U) + (z.down ? 4U : 0U)) {
    const Store sum = (o.x + o.y + o.z) + (d.x + d.y + d.z);
    is_number = sum == sum;  // NOLINT(misc-redundant-expression): a NaN is not
  }
  static Store reach_of(const Vec3<Store>& o) {
    return max_of(max_of(max_of(o.x, -o.x), max_of(o.y, -o.y)), max_of(o.z, -o.z));
  }
};

/// Searches the trees of spheres and of capsules. A ray visits the children of a node in the order
/// of its octant, and skips boxes beyond the nearest crossing.
template <typename Real, typename Store>
class DeviceTree {
 public:
  explicit DeviceTree(const void* scene)
      : spheres_(tree_view<SphereBlock>(scene, head_of(scene).sphere_tree)),
        capsules_(tree_view<CapsuleBlock>(scene, head_of(scene).capsule_tree)),
        sphere_count_(static_cast<std::uint32_t>(head_of(scene).spheres.count)) {}

  template <typename List>
  void enter(const Ray<Real>& ray, const InsideStack<Real, List>& sides, Hit<Real>& best) const {
    for (std::uint32_t slot = 0; slot < spheres_.open_spheres; ++slot) {
      try_slot(spheres_, slot, 0, ray, sides, best);
    }
    search(spheres_, 0, ray, sides, best);
  }
  template <typename List>
  void enter_capsules(const Ray<Real>& ray, const InsideStack<Real, List>& sides,
                      Hit<Real>& best) const {
    search(capsules_, sphere_count_, ray, sides, best);
  }

 private:
  static const DeviceSceneHead<Real, Store>& head_of(const void* scene) {
    return DeviceSceneView<Real, Store>::head_of(scene);
  }

  /// Children that a ray has yet to visit, with the distances of their boxes.
  struct Pending {
    Store t[device_stack];
    std::uint32_t child[device_stack];
    std::uint32_t count = 0;

    void push(Store distance, std::uint32_t reference) {
      t[count] = distance;
      child[count++] = reference;
    }
    /// Takes the last child that is not beyond `bound`. Returns false if there is none.
    bool pop(Store bound, std::uint32_t& reference) {
      while (count > 0) {
        --count;
        if (t[count] <= bound) {
          reference = child[count];
          return true;
        }
      }
      return false;
    }
  };

  /// Returns the distance of a crossing in the type of boxes, not rounded down.
  static Store bound_of(Real t) {
    if constexpr (sizeof(Real) == sizeof(Store)) {
      return t;
    } else {
      return static_cast<Store>(t) * (1 + 4 * RealTraits<Store>::unit_roundoff);
    }
  }

  template <typename Tree, typename List>
  static void try_slot(const Tree& tree, std::uint32_t slot, std::uint32_t first_number,
                       const Ray<Real>& ray, const InsideStack<Real, List>& sides,
                       Hit<Real>& best) {
    try_shape(ray, shape_at<Real>(tree.blocks, slot), first_number + tree.labels.index(slot), sides,
              best);
  }

  /// Replaces a node by those of its children that the ray meets before `bound`.
  static void push_children(const WideNode<Store, device_width>& node, const BoxRay<Store>& boxes,
                            Store bound, Pending& pending) {
    Store t[device_width];
    for (int k = 0; k < device_width; ++k) t[k] = boxes.enters_at(node, k, bound);
    for (const std::uint8_t k : node.order[boxes.octant]) {
      if (t[k] < RealTraits<Store>::infinity) pending.push(t[k], node.child[k]);
    }
  }

  /// Improves `best` with the shapes of a tree. Their numbers begin with `first_number`.
  template <typename Tree, typename List>
  static void search(const Tree& tree, std::uint32_t first_number, const Ray<Real>& ray,
                     const InsideStack<Real, List>& sides, Hit<Real>& best) {
    const BoxRay<Store> boxes(ray);
    if (tree.node_count == 0 || !boxes.is_number) return;
    Pending pending;
    std::uint32_t child = 0;
    do {
      if ((child & ChildRef::is_block) == 0) {
        push_children(tree.nodes[child], boxes, bound_of(best.t), pending);
      } else {
        const std::uint32_t first = (child & ChildRef::number) * device_width;
        for (std::uint32_t slot = first; slot < first + device_width; ++slot) {
          try_slot(tree, slot, first_number, ray, sides, best);
        }
      }
    } while (pending.pop(bound_of(best.t), child));
  }

  BvhView<Store, device_width> spheres_;
  BvhView<Store, device_width, CapsuleBlock> capsules_;
  std::uint32_t sphere_count_;
};

}  // namespace parray::trace
