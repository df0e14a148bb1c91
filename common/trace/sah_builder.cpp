#include "common/trace/sah_builder.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>

namespace parray {
namespace {

constexpr std::size_t bin_count = 16;
/// Ranges of more spheres are split by tasks of their own.
constexpr std::uint32_t task_size = 1U << 15;
/// From this depth on ranges are halved, which ends within 30 levels.
constexpr std::uint32_t halving_from = max_tree_depth - 32;

template <typename Store>
Store component(const Vec3<Store>& v, int axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

template <typename Store>
Bounds<Store> no_bounds() {
  constexpr Store inf = std::numeric_limits<Store>::infinity();
  return {{inf, inf, inf}, {-inf, -inf, -inf}};
}

template <typename Store>
void include(Bounds<Store>& box, const Vec3<Store>& lo, const Vec3<Store>& hi) {
  box.lo = {min_of(lo.x, box.lo.x), min_of(lo.y, box.lo.y), min_of(lo.z, box.lo.z)};
  box.hi = {max_of(hi.x, box.hi.x), max_of(hi.y, box.hi.y), max_of(hi.z, box.hi.z)};
}

template <typename Store>
void include(Bounds<Store>& box, const Bounds<Store>& other) {
  include(box, other.lo, other.hi);
}

template <typename Store>
void include(Bounds<Store>& box, const BuildSphere<Store>& sphere) {
  const Vec3<Store> extent{sphere.radius, sphere.radius, sphere.radius};
  include(box, sphere.center - extent, sphere.center + extent);
}

template <typename Store>
Store half_area(const Bounds<Store>& box) {
  const Vec3<Store> d = box.hi - box.lo;
  return d.x * d.y + d.y * d.z + d.z * d.x;
}

template <typename Store>
class Builder {
 public:
  using Sphere = BuildSphere<Store>;

  Builder(std::span<Sphere> spheres, std::uint32_t leaf_size)
      : spheres_(spheres), leaf_size_(leaf_size) {
    tree_.nodes = AlignedArray<BinaryNode<Store>>(2 * spheres.size());
  }

  BinaryTree<Store> run(int threads) {
    Range all{0, static_cast<std::uint32_t>(spheres_.size()), no_bounds<Store>(),
              no_bounds<Store>()};
    for (const Sphere& sphere : spheres_) {
      include(all.box, sphere);
      include(all.centers, sphere.center, sphere.center);
    }
#pragma omp parallel num_threads(threads) if (threads > 1)
#pragma omp single
    {
      std::uint32_t next = 1;
      build(all, 0, next, 1);
    }
    tree_.depth = depth_;
    return std::move(tree_);
  }

 private:
  struct Range {
    std::uint32_t begin;
    std::uint32_t end;
    Bounds<Store> box;
    Bounds<Store> centers;

    [[nodiscard]] std::uint32_t count() const { return end - begin; }
  };

  struct Bin {
    Bounds<Store> box = no_bounds<Store>();
    Bounds<Store> centers = no_bounds<Store>();
    std::uint32_t count = 0;
  };
  using Bins = std::array<Bin, bin_count>;

  /// Where to cut a range: bins below `bin` of `axis` go left. axis < 0: no useful plane.
  struct Plane {
    int axis = -1;
    std::size_t bin = 0;
    Store cost = std::numeric_limits<Store>::infinity();
  };

  /// Maps centres to bins along an axis.
  struct Binning {
    Binning(const Range& range, int a)
        : axis(a),
          lo(component(range.centers.lo, a)),
          scale(static_cast<Store>(bin_count) / (component(range.centers.hi, a) - lo)) {}

    [[nodiscard]] std::size_t bin_of(const Sphere& sphere) const {
      const Store scaled = (component(sphere.center, axis) - lo) * scale;
      return scaled < static_cast<Store>(bin_count - 1) ? static_cast<std::size_t>(scaled)
                                                        : bin_count - 1;
    }
    int axis;
    Store lo;
    Store scale;
  };

  /// Fills node `node`. Nodes of a large range's subtree have fixed places, so that tasks need not
  /// agree on them: the range's node, then twice its left spheres less one, then the right ones. A
  /// small range's nodes follow each other from `next` on.
  void build(const Range& range, std::uint32_t node, std::uint32_t& next, std::uint32_t level) {
    BinaryNode<Store>& made = tree_.nodes[node];
    made = {range.box, range.begin, range.end, 0, 0};
    note_depth(level);
    if (range.count() <= leaf_size_) {
      return;
    }
    Range left;
    Range right;
    split(range, level, left, right);
    if (range.count() > task_size) {
      made.left = node + 1;
      made.right = node + 2 * left.count();
      const std::uint32_t left_node = made.left;
      const std::uint32_t right_node = made.right;
#pragma omp task default(none) firstprivate(left, left_node, level)
      {
        std::uint32_t first = left_node + 1;
        build(left, left_node, first, level + 1);
      }
      std::uint32_t first = right_node + 1;
      build(right, right_node, first, level + 1);
#pragma omp taskwait
      return;
    }
    made.left = next++;
    made.right = next++;
    build(left, made.left, next, level + 1);
    build(right, made.right, next, level + 1);
  }

  void note_depth(std::uint32_t level) {
    std::uint32_t known = depth_.load(std::memory_order_relaxed);
    while (known < level && !depth_.compare_exchange_weak(known, level)) {
    }
  }

  /// Block tests that a number of spheres costs.
  [[nodiscard]] Store blocks(std::uint32_t count) const {
    return static_cast<Store>((count + leaf_size_ - 1) / leaf_size_);
  }

  void split(const Range& range, std::uint32_t level, Range& left, Range& right) {
    std::array<Bins, 3> bins;
    Plane best;
    if (level < halving_from) {
      best = best_plane(range, bins);
    }
    const auto first = spheres_.begin() + range.begin;
    const auto last = spheres_.begin() + range.end;
    if (best.axis < 0) {  // coincident centres, or too deep
      halve(range, left, right);
      return;
    }
    const Binning binning(range, best.axis);
    const auto cut = std::partition(
        first, last, [&](const Sphere& sphere) { return binning.bin_of(sphere) < best.bin; });
    const auto middle = static_cast<std::uint32_t>(cut - spheres_.begin());
    left = {range.begin, middle, no_bounds<Store>(), no_bounds<Store>()};
    right = {middle, range.end, no_bounds<Store>(), no_bounds<Store>()};
    const Bins& chosen = bins[static_cast<std::size_t>(best.axis)];
    for (std::size_t b = 0; b < bin_count; ++b) {
      Range& side = b < best.bin ? left : right;
      include(side.box, chosen[b].box);
      include(side.centers, chosen[b].centers);
    }
  }

  void halve(const Range& range, Range& left, Range& right) const {
    const std::uint32_t middle = range.begin + range.count() / 2;
    left = {range.begin, middle, no_bounds<Store>(), no_bounds<Store>()};
    right = {middle, range.end, no_bounds<Store>(), no_bounds<Store>()};
    for (Range* side : {&left, &right}) {
      for (std::uint32_t i = side->begin; i < side->end; ++i) {
        include(side->box, spheres_[i]);
        include(side->centers, spheres_[i].center, spheres_[i].center);
      }
    }
  }

  Plane best_plane(const Range& range, std::array<Bins, 3>& bins) const {
    Plane best;
    for (int axis = 0; axis < 3; ++axis) {
      const Store extent = component(range.centers.hi, axis) - component(range.centers.lo, axis);
      if (!(extent > Store(0)) ||
          !(Store(bin_count) / extent < std::numeric_limits<Store>::infinity())) {
        continue;
      }
      Bins& along = bins[static_cast<std::size_t>(axis)];
      const Binning binning(range, axis);
      for (std::uint32_t i = range.begin; i < range.end; ++i) {
        const Sphere& sphere = spheres_[i];
        Bin& bin = along[binning.bin_of(sphere)];
        include(bin.box, sphere);
        include(bin.centers, sphere.center, sphere.center);
        ++bin.count;
      }
      sweep(along, axis, best);
    }
    return best;
  }

  /// Cost of each cut: area times block tests on both sides.
  void sweep(const Bins& bins, int axis, Plane& best) const {
    std::array<Store, bin_count> right_cost{};
    Bounds<Store> box = no_bounds<Store>();
    std::uint32_t count = 0;
    for (std::size_t b = bin_count - 1; b > 0; --b) {
      include(box, bins[b].box);
      count += bins[b].count;
      right_cost[b] = count == 0 ? Store(0) : half_area(box) * blocks(count);
    }
    const std::uint32_t total = count + bins[0].count;
    box = no_bounds<Store>();
    count = 0;
    for (std::size_t b = 1; b < bin_count; ++b) {
      include(box, bins[b - 1].box);
      count += bins[b - 1].count;
      if (count == 0 || count == total) {
        continue;
      }
      const Store cost = half_area(box) * blocks(count) + right_cost[b];
      if (cost < best.cost) {
        best = {axis, b, cost};
      }
    }
  }

  std::span<Sphere> spheres_;
  std::uint32_t leaf_size_;
  BinaryTree<Store> tree_;
  std::atomic<std::uint32_t> depth_ = 0;
};

}  // namespace

template <typename Store>
BinaryTree<Store> build_binary_tree(std::span<BuildSphere<Store>> spheres, std::uint32_t leaf_size,
                                    int threads) {
  return Builder<Store>(spheres, leaf_size).run(threads);
}

template BinaryTree<float> build_binary_tree(std::span<BuildSphere<float>>, std::uint32_t, int);
template BinaryTree<double> build_binary_tree(std::span<BuildSphere<double>>, std::uint32_t, int);

}  // namespace parray
