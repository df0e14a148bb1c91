#include "common/trace/device/device_tables.h"

#include <cstring>
#include <utility>
#include <vector>

#include "common/scene/largest_radiance.h"
#include "common/scene/origin.h"
#include "common/scene/picture_settings.h"
#include "common/trace/bvh/wide_bvh.h"
#include "common/trace/device/device_view.h"
#include "common/trace/integrator/path.h"
#include "common/trace/integrator/scene_parts.h"
#include "common/trace/integrator/start_shapes.h"

namespace parray::trace {
namespace {

/// Collects tables, and copies them into one block behind its head. The tables must live until
/// then.
class BlockWriter {
 public:
  explicit BlockWriter(std::size_t head_bytes) : size_(aligned(head_bytes)) {}

  template <typename T>
  TablePlace add(const T* table, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    parts_.push_back({table, size_, count * sizeof(T)});
    const TablePlace place{size_, count};
    size_ += aligned(count * sizeof(T));
    return place;
  }
  template <typename T>
  TablePlace add(const std::vector<T>& table) {
    return add(table.data(), table.size());
  }
  template <typename Store, template <typename, int> class Block>
  TreePlace<Store> add(const WideBvh<Store, device_width, Block>& tree) {
    TreePlace<Store> place;
    place.nodes = add(tree.nodes(), tree.node_count());
    place.blocks = add(tree.blocks(), tree.slot_count() / device_width);
    place.labels = add(tree.labels().at, tree.slot_count());
    place.index_mask = tree.labels().index_mask;
    place.open_spheres = tree.open_spheres();
    return place;
  }

  template <typename Head>
  [[nodiscard]] AlignedArray<std::byte> write(const Head& head) const {
    static_assert(std::is_trivially_copyable_v<Head>);
    AlignedArray<std::byte> block(size_);
    std::memset(block.data(), 0, block.size());
    std::memcpy(block.data(), &head, sizeof head);
    for (const Part& part : parts_) {
      if (part.bytes > 0) std::memcpy(block.data() + part.begin, part.table, part.bytes);
    }
    return block;
  }

 private:
  struct Part {
    const void* table;
    std::size_t begin, bytes;
  };
  static std::size_t aligned(std::size_t bytes) { return (bytes + 63) / 64 * 64; }

  std::vector<Part> parts_;
  std::size_t size_;
};

/// Returns whether the pending children of a ray fit the stack of a kernel.
bool fits_stack(const auto& tree) { return tree.depth() * (device_width - 1) + 1 <= device_stack; }

template <typename Store, typename Shape>
auto stored_shapes(const std::vector<Shape>& shapes, const Vec3d& origin) {
  std::vector<decltype(stored_shape<Store>(shapes[0], origin))> stored;
  stored.reserve(shapes.size());
  for (const Shape& shape : shapes) stored.push_back(stored_shape<Store>(shape, origin));
  return stored;
}

/// Returns the block of a scene. Sets `fits`.
template <typename Real, typename Store>
AlignedArray<std::byte> scene_block(const Scene& scene, const Vec3d& origin, bool tree, int threads,
                                    bool& fits) {
  const auto spheres = stored_shapes<Store>(scene.spheres, origin);
  const auto capsules = stored_shapes<Store>(scene.capsules, origin);
  std::vector<std::uint32_t> material_of;
  for (const Sphere& sphere : scene.spheres) material_of.push_back(sphere.material);
  for (const Capsule& capsule : scene.capsules) material_of.push_back(capsule.material);
  const auto surfaces = stored_materials<Real>(scene);

  using Head = DeviceSceneHead<Real, Store>;
  BlockWriter writer(sizeof(Head));
  Head head{
      SkyGradient<Real>(scene.sky), RadianceScale(largest_radiance(scene)), {}, {}, {}, {}, {}, {}};
  head.spheres = writer.add(spheres);
  head.capsules = writer.add(capsules);
  head.material_of = writer.add(material_of);
  head.surfaces = writer.add(surfaces);
  if (!tree) return writer.write(head);
  const WideBvh<Store, device_width> sphere_tree(spheres, true, threads);
  head.sphere_tree = writer.add(sphere_tree);
  fits = fits_stack(sphere_tree);
  if (capsules.empty()) return writer.write(head);
  const WideBvh<Store, device_width, CapsuleBlock> capsule_tree(capsules, true, threads);
  head.capsule_tree = writer.add(capsule_tree);
  fits = fits && fits_stack(capsule_tree);
  return writer.write(head);
}

/// Returns the block of a picture. Sets `starts_inside`.
template <typename Real, typename Store>
AlignedArray<std::byte> picture_block(const DeviceScene& scene, const Camera& camera,
                                      const PictureSettings& picture, bool& starts_inside) {
  const DeviceSceneView<Real, Store> shapes(scene.bytes().data());
  const RayStarts starts(camera, picture.width, picture.height);
  const StartShapes start(
      starts, shapes.spheres.size() + shapes.capsules.size(), [&](std::uint32_t number) {
        return at_shape(shapes, number, [&](const auto& shape) { return starts.inside(shape); });
      });
  starts_inside = !start.empty();
  const StartTable table = start.table();

  using Head = DevicePictureHead<Real>;
  BlockWriter writer(sizeof(Head));
  Head head{CameraRays<Real>(camera, picture.width, picture.height),
            picture.seed,
            picture.width,
            picture.max_depth,
            {},
            {},
            table.bits,
            table.across,
            picture.sampler};
  if (starts_inside) {
    const std::size_t tiles = start.tile_count();
    head.start_numbers = writer.add(table.numbers, table.begins[tiles]);
    head.start_begins = writer.add(table.begins, tiles + 1);
  }
  return writer.write(head);
}

}  // namespace

DeviceScene::DeviceScene(const Scene& scene, Precision precision, AcceleratorKind kind, int threads)
    : precision_(precision), kind_(kind), origin_(scene_origin(scene, threads)) {
  for (const Material& material : scene.materials) {
    has_glass_ = has_glass_ || material.type == MaterialType::dielectric;
  }
  block_ = with_types(precision, [&]<typename Real, typename Store>() {
    return scene_block<Real, Store>(scene, origin_, kind == AcceleratorKind::bvh, threads, fits_);
  });
}

DevicePicture::DevicePicture(const DeviceScene& scene, const Camera& camera,
                             const PictureSettings& picture) {
  block_ = with_types(scene.precision(), [&]<typename Real, typename Store>() {
    return picture_block<Real, Store>(scene, moved(camera, scene.origin()), picture,
                                      starts_inside_);
  });
}

std::string kernel_name(const DeviceScene& scene, const DevicePicture& picture) {
  const bool nests = scene.has_glass() || picture.starts_inside();
  return "trace_" + std::string(name_of(scene.precision())) + "_" +
         std::string(name_of(scene.kind())) + "_" + std::to_string(nests ? device_nest : 0);
}

void add_result(const DeviceItem& item, const DeviceSums& result, PixelSums& pixel,
                TraceCounts& counts) {
  for (std::size_t channel = 0; channel < 3; ++channel) {
    pixel.sum[channel] += result.sum[channel];
    pixel.sum_of_squares[channel] += result.sum_of_squares[channel];
    pixel.odd[channel] += result.odd[channel];
  }
  counts.samples += item.end - item.begin;
  counts.rays += result.rays;
  counts.lost += result.lost;
  counts.nonfinite += result.nonfinite;
}

}  // namespace parray::trace
