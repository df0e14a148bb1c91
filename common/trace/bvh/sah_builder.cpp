#include "common/trace/bvh/sah_builder.h"

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "common/base/arrays.h"
#include "common/base/bands.h"
#include "common/math/vec4.h"

namespace parray::trace {
namespace {

constexpr std::size_t bin_count = 16;
constexpr std::uint32_t one_axis_from = 1U << 13;
/// From this many shapes on, trees have full blocks, to save memory: ranges up to a size are cut
/// at whole blocks. Smaller trees are cut where the heuristic chooses, which is up to 5 % faster.
constexpr std::size_t filled_from = 1U << 12;
constexpr std::uint32_t filled_range = 1U << 10;
/// Ranges of more shapes are separate tasks.
constexpr std::uint32_t task_size = 1U << 15;
/// From this depth on, ranges are halved, so that the recursion ends within 30 levels.
constexpr std::uint32_t halving_from = max_tree_depth - 32;

/// Bounds with an unused fourth component, in the form of the builder's computations.
template <typename Store>
struct WideBounds {
  static constexpr Store inf = std::numeric_limits<Store>::infinity();
  Vec4<Store> lo{inf};
  Vec4<Store> hi{-inf};

  PARRAY_INLINE void include(const Vec4<Store>& other_lo, const Vec4<Store>& other_hi) {
    lo = min_of(lo, other_lo);
    hi = max_of(hi, other_hi);
  }
  PARRAY_INLINE void include(const WideBounds& other) { include(other.lo, other.hi); }
  /// Includes the shape around `center` that reaches as far as `extent` along each axis.
  PARRAY_INLINE void include_shape(const Vec4<Store>& center, const Vec4<Store>& extent) {
    include(center - extent, center + extent);
  }
  [[nodiscard]] PARRAY_INLINE Store half_area() const {
    const Vec4<Store> d = hi - lo;
    return d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
  }
};

/// Returns x, y and z of a shape's centre, and its radius.
template <typename Store, template <typename> class Item>
PARRAY_INLINE Vec4<Store> load(const Item<Store>& shape) {
  return Vec4<Store>::load(&shape.x);
}

/// Return half of the box around a shape; `values` are those of load().
template <typename Store>
PARRAY_INLINE Vec4<Store> extent_of(const BuildSphere<Store>&, const Vec4<Store>& values) {
  return Vec4<Store>(values[3]);
}
template <typename Store>
PARRAY_INLINE Vec4<Store> extent_of(const BuildCapsule<Store>& shape, const Vec4<Store>& values) {
  const auto size = [](Store x) { return x < Store(0) ? -x : x; };
  const Vec3<Store>& half = shape.half;
  return Vec4<Store>(values[3]) + Vec4<Store>{size(half.x), size(half.y), size(half.z), Store(0)};
}

/// Copies a shape; `values` are those of load().
template <typename Store>
PARRAY_INLINE void store(const Vec4<Store>& values, const BuildSphere<Store>& shape,
                         BuildSphere<Store>& to) {
  const std::uint32_t index = shape.index;
  values.store(&to.x);
  to.index = index;
}
template <typename Store>
PARRAY_INLINE void store(const Vec4<Store>&, const BuildCapsule<Store>& shape,
                         BuildCapsule<Store>& to) {
  to = shape;
}

template <typename Store, template <typename> class Item>
class Builder {
 public:
  using Shape = Item<Store>;

  Builder(std::span<Shape> shapes, std::uint32_t leaf_size, int threads)
      : shapes_(shapes), leaf_size_(leaf_size), threads_(threads) {
    // Most pages are never touched and thus never allocated.
    tree_.capacity = 2 * shapes.size();
    tree_.nodes = std::make_unique_for_overwrite<BinaryNode<Store>[]>(tree_.capacity);
    scratch_ = AlignedArray<Shape>(shapes.size());
  }

  BinaryTree<Store> run() {
#pragma omp parallel num_threads(threads_) if (threads_ > 1)
#pragma omp single
    {
      std::uint32_t next = 1;
      build(measured_side_by_side(), 0, next, 1);
    }
    return std::move(tree_);
  }

 private:
  struct Range {
    std::uint32_t begin;
    std::uint32_t end;
    WideBounds<Store> box{};
    WideBounds<Store> centers{};

    [[nodiscard]] std::uint32_t count() const { return end - begin; }
  };

  struct Bin {
    WideBounds<Store> box;
    std::uint32_t count = 0;
  };
  using Bins = std::array<Bin, bin_count>;

  /// A thread's part of a range, its bins along the range's longest axis, and its destination.
  struct Part {
    Range range{};
    Bins bins{};
    Range left{};
    Range right{};
  };
  using Parts = std::vector<Part>;

  /// The cut of a range: bins below `bin` of `axis` go left. axis < 0: no useful plane.
  struct Plane {
    int axis = -1;
    std::size_t bin = 0;
    Store cost = std::numeric_limits<Store>::infinity();
  };

  /// Maps centres to bins along an axis.
  struct Binning {
    explicit Binning(const Range& range) : lo(range.centers.lo) {
      const Vec4<Store> extent = range.centers.hi - range.centers.lo;
      std::array<Store, 3> each{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const Store bins = static_cast<Store>(bin_count) / extent[axis];
        useful[axis] = extent[axis] > Store(0) && bins < std::numeric_limits<Store>::infinity();
        each[axis] = useful[axis] ? bins : Store(0);
      }
      scale = {each[0], each[1], each[2], Store(0)};
      if (range.count() > one_axis_from) {
        longest = 0;
        for (std::size_t axis = 1; axis < 3; ++axis) {
          longest = extent[axis] > extent[longest] ? axis : longest;
        }
        for (std::size_t axis = 0; axis < 3; ++axis) useful[axis] = useful[axis] && axis == longest;
      }
    }
    static constexpr std::size_t none = 3;
    std::size_t longest = none;  ///< the only axis to examine; none: all three

    /// Returns the bins of a shape along x, y and z.
    [[nodiscard]] PARRAY_INLINE Vec4<Store> bins_of(const Vec4<Store>& sphere) const {
      constexpr auto last = static_cast<Store>(bin_count - 1);
      return min_of((sphere - lo) * scale, Vec4<Store>(last));
    }
    [[nodiscard]] PARRAY_INLINE static std::size_t bin_number(Store bin) {
      return static_cast<std::size_t>(static_cast<int>(bin));
    }

    Vec4<Store> lo;
    Vec4<Store> scale{Store(0)};
    std::array<bool, 3> useful{};
  };

  /// Fills node `node`. Nodes of a large range's subtree have fixed places, so that tasks need not
  /// agree on them: the range's node, then twice its left shapes less one, then the right ones. A
  /// small range's nodes follow each other from `next` on.
  void build(const Range& range, std::uint32_t node, std::uint32_t& next, std::uint32_t level) {
    BinaryNode<Store>& made = tree_.nodes[node];
    made = {narrow(range.box), range.begin, range.end, 0, 0};
    if (range.count() <= leaf_size_) return;
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

  static Bounds<Store> narrow(const WideBounds<Store>& box) {
    return {{box.lo[0], box.lo[1], box.lo[2]}, {box.hi[0], box.hi[1], box.hi[2]}};
  }

  /// Returns the number of block tests for a number of shapes.
  [[nodiscard]] Store blocks(std::uint32_t count) const {
    const std::uint32_t filled = (count + leaf_size_ - 1) / leaf_size_;
    return static_cast<Store>(filled);
  }

  void split(const Range& range, std::uint32_t level, Range& left, Range& right) {
    const Binning binning(range);
    std::array<Bins, 3> bins;
    Parts parts = parts_of(range);
    Plane best;
    if (level < halving_from) {
      fill(range, binning, parts, bins);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (binning.useful[axis]) sweep(bins[axis], static_cast<int>(axis), best);
      }
    }
    if (best.axis < 0) {  // coincident centres, or too deep
      halve(range, left, right);
      return;
    }
    const Bins& chosen = bins[static_cast<std::size_t>(best.axis)];
    const std::uint32_t middle = range.begin + left_count(chosen, best);
    left = {range.begin, middle};
    right = {middle, range.end};
    for (std::size_t b = 0; b < bin_count; ++b) {
      (b < best.bin ? left : right).box.include(chosen[b].box);
    }
    partition(range, binning, best, parts, left, right);
    if (shapes_.size() >= filled_from && range.count() <= filled_range) {
      fill_blocks(static_cast<std::size_t>(best.axis), left, right);
    }
  }

  /// Moves a cut if that saves a block. The shapes that one side has in excess of whole blocks,
  /// those nearest to the cut, move to the other side if its last block has room for them.
  void fill_blocks(std::size_t axis, Range& left, Range& right) {
    const std::uint32_t left_more = left.count() % leaf_size_;
    const std::uint32_t right_more = right.count() % leaf_size_;
    if (left_more == 0 || right_more == 0 || left_more + right_more > leaf_size_) return;
    const bool to_left =
        left.count() == left_more || (right.count() > right_more && right_more < left_more);
    const std::uint32_t middle = to_left ? left.end + right_more : left.end - left_more;
    const auto before = [axis](const Shape& a, const Shape& b) {
      return load(a)[axis] < load(b)[axis];
    };
    const Range& giving = to_left ? right : left;
    std::nth_element(shapes_.begin() + giving.begin, shapes_.begin() + middle,
                     shapes_.begin() + giving.end, before);
    left = measured(left.begin, middle);
    right = measured(middle, right.end);
  }

  /// Returns a range with the bounds of its shapes.
  [[nodiscard]] Range measured(std::uint32_t begin, std::uint32_t end) const {
    Range range{begin, end};
    for (std::uint32_t i = begin; i < end; ++i) {
      const Vec4<Store> values = load(shapes_[i]);
      range.box.include_shape(values, extent_of(shapes_[i], values));
      range.centers.include(values, values);
    }
    return range;
  }

  static std::uint32_t left_count(const Bins& bins, const Plane& plane) {
    std::uint32_t count = 0;
    for (std::size_t b = 0; b < plane.bin; ++b) count += bins[b].count;
    return count;
  }

  /// Moves the shapes of the left side to the front of a range. Both sides keep their order.
  /// Stores the bounds of both sides' centres in `left` and `right`.
  void partition(const Range& range, const Binning& binning, const Plane& plane, Parts& parts,
                 Range& left, Range& right) {
    if (parts.empty()) {
      deal(range, binning, plane, left.centers, right.centers);
      copy(scratch_.data() + range.begin, right.count(), shapes_.data() + right.begin);
      return;
    }
    std::uint32_t next_left = left.begin;
    std::uint32_t next_right = right.begin;
    for (Part& part : parts) {
      const std::uint32_t goes_left = left_count(part.bins, plane);
      part.left = {next_left, next_left + goes_left};
      next_left = part.left.end;
      part.right = {next_right, next_right + part.range.count() - goes_left};
      next_right = part.right.end;
    }
    side_by_side(parts, [&](Part& part) {
      deal(part.range, binning, plane, part.left.centers, part.right.centers);
      copy(shapes_.data() + part.range.begin, part.left.count(),
           scratch_.data() + part.range.begin + part.right.count());
    });
    side_by_side(parts, [&](Part& part) {
      const Shape* const rights = scratch_.data() + part.range.begin;
      copy(rights, part.right.count(), shapes_.data() + part.right.begin);
      copy(rights + part.right.count(), part.left.count(), shapes_.data() + part.left.begin);
    });
    for (const Part& part : parts) {
      left.centers.include(part.left.centers);
      right.centers.include(part.right.centers);
    }
  }

  static void copy(const Shape* from, std::uint32_t count, Shape* to) {
    std::copy(from, from + count, to);
  }

  /// Moves the shapes of the left side to the front of a range, and copies the others to the same
  /// place in scratch_. Computes the bounds of both sides' centres. Uses no branches, because sides
  /// are unpredictable.
  void deal(const Range& range, const Binning& binning, const Plane& plane, WideBounds<Store>& left,
            WideBounds<Store>& right) {
    const auto limit = static_cast<Store>(plane.bin);
    const auto axis = static_cast<std::size_t>(plane.axis);
    const WideBounds<Store> none;
    WideBounds<Store> lefts;
    WideBounds<Store> rights;
    std::uint32_t next_left = range.begin;
    std::uint32_t next_right = range.begin;
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      const Vec4<Store> values = load(shapes_[i]);
      const Store bin = binning.bins_of(values)[axis];
      lefts.include(select_below(bin, limit, values, none.lo),
                    select_below(bin, limit, values, none.hi));
      rights.include(select_below(bin, limit, none.lo, values),
                     select_below(bin, limit, none.hi, values));
      store(values, shapes_[i], shapes_[next_left]);
      store(values, shapes_[i], scratch_[next_right]);
      const std::uint32_t one = bin < limit ? 1 : 0;
      next_left += one;
      next_right += 1 - one;
    }
    left = lefts;
    right = rights;
  }

  void halve(const Range& range, Range& left, Range& right) const {
    const std::uint32_t blocks_left = (range.count() / 2 + leaf_size_ - 1) / leaf_size_;
    const std::uint32_t middle = range.begin + blocks_left * leaf_size_;
    left = measured(range.begin, middle);
    right = measured(middle, range.end);
  }

  /// Returns the parts of a range that all threads split together. Returns none if the range is at
  /// most one thread's share of all shapes.
  [[nodiscard]] Parts parts_of(const Range& range) const {
    const std::size_t share = shapes_.size() / static_cast<std::size_t>(std::max(threads_, 1));
    if (range.count() <= std::max<std::size_t>(task_size, share)) return {};
    const Bands bands(range.count(), threads_);
    Parts parts(bands.count());
    for (std::size_t i = 0; i < parts.size(); ++i) {
      parts[i].range = {range.begin + static_cast<std::uint32_t>(bands.begin(i)),
                        range.begin + static_cast<std::uint32_t>(bands.end(i))};
    }
    return parts;
  }

  /// Calls work(part) for all parts, as tasks.
  static void side_by_side(Parts& parts, const auto& work) {
    for (Part& part : parts) {
      Part* const mine = &part;
#pragma omp task default(none) shared(work) firstprivate(mine)
      work(*mine);
    }
#pragma omp taskwait
  }

  /// Returns the range of all shapes.
  [[nodiscard]] Range measured_side_by_side() const {
    Range all{0, static_cast<std::uint32_t>(shapes_.size())};
    Parts parts = parts_of(all);
    if (parts.empty()) return measured(all.begin, all.end);
    side_by_side(parts,
                 [&](Part& part) { part.range = measured(part.range.begin, part.range.end); });
    for (const Part& part : parts) {
      all.box.include(part.range.box);
      all.centers.include(part.range.centers);
    }
    return all;
  }

  void fill(const Range& range, const Binning& binning, Parts& parts,
            std::array<Bins, 3>& bins) const {
    if (binning.longest != Binning::none) {
      Bins& along = bins[binning.longest];
      if (parts.empty()) {
        fill_longest(range, binning, along);
        return;
      }
      side_by_side(parts, [&](Part& part) { fill_longest(part.range, binning, part.bins); });
      for (const Part& part : parts) {
        for (std::size_t b = 0; b < bin_count; ++b) {
          along[b].box.include(part.bins[b].box);
          along[b].count += part.bins[b].count;
        }
      }
      return;
    }
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      const Vec4<Store> values = load(shapes_[i]);
      const Vec4<Store> at = binning.bins_of(values);
      WideBounds<Store> box;
      box.include_shape(values, extent_of(shapes_[i], values));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        Bin& bin = bins[axis][Binning::bin_number(at[axis])];
        bin.box.include(box);
        ++bin.count;
      }
    }
  }

  void fill_longest(const Range& range, const Binning& binning, Bins& bins) const {
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      const Vec4<Store> values = load(shapes_[i]);
      const Vec4<Store> at = binning.bins_of(values);
      Bin& bin = bins[Binning::bin_number(at[binning.longest])];
      bin.box.include_shape(values, extent_of(shapes_[i], values));
      ++bin.count;
    }
  }

  /// Cost of each cut: area times block tests on both sides.
  void sweep(const Bins& bins, int axis, Plane& best) const {
    std::array<Store, bin_count> right_cost{};
    WideBounds<Store> box;
    std::uint32_t count = 0;
    for (std::size_t b = bin_count - 1; b > 0; --b) {
      box.include(bins[b].box);
      count += bins[b].count;
      right_cost[b] = count == 0 ? Store(0) : box.half_area() * blocks(count);
    }
    const std::uint32_t total = count + bins[0].count;
    box = {};
    count = 0;
    for (std::size_t b = 1; b < bin_count; ++b) {
      box.include(bins[b - 1].box);
      count += bins[b - 1].count;
      if (count == 0 || count == total) continue;
      const Store cost = box.half_area() * blocks(count) + right_cost[b];
      if (cost < best.cost) best = {axis, b, cost};
    }
  }

  std::span<Shape> shapes_;
  AlignedArray<Shape> scratch_;  ///< as many as the shapes
  std::uint32_t leaf_size_;
  int threads_;
  BinaryTree<Store> tree_;
};

}  // namespace

template <typename Store, template <typename> class Item>
BinaryTree<Store> build_binary_tree(std::span<Item<Store>> shapes, std::uint32_t leaf_size,
                                    int threads) {
  return Builder<Store, Item>(shapes, leaf_size, threads).run();
}

template BinaryTree<float> build_binary_tree(std::span<BuildSphere<float>>, std::uint32_t, int);
template BinaryTree<double> build_binary_tree(std::span<BuildSphere<double>>, std::uint32_t, int);
template BinaryTree<float> build_binary_tree(std::span<BuildCapsule<float>>, std::uint32_t, int);
template BinaryTree<double> build_binary_tree(std::span<BuildCapsule<double>>, std::uint32_t, int);

}  // namespace parray::trace
