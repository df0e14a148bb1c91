#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "common/base/arrays.h"
#include "common/image/pixel_sums.h"
#include "common/scene/scene.h"
#include "common/scene/setting_choices.h"
#include "common/scene/settings_fwd.h"
#include "common/trace/device/device_job.h"

/// The tables that kernels on a device (a GPU) read. The host fills them and copies them to the
/// device.
namespace parray::trace {

/// A scene in the form that kernels read: one block of memory without pointers. Many pictures can
/// share it. Immutable; any thread may read it. Refers to no memory of the scene.
class DeviceScene {
 public:
  /// `precision` is f32, mixed or f64; `kind` is linear or bvh. `threads` threads build the tree.
  DeviceScene(const Scene& scene, Precision precision, AcceleratorKind kind, int threads = 1);

  /// Returns the block. It is aligned to 64 bytes.
  [[nodiscard]] std::span<const std::byte> bytes() const { return {block_.data(), block_.size()}; }
  [[nodiscard]] Precision precision() const { return precision_; }
  [[nodiscard]] AcceleratorKind kind() const { return kind_; }
  /// Returns the origin of all positions: scene_origin() of the scene.
  [[nodiscard]] const Vec3d& origin() const { return origin_; }
  /// Returns whether kernels can trace the scene. If not, its tree is deeper than a kernel's stack,
  /// and the CPU has to trace it.
  [[nodiscard]] bool fits() const { return fits_; }
  /// Returns whether paths can be inside a shape because there is glass.
  [[nodiscard]] bool has_glass() const { return has_glass_; }

 private:
  Precision precision_;
  AcceleratorKind kind_;
  Vec3d origin_;
  bool fits_ = true;
  bool has_glass_ = false;
  AlignedArray<std::byte> block_;
};

/// The camera and settings of one picture of a DeviceScene: one block of memory without pointers.
/// Immutable; any thread may read it.
class DevicePicture {
 public:
  /// Positions are measured from scene.origin(): see make_path_tracer(). Takes the precision of
  /// `scene`, not that of `picture`.
  DevicePicture(const DeviceScene& scene, const Camera& camera, const PictureSettings& picture);

  /// Returns the block. It is aligned to 64 bytes.
  [[nodiscard]] std::span<const std::byte> bytes() const { return {block_.data(), block_.size()}; }
  /// Returns whether camera rays can begin inside a shape.
  [[nodiscard]] bool starts_inside() const { return starts_inside_; }

 private:
  bool starts_inside_ = false;
  AlignedArray<std::byte> block_;
};

/// Returns the name of the kernel (device_entry.h) that traces a picture. Its signature is
/// DeviceKernel.
std::string kernel_name(const DeviceScene& scene, const DevicePicture& picture);

/// Adds the result of an item that was not handed back to its pixel and to `counts`.
void add_result(const DeviceItem& item, const DeviceSums& result, PixelSums& pixel,
                TraceCounts& counts);

}  // namespace parray::trace
