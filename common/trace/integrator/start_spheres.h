#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/scene/scene.h"
#include "common/trace/integrator/camera_rays.h"
#include "common/trace/integrator/kernel_scene.h"
#include "common/trace/sphere.h"

/// Which spheres a path may begin inside of. Each sample decides for itself, by the numbers that
/// the spheres are stored as; here are those that it has to ask.
namespace parray::trace {

/// Pixels, both ends included.
struct PixelBox {
  std::uint32_t left = 0;
  std::uint32_t right = 0;
  std::uint32_t top = 0;
  std::uint32_t bottom = 0;
};

/// Where the camera rays of a picture begin: on the lens, or, of an orthographic camera, on its
/// film and the lenses around the film's points (see CameraRays).
class RayStarts {
 public:
  /// `camera` is relative to the origin, as the spheres are; width and height are in pixels.
  RayStarts(const Camera& camera, std::uint32_t width, std::uint32_t height);

  /// The pixels whose rays may begin inside a sphere, and perhaps some around; none for the NaN
  /// that stand for no sphere. A sphere that an orthographic camera's plane cuts holds the rays of
  /// the pixels that show the cut: they see its inside.
  template <typename Store>
  [[nodiscard]] std::optional<PixelBox> inside(const SphereShape<Store>& sphere) const {
    const Vec3d center = vec_cast<double>(sphere.center);
    // Above the single-precision rounding of what is compared later: a candidate costs little.
    const double slack = 16.0 * RealTraits<float>::unit_roundoff * (far_ + length(center));
    const double radius = static_cast<double>(sphere.radius) + slack;
    if (!(length(center - eye_) - reach_ < radius)) return {};
    return box(center - eye_, radius);
  }
  [[nodiscard]] std::uint32_t width() const { return width_; }
  [[nodiscard]] std::uint32_t height() const { return height_; }

 private:
  /// Of a sphere that is near enough; `to_center` from the eye.
  [[nodiscard]] std::optional<PixelBox> box(const Vec3d& to_center, double radius) const;

  CameraAxes axes_;
  Vec3d eye_;
  double lens_;
  double reach_;  ///< of all rays' starts, from the eye
  double far_;    ///< and from the spheres' origin
  bool parallel_;
  double pixels_per_length_;
  std::uint32_t width_, height_;
};

/// Numbers of the spheres that the paths of a part of the picture may begin inside of, part by
/// part. A perspective camera has one part; an orthographic camera, whose plane may cut very many
/// spheres, square tiles. Memory is in proportion to the spheres.
class StartSpheres {
 public:
  /// None.
  StartSpheres() : StartSpheres(std::vector<std::uint32_t>{}) {}
  /// These, wherever a path begins.
  explicit StartSpheres(std::vector<std::uint32_t> everywhere);
  /// Those of the numbers 0 .. count - 1 for which `sphere_at(number)` holds a ray's start.
  template <typename SphereAt>
  StartSpheres(const RayStarts& starts, std::uint32_t count, const SphereAt& sphere_at) {
    std::vector<Candidate> candidates;
    for (std::uint32_t number = 0; number < count; ++number) {
      const auto box = starts.inside(sphere_at(number));
      if (box) candidates.push_back({number, *box});
    }
    sort_into_tiles(candidates, starts.width(), starts.height());
  }

  [[nodiscard]] bool empty() const { return numbers_.empty(); }
  /// Of the paths of a pixel, ascending.
  [[nodiscard]] std::span<const std::uint32_t> of(std::uint32_t x, std::uint32_t y) const {
    const std::uint32_t tile = tiles_.tile(x, y);
    return std::span(numbers_).subspan(begins_[tile], begins_[tile + 1] - begins_[tile]);
  }
  /// For the kernels; refers to this. Null where it is empty.
  [[nodiscard]] StartTable table() const;

 private:
  struct Candidate {
    std::uint32_t number;
    PixelBox box;
  };
  void sort_into_tiles(std::span<const Candidate> candidates, std::uint32_t width,
                       std::uint32_t height);

  StartTable tiles_;  ///< without the tables
  std::vector<std::uint32_t> begins_;
  std::vector<std::uint32_t> numbers_;
};

}  // namespace parray::trace
