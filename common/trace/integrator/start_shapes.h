#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/scene/scene.h"
#include "common/trace/capsule.h"
#include "common/trace/integrator/camera_rays.h"
#include "common/trace/integrator/kernel_scene.h"

/// Finds the shapes that a path may begin inside of. Each sample tests, with the stored numbers of
/// the shapes, whether its own ray starts inside one. This file finds the shapes that a sample must
/// test.
namespace parray::trace {

/// A box of pixels, both ends included.
struct PixelBox {
  std::uint32_t left = 0;
  std::uint32_t right = 0;
  std::uint32_t top = 0;
  std::uint32_t bottom = 0;
};

/// The points where the camera rays of a picture begin. They lie on the lens. With an orthographic
/// camera they lie on its film and on the lenses around the film's points (see CameraRays).
class RayStarts {
 public:
  /// `camera` must be relative to the origin, like the shapes; width and height are in pixels.
  RayStarts(const Camera& camera, std::uint32_t width, std::uint32_t height);

  /// Returns a box with the pixels that have rays beginning inside a sphere, and perhaps with some
  /// others. Returns nothing if no ray does, or if a number of the sphere is NaN, which stands for
  /// no shape. The plane of an orthographic camera may cut a sphere. Then the rays of the pixels
  /// that show the cut begin inside: they see its inside.
  template <typename Store>
  [[nodiscard]] std::optional<PixelBox> inside(const SphereShape<Store>& sphere) const {
    const Vec3d center = vec_cast<double>(sphere.center);
    // More than the single-precision rounding in later comparisons: a candidate costs little.
    const double slack = 16.0 * RealTraits<float>::unit_roundoff * (far_ + length(center));
    const double radius = static_cast<double>(sphere.radius) + slack;
    if (!(length(center - eye_) - reach_ < radius)) return {};
    return box(center - eye_, radius);
  }
  /// Does the same for a capsule.
  template <typename Store>
  [[nodiscard]] std::optional<PixelBox> inside(const CapsuleShape<Store>& capsule) const {
    const Vec3d middle = vec_cast<double>(capsule.middle);
    const Vec3d half = vec_cast<double>(capsule.half);
    const double size = length(half);
    const double slack = 16.0 * RealTraits<float>::unit_roundoff * (far_ + length(middle) + size);
    const double radius = static_cast<double>(capsule.radius) + slack;
    const Vec3d nearest = middle + nearest_in_segment(half, eye_ - middle);
    if (!(length(nearest - eye_) - reach_ < radius)) return {};
    return box(middle - eye_, size + radius);
  }
  [[nodiscard]] std::uint32_t width() const { return width_; }
  [[nodiscard]] std::uint32_t height() const { return height_; }

 private:
  /// Returns the box of a sphere that is near enough; `to_center` starts at the eye.
  [[nodiscard]] std::optional<PixelBox> box(const Vec3d& to_center, double radius) const;

  CameraAxes axes_;
  Vec3d eye_;
  double lens_;
  double reach_;  ///< largest distance of a ray's start from the eye
  double far_;    ///< largest distance of a ray's start from the shapes' origin
  bool parallel_;
  double pixels_per_length_;
  std::uint32_t width_, height_;
};

/// The numbers of the shapes that the paths of a tile (a part of the picture) may begin inside of,
/// tile by tile. With a perspective camera the picture is one tile. With an orthographic camera it
/// has square tiles, because the camera's plane may cut very many shapes. Memory is proportional to
/// the number of shapes. The caller decides what the numbers are: of the scene, or slots.
class StartShapes {
 public:
  /// Makes an empty object.
  StartShapes() = default;
  /// Selects the numbers in 0 .. count - 1 of the shapes for which `box_of(number)` returns a box.
  /// It must return RayStarts::inside() of the shape.
  StartShapes(const RayStarts& starts, std::uint32_t count, const auto& box_of) {
    std::vector<Candidate> candidates;
    for (std::uint32_t number = 0; number < count; ++number) {
      const std::optional<PixelBox> box = box_of(number);
      if (box) candidates.push_back({number, *box});
    }
    sort_into_tiles(candidates, starts.width(), starts.height());
  }

  [[nodiscard]] bool empty() const { return numbers_.empty(); }
  /// Returns the numbers for the paths of a pixel, ascending.
  [[nodiscard]] std::span<const std::uint32_t> of(std::uint32_t x, std::uint32_t y) const {
    const std::uint32_t tile = tiles_.tile(x, y);
    return std::span(numbers_).subspan(begins_[tile], begins_[tile + 1] - begins_[tile]);
  }
  /// Returns the table for the kernels, which refers to this object. Its pointers are null if this
  /// object is empty.
  [[nodiscard]] StartTable table() const;
  [[nodiscard]] std::size_t tile_count() const { return begins_.size() - 1; }

 private:
  struct Candidate {
    std::uint32_t number;
    PixelBox box;
  };
  void sort_into_tiles(std::span<const Candidate> candidates, std::uint32_t width,
                       std::uint32_t height);

  StartTable tiles_{.bits = 31};  ///< without the tables; by default one tile covers any picture
  std::vector<std::uint32_t> begins_{0, 0};
  std::vector<std::uint32_t> numbers_;
};

}  // namespace parray::trace
