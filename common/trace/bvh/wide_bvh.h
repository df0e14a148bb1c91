#pragma once

#include <cstdint>
#include <type_traits>
#include <vector>

#include "common/base/arrays.h"
#include "common/base/bands.h"
#include "common/trace/bvh/bvh_view.h"
#include "common/trace/bvh/sah_builder.h"

namespace parray::trace {

/// Converts a stored shape to the form that the builder takes.
template <typename Store>
BuildSphere<Store> build_item(const SphereShape<Store>& shape, std::uint32_t index) {
  return {shape.center.x, shape.center.y, shape.center.z, shape.radius, index};
}
template <typename Store>
BuildCapsule<Store> build_item(const CapsuleShape<Store>& shape, std::uint32_t index) {
  return {shape.middle.x, shape.middle.y, shape.middle.z, shape.radius, shape.half, index};
}

/// The type of a block's shapes in the builder.
template <template <typename, int> class Block, typename Store>
using BuildItem = std::conditional_t<std::is_same_v<Block<Store, 4>, SphereBlock<Store, 4>>,
                                     BuildSphere<Store>, BuildCapsule<Store>>;

/// The spheres, or the capsules, of a scene in blocks of W, and a tree of W-wide nodes over the
/// blocks.
///
/// Traversal gives the same bits as linear search: a ray may miss a box only if enters() misses
/// every shape in it. enters() is exact to 6 ulp of max(radius, distance) for spheres [measured,
/// Haines 2019], to 11 roundoffs for capsules (see capsule.h). So boxes grow by 32 unit roundoffs
/// of their own coordinates here, and of the ray's origin during traversal. That bounds the
/// rounding in proportion to the rounded numbers.
///
/// Only set_tag() changes it after construction. Threads may tag different slots at the same time.
/// Every ray tests the "open" spheres, which stand outside the tree. Without a tree these are all
/// spheres. With a tree they are the spheres of more than 32 times the median radius, which would
/// be in every ray's way. If these are more than W, no sphere is open. Capsules are always in a
/// tree, however few they are.
template <typename Store, int W, template <typename, int> class Block = SphereBlock>
class WideBvh {
 public:
  using Item = BuildItem<Block, Store>;

  /// Takes up to limits::max_shapes shapes, even none. `tree` false: linear search of spheres.
  /// Spheres that fit one block need no tree either. Capsules ignore `tree`. `threads` threads
  /// build; the result does not depend on their number.
  template <typename Shape>
  WideBvh(const std::vector<Shape>& shapes, bool tree, int threads)
      : WideBvh(
            shapes.size(), [&](std::size_t i) { return shapes[i]; }, tree, threads) {}
  /// Does the same with `count` shapes: shape_at(i) returns the one with input index i. Several
  /// threads call it at the same time.
  WideBvh(std::size_t count, const auto& shape_at, bool tree, int threads)
      : WideBvh(items_of(count, shape_at, threads), tree, threads) {}

  /// Returns a view of this object's tables.
  [[nodiscard]] BvhView<Store, W, Block> view() const;
  [[nodiscard]] const Block<Store, W>* blocks() const { return blocks_.data(); }
  [[nodiscard]] const WideNode<Store, W>* nodes() const { return nodes_.data(); }
  /// Returns the input index of the shape in a slot; no_shape for a slot without one.
  [[nodiscard]] std::uint32_t input_index(std::uint32_t slot) const {
    const std::uint32_t index = labels().index(slot);
    return index == index_mask() ? no_shape : index;
  }
  [[nodiscard]] SlotLabels labels() const { return {labels_.data(), index_mask()}; }
  /// Returns the number of highest bits of a label that are free for a tag.
  [[nodiscard]] int tag_bits() const { return 32 - index_bits_; }
  /// Sets the tag of a slot that has none to a number of tag_bits() bits.
  void set_tag(std::uint32_t slot, std::uint32_t tag) { labels_[slot] |= tag << index_bits_; }
  /// Returns the number of slots, including empty ones.
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
  /// Returns the number of nodes on the longest path from the root; 0: there is no tree.
  [[nodiscard]] std::uint32_t depth() const { return depth_; }
  [[nodiscard]] std::size_t bytes() const {
    return blocks_.bytes() + nodes_.bytes() + labels_.bytes();
  }

 private:
  using Items = AlignedArray<Item>;
  class Builder;

  WideBvh(Items items, bool tree, int threads);
  static Items items_of(std::size_t count, const auto& shape_at, int threads) {
    Items items(count);
    Bands(count, threads).run([&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        items[i] = build_item<Store>(shape_at(i), static_cast<std::uint32_t>(i));
      }
    });
    return items;
  }
  [[nodiscard]] std::uint32_t index_mask() const { return (1U << index_bits_) - 1; }

  AlignedArray<Block<Store, W>> blocks_;
  AlignedArray<WideNode<Store, W>> nodes_;
  AlignedArray<std::uint32_t> labels_;  ///< see SlotLabels
  int index_bits_;                      ///< 1 .. 27
  std::uint32_t open_spheres_ = 0;
  std::uint32_t depth_ = 0;
  Store extent_ = 0;  ///< see BvhView
};

}  // namespace parray::trace
