#pragma once

#include <cstdint>

#include "common/math/directions.h"
#include "common/scene/scene.h"
#include "common/trace/integrator/random.h"
#include "common/trace/ray.h"

namespace parray::trace {

/// Unit vectors along the picture's sides, and back towards whoever looks at it.
struct CameraAxes {
  explicit CameraAxes(const Camera& camera)
      : back(normalize(camera.look_from - camera.look_at)),
        right(normalize(cross(normalize(camera.up), back))),
        up(cross(back, right)) {}

  Vec3d back, right, up;
};

/// The camera as the kernel uses it.
///
/// Perspective: film vectors for a focus distance of 1, so that directions stay near unit length
/// whatever the scene's scale. Rays begin at look_from, or on a lens around it, and go through the
/// points of the film, which stand for those at focus_distance.
///
/// Orthographic: the film is a rectangle around look_from, view_height high, in the plane across
/// the view. Rays begin on it and go straight ahead. With a lens every point of the film is the
/// middle of one: rays begin anywhere on its disc, in the same plane, and meet straight ahead of
/// that middle at focus_distance, where things are sharp; elsewhere they are as blurred as those
/// that a perspective camera sees at the same distance (what is called a telecentric lens).
template <typename Real>
class CameraRays {
 public:
  /// `camera` has passed the reader's checks; width and height are in pixels.
  CameraRays(const Camera& camera, std::uint32_t width, std::uint32_t height)
      : inverse_width_(Real(1) / static_cast<Real>(width)),
        inverse_height_(Real(1) / static_cast<Real>(height)) {
    const bool parallel = camera.projection == Projection::orthographic;
    const CameraAxes axes(camera);
    const double film_height = parallel ? camera.view_height : 2 * camera.tan_half_vfov;
    const double film_width = film_height * (static_cast<double>(width) / height);
    const Vec3d corner = (-0.5 * film_width) * axes.right + (0.5 * film_height) * axes.up;
    const double lens = camera.aperture / 2;
    eye_ = vec_cast<Real>(camera.look_from);
    ahead_ = vec_cast<Real>(-axes.back);
    film_right_ = vec_cast<Real>(film_width * axes.right);
    film_down_ = vec_cast<Real>(-film_height * axes.up);
    film_corner_ = vec_cast<Real>(parallel ? camera.look_from + corner : corner - axes.back);
    lens_right_ = vec_cast<Real>(lens * axes.right);
    lens_up_ = vec_cast<Real>(lens * axes.up);
    inverse_focus_ = static_cast<Real>(1 / camera.focus_distance);
    const bool pinhole = !(camera.aperture > 0);
    kind_ = parallel ? (pinhole ? Kind::parallel : Kind::parallel_lens)
                     : (pinhole ? Kind::pinhole : Kind::lens);
  }

  /// Ray of one sample, or of lanes of samples, through pixel (x, y), y downwards. `L` is Real or
  /// lanes of it.
  template <typename L, typename Uint>
  [[nodiscard]] PARRAY_INLINE Ray<L> ray(const Uint& x, const Uint& y,
                                         const RandomAddress<Uint>& random) const {
    const auto u = random.template at<L>(0, Purpose::camera);
    const L film_x = (real_from<L>(x) + u.a) * L(inverse_width_);
    const L film_y = (real_from<L>(y) + u.b) * L(inverse_height_);
    const Vec3<L> film = vec_cast<L>(film_corner_) + film_x * vec_cast<L>(film_right_) +
                         film_y * vec_cast<L>(film_down_);
    if (kind_ == Kind::pinhole) {
      return {vec_cast<L>(eye_), normalize(film)};
    }
    if (kind_ == Kind::parallel) {
      return {film, vec_cast<L>(ahead_)};
    }
    const Disc<L> point = uniform_disc(u.c, u.d);
    const Vec3<L> offset = point.x * vec_cast<L>(lens_right_) + point.y * vec_cast<L>(lens_up_);
    const Vec3<L> aside = L(inverse_focus_) * offset;
    if (kind_ == Kind::lens) {
      return {vec_cast<L>(eye_) + offset, normalize(film - aside)};
    }
    return {film + offset, normalize(vec_cast<L>(ahead_) - aside)};
  }

 private:
  enum class Kind : std::uint8_t { pinhole, lens, parallel, parallel_lens };

  Vec3<Real> eye_, ahead_, film_corner_, film_right_, film_down_, lens_right_, lens_up_;
  Real inverse_width_, inverse_height_;
  Real inverse_focus_ = 0;
  Kind kind_ = Kind::pinhole;
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

}  // namespace parray::trace
