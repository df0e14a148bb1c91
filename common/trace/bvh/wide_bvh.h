#pragma once

#include <cstdint>
#include <vector>

#include "common/base/aligned_array.h"
#include "common/base/bands.h"
#include "common/trace/bvh/bvh_view.h"
#include "common/trace/bvh/collapse.h"

namespace parray::trace {

/// The spheres of a scene in blocks of W, and a tree of W-wide nodes over the blocks.
///
/// Traversal gives the same bits as linear search: a ray may miss a box only if enters() misses
/// every sphere in it. enters() is exact to 6 ulp of max(radius, distance) [measured, Haines 2019].
/// So boxes grow by 32 unit roundoffs of their own coordinates here, and of the ray's origin during
/// traversal. That bounds the rounding in proportion to the rounded numbers.
///
/// Immutable after construction. Every ray tests the "open" spheres, which stand outside the tree.
/// Without a tree these are all spheres. With a tree they are the spheres so large that they would
/// be in every ray's way.
template <typename Store, int W>
class WideBvh {
 public:
  /// Takes any number of spheres below 2^26, even none. `tree` false: linear search. `threads`
  /// threads build; the result does not depend on their number.
  WideBvh(const std::vector<SphereShape<Store>>& shapes, bool tree, int threads)
      : WideBvh(
            shapes.size(), [&](std::size_t i) { return shapes[i]; }, tree, threads) {}
  /// Does the same with `count` spheres; all threads call shape_at(i) for them.
  template <typename ShapeAt>
  WideBvh(std::size_t count, const ShapeAt& shape_at, bool tree, int threads)
      : WideBvh(spheres_of(count, shape_at, threads), tree, threads) {}

  /// Returns a view of this object's tables.
  [[nodiscard]] BvhView<Store, W> view() const;
  [[nodiscard]] const SphereBlock<Store, W>* blocks() const { return blocks_.data(); }
  [[nodiscard]] const WideNode<Store, W>* nodes() const { return nodes_.data(); }
  /// Returns the input index of the sphere in a slot; no_sphere for a slot without one.
  [[nodiscard]] std::uint32_t input_index(std::uint32_t slot) const {
    const std::uint32_t index = labels().index(slot);
    return index == index_mask() ? no_sphere : index;
  }
  [[nodiscard]] SlotLabels labels() const { return {labels_.data(), index_mask()}; }
  /// Returns the number of highest bits of a label that are free for a tag.
  [[nodiscard]] int tag_bits() const { return 32 - index_bits_; }
  /// Sets the tag of a slot that has none to a number of tag_bits() bits.
  void set_tag(std::uint32_t slot, std::uint32_t tag) { labels_[slot] |= tag << index_bits_; }
  [[nodiscard]] std::uint32_t slot_count() const {
    return static_cast<std::uint32_t>(labels_.size());
  }
  [[nodiscard]] std::uint32_t open_spheres() const { return open_spheres_; }
  [[nodiscard]] std::uint32_t node_count() const {
    return static_cast<std::uint32_t>(nodes_.size());
  }
  /// Returns the number of stack entries that a ray needs: its most pending children, the end mark,
  /// and room for one more vector.
  [[nodiscard]] std::uint32_t stack_size() const { return 1 + depth_ * (W - 1) + 1 + W; }
  [[nodiscard]] std::uint32_t depth() const { return depth_; }
  [[nodiscard]] std::size_t bytes() const {
    return blocks_.bytes() + nodes_.bytes() + labels_.bytes();
  }

 private:
  using Spheres = AlignedArray<BuildSphere<Store>>;

  WideBvh(Spheres spheres, bool tree, int threads);
  template <typename ShapeAt>
  static Spheres spheres_of(std::size_t count, const ShapeAt& shape_at, int threads) {
    Spheres spheres(count);
    Bands(count, threads).run([&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const SphereShape<Store> shape = shape_at(i);
        spheres[i] = {shape.center.x, shape.center.y, shape.center.z, shape.radius,
                      static_cast<std::uint32_t>(i)};
      }
    });
    return spheres;
  }
  [[nodiscard]] std::uint32_t index_mask() const { return (1U << index_bits_) - 1; }
  /// Moves the spheres that stay outside the tree to the front and returns their number.
  static std::size_t move_giants(Spheres& spheres);
  void build(Spheres& spheres, std::size_t open, int threads);
  void fill_open_blocks(const Spheres& spheres);
  void fill_block(std::uint32_t index, const BuildSphere<Store>* spheres, std::uint32_t count);
  /// The next node and block to write, and the most levels written so far.
  struct Places {
    std::uint32_t node = 0;
    std::uint32_t block = 0;
    std::uint32_t depth = 0;
  };
  using Tree = BinaryTree<Store>;
  using Wide = Collapse<Store, W>;

  static void count(const Tree& tree, const Wide& wide, std::uint32_t below, Places& places);
  void emit(const Tree& tree, const Wide& wide, const BuildSphere<Store>* spheres, Places next,
            int threads);
  void emit(const Tree& tree, const Wide& wide, const BuildSphere<Store>* spheres,
            std::uint32_t below, std::uint32_t level, Places& next);
  void set_children(WideNode<Store, W>& node, const Tree& tree,
                    const typename Wide::Children& children);

  AlignedArray<SphereBlock<Store, W>> blocks_;
  AlignedArray<WideNode<Store, W>> nodes_;
  AlignedArray<std::uint32_t> labels_;  ///< see SlotLabels
  int index_bits_;                      ///< 1 .. 27
  std::uint32_t open_spheres_ = 0;
  std::uint32_t depth_ = 0;
  Store extent_ = 0;  ///< see BvhView
};

}  // namespace parray::trace
