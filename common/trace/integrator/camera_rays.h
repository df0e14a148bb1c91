#pragma once

#include <cstdint>

#include "common/math/directions.h"
#include "common/scene/scene.h"
#include "common/trace/integrator/random.h"
#include "common/trace/ray.h"

namespace parray::trace {

/// Unit vectors along the picture's sides, and back from the scene to the viewer.
struct CameraAxes {
  explicit CameraAxes(const Camera& camera)
      : back(normalize(camera.look_from - camera.look_at)),
        right(normalize(cross(normalize(camera.up), back))),
        up(cross(back, right)) {}

  Vec3d back, right, up;
};

/// The camera in the form that kernels use.
///
/// Perspective: the film vectors are for a focus distance of 1, so that directions stay near unit
/// length at every scale of the scene. Rays begin at look_from, or on a lens around it. They pass
/// through the points of the film, which stand for points at focus_distance.
///
/// Orthographic: the film is a rectangle around look_from, view_height high, in the plane across
/// the view. Rays begin on the film and go straight ahead. With a lens, every point of the film is
/// the middle of a disc in the same plane, and rays begin anywhere on the disc. They meet at
/// focus_distance straight ahead of that middle, where the picture is sharp. At other distances the
/// blur is the same as that of a perspective camera (a telecentric lens).
template <typename Real>
class CameraRays {
 public:
  /// The scene reader must have checked `camera`; width and height are in pixels.
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

  /// Returns the ray of one sample, or of lanes of samples, through pixel (x, y), y downwards.
  /// `random` must be that of the pixel and sample. `L` is Real or lanes of it.
  template <typename L, typename Uint>
  [[nodiscard]] PARRAY_INLINE Ray<L> ray(const Uint& x, const Uint& y,
                                         const RandomAddress<Uint>& random) const {
    const auto u = random.template at<L>(0, Purpose::camera);
    const L film_x = (real_from<L>(x) + u.a) * L(inverse_width_);
    const L film_y = (real_from<L>(y) + u.b) * L(inverse_height_);
    const Vec3<L> film = vec_cast<L>(film_corner_) + film_x * vec_cast<L>(film_right_) +
                         film_y * vec_cast<L>(film_down_);
    if (kind_ == Kind::pinhole) return {vec_cast<L>(eye_), normalize(film)};
    if (kind_ == Kind::parallel) return {film, vec_cast<L>(ahead_)};
    const Disc<L> point = uniform_disc(u.c, u.d);
    const Vec3<L> offset = point.x * vec_cast<L>(lens_right_) + point.y * vec_cast<L>(lens_up_);
    const Vec3<L> aside = L(inverse_focus_) * offset;
    if (kind_ == Kind::lens) return {vec_cast<L>(eye_) + offset, normalize(film - aside)};
    return {film + offset, normalize(vec_cast<L>(ahead_) - aside)};
  }

 private:
  enum class Kind : std::uint8_t { pinhole, lens, parallel, parallel_lens };

  Vec3<Real> eye_, ahead_, film_corner_, film_right_, film_down_, lens_right_, lens_up_;
  Real inverse_width_, inverse_height_;
  Real inverse_focus_ = 0;
  Kind kind_ = Kind::pinhole;
};

/// The sky in the form that kernels use.
template <typename Real>
struct SkyGradient {
  explicit SkyGradient(const Sky& sky)
      : horizon(vec_cast<Real>(sky.horizon)), rise(vec_cast<Real>(sky.zenith - sky.horizon)) {}

  /// Returns the radiance along a unit direction with this y. horizon + h (zenith - horizon) is
  /// exact if both are equal. A NaN direction gives a NaN radiance, because the bounds are the
  /// first arguments of min_of and max_of. So the sample counts as non-finite and is not shown as
  /// sky.
  template <typename L>
  [[nodiscard]] PARRAY_INLINE Vec3<L> radiance(const L& direction_y) const {
    const L h = min_of(L(1), max_of(L(0), (direction_y + L(1)) * L(0.5)));
    return vec_cast<L>(horizon) + h * vec_cast<L>(rise);
  }

  Vec3<Real> horizon;
  Vec3<Real> rise;
};

}  // namespace parray::trace
