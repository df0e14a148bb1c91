#pragma once

#include <cstdint>

#include "common/image/radiance_scale.h"
#include "common/trace/bvh/bvh_view.h"
#include "common/trace/integrator/camera_rays.h"
#include "common/trace/integrator/kernel_scene.h"
#include "common/trace/integrator/material.h"

/// The tables of DeviceScene and DevicePicture, as kernels see them: places in a block of memory,
/// and views of the block with the parameters of path.h.
namespace parray::trace {

inline constexpr int device_width = 4;  ///< children of a node, shapes of a block: see bvh_view.h
/// The most stack entries of a ray in a tree of a device: see DeviceScene::fits().
inline constexpr std::uint32_t device_stack = 96;
/// The most shapes that a path can be inside of in kernels that have a stack for them.
inline constexpr std::uint32_t device_nest = 8;

/// A table in a block.
struct TablePlace {
  std::uint64_t begin = 0;  ///< bytes from the beginning of the block
  std::uint64_t count = 0;  ///< number of elements
};

/// Returns the first element of a table.
template <typename T>
const T* table_at(const void* block, const TablePlace& place) {
  return reinterpret_cast<const T*>(static_cast<const char*>(block) + place.begin);
}

/// A tree in a block: see BvhView.
template <typename Store>
struct TreePlace {
  TablePlace nodes, blocks, labels;
  std::uint32_t index_mask = 0;
  std::uint32_t open_spheres = 0;
};

/// The beginning of the block of a DeviceScene. The shapes are in input order.
template <typename Real, typename Store>
struct DeviceSceneHead {
  SkyGradient<Real> sky;
  RadianceScale scale;
  TablePlace spheres, capsules;                ///< SphereShape<Store>, CapsuleShape<Store>
  TablePlace material_of;                      ///< material of each shape
  TablePlace surfaces;                         ///< MaterialParameters<Real>
  TreePlace<Store> sphere_tree, capsule_tree;  ///< empty with linear search
};

/// The beginning of the block of a DevicePicture.
template <typename Real>
struct DevicePictureHead {
  CameraRays<Real> view;
  std::uint64_t seed;
  std::uint32_t width;
  std::uint32_t max_depth;
  TablePlace start_numbers, start_begins;  ///< see StartTable; empty: none
  std::uint32_t start_bits;
  std::uint32_t start_across;
  Sampler sampler;
};

/// A table of shapes, of type `Stored`, that converts each shape read to the type of paths, `Real`.
template <typename Real, typename Stored>
class StoredShapes {
 public:
  StoredShapes(const void* block, const TablePlace& place)
      : at_(table_at<Stored>(block, place)), size_(static_cast<std::uint32_t>(place.count)) {}

  [[nodiscard]] std::uint32_t size() const { return size_; }
  [[nodiscard]] auto operator[](std::uint32_t i) const { return shape_cast<Real>(at_[i]); }

 private:
  const Stored* at_;
  std::uint32_t size_;
};

/// A PathScene in the block of a DeviceScene.
template <typename Real, typename Store>
struct DeviceSceneView {
  explicit DeviceSceneView(const void* block) : DeviceSceneView(block, head_of(block)) {}

  static const DeviceSceneHead<Real, Store>& head_of(const void* block) {
    return *static_cast<const DeviceSceneHead<Real, Store>*>(block);
  }

  StoredShapes<Real, SphereShape<Store>> spheres;
  StoredShapes<Real, CapsuleShape<Store>> capsules;
  const std::uint32_t* material_of;
  const MaterialParameters<Real>* surfaces;
  const SkyGradient<Real>& sky;

 private:
  DeviceSceneView(const void* block, const DeviceSceneHead<Real, Store>& head)
      : spheres(block, head.spheres),
        capsules(block, head.capsules),
        material_of(table_at<std::uint32_t>(block, head.material_of)),
        surfaces(table_at<MaterialParameters<Real>>(block, head.surfaces)),
        sky(head.sky) {}
};

/// Returns the view of a tree.
template <template <typename, int> class Block, typename Store>
BvhView<Store, device_width, Block> tree_view(const void* block, const TreePlace<Store>& place) {
  BvhView<Store, device_width, Block> view;
  view.nodes = table_at<WideNode<Store, device_width>>(block, place.nodes);
  view.blocks = table_at<Block<Store, device_width>>(block, place.blocks);
  view.labels = {table_at<std::uint32_t>(block, place.labels), place.index_mask};
  view.node_count = static_cast<std::uint32_t>(place.nodes.count);
  view.open_spheres = place.open_spheres;
  return view;
}

/// Numbers in a table.
struct NumberRange {
  const std::uint32_t* first;
  const std::uint32_t* last;

  [[nodiscard]] const std::uint32_t* begin() const { return first; }
  [[nodiscard]] const std::uint32_t* end() const { return last; }
};

/// The shapes that paths may begin inside of: see StartShapes.
struct DeviceStarts {
  StartTable table;

  [[nodiscard]] NumberRange of(std::uint32_t x, std::uint32_t y) const {
    if (table.numbers == nullptr) return {nullptr, nullptr};
    const std::uint32_t tile = table.tile(x, y);
    return {table.numbers + table.begins[tile], table.numbers + table.begins[tile + 1]};
  }
};

/// The camera and the ends of paths in the block of a DevicePicture: see PathEnds.
template <typename Real>
struct DevicePictureView {
  explicit DevicePictureView(const void* block)
      : DevicePictureView(block, *static_cast<const DevicePictureHead<Real>*>(block)) {}

  const DevicePictureHead<Real>& head;
  const CameraRays<Real>& view;
  DeviceStarts start;
  std::uint32_t max_depth;

 private:
  DevicePictureView(const void* block, const DevicePictureHead<Real>& h)
      : head(h), view(h.view), max_depth(h.max_depth) {
    if (h.start_numbers.count > 0) {
      start.table = {table_at<std::uint32_t>(block, h.start_numbers),
                     table_at<std::uint32_t>(block, h.start_begins), h.start_bits, h.start_across};
    }
  }
};

}  // namespace parray::trace
