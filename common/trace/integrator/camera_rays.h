#pragma once

#include <cstdint>

#include "common/math/directions.h"
#include "common/scene/scene.h"
#include "common/trace/integrator/random.h"
#include "common/trace/ray.h"

namespace parray {

/// The camera as the kernel uses it: film vectors for a focus distance of 1, so that directions
/// stay near unit length whatever the scene's scale.
template <typename Real>
class CameraRays {
 public:
  /// `camera` has passed the reader's checks; width and height are in pixels.
  CameraRays(const Camera& camera, std::uint32_t width, std::uint32_t height)
      : inverse_width_(Real(1) / static_cast<Real>(width)),
        inverse_height_(Real(1) / static_cast<Real>(height)) {
    const Vec3d back = normalize(camera.look_from - camera.look_at);
    const Vec3d right = normalize(cross(normalize(camera.up), back));
    const Vec3d up = cross(back, right);
    const double film_height = 2 * camera.tan_half_vfov;
    const double film_width = film_height * (static_cast<double>(width) / height);
    const double lens = camera.aperture / 2;
    origin_ = vec_cast<Real>(camera.look_from);
    film_right_ = vec_cast<Real>(film_width * right);
    film_down_ = vec_cast<Real>(-film_height * up);
    film_corner_ = vec_cast<Real>((-0.5 * film_width) * right + (0.5 * film_height) * up - back);
    lens_right_ = vec_cast<Real>(lens * right);
    lens_up_ = vec_cast<Real>(lens * up);
    inverse_focus_ = static_cast<Real>(1 / camera.focus_distance);
    pinhole_ = !(camera.aperture > 0);
  }

  /// Ray of one sample, or of lanes of samples, through pixel (x, y), y downwards. `L` is Real or
  /// lanes of it.
  template <typename L, typename Uint>
  [[nodiscard]] PARRAY_INLINE Ray<L> ray(const Uint& x, const Uint& y,
                                         const RandomAddress<Uint>& random) const {
    const auto u = random.template at<L>(0, Purpose::camera);
    const L film_x = (real_from<L>(x) + u.a) * L(inverse_width_);
    const L film_y = (real_from<L>(y) + u.b) * L(inverse_height_);
    const Vec3<L> direction = vec_cast<L>(film_corner_) + film_x * vec_cast<L>(film_right_) +
                              film_y * vec_cast<L>(film_down_);
    if (pinhole_) {
      return {vec_cast<L>(origin_), normalize(direction)};
    }
    const Disc<L> point = uniform_disc(u.c, u.d);
    const Vec3<L> offset = point.x * vec_cast<L>(lens_right_) + point.y * vec_cast<L>(lens_up_);
    return {vec_cast<L>(origin_) + offset, normalize(direction - L(inverse_focus_) * offset)};
  }

 private:
  Vec3<Real> origin_, film_corner_, film_right_, film_down_, lens_right_, lens_up_;
  Real inverse_width_, inverse_height_;
  Real inverse_focus_ = 0;
  bool pinhole_ = true;
};

/// Sky as the kernel uses it.
template <typename Real>
struct SkyGradient {
  explicit SkyGradient(const Sky& sky)
      : horizon(vec_cast<Real>(sky.horizon)), rise(vec_cast<Real>(sky.zenith - sky.horizon)) {}

  /// Radiance along a unit direction with this y. horizon + h (zenith - horizon) is exact where
  /// both are equal. A direction that is not a number gives a radiance that is none either: the
  /// bounds come first in min_of and max_of, so that the sample is counted and not shown as sky.
  template <typename L>
  [[nodiscard]] PARRAY_INLINE Vec3<L> radiance(const L& direction_y) const {
    const L h = min_of(L(1), max_of(L(0), (direction_y + L(1)) * L(0.5)));
    return vec_cast<L>(horizon) + h * vec_cast<L>(rise);
  }

  Vec3<Real> horizon;
  Vec3<Real> rise;
};

}  // namespace parray
