#pragma once

#include "common/math/directions.h"
#include "common/scene/scene.h"
#include "common/trace/integrator/random.h"
#include "common/trace/ray.h"

namespace parray::trace {

/// A material in the form that kernels read: a row of eight numbers, so that lanes can gather from
/// it. `Real` is a scalar or lanes of one. With lanes, each lane has its own material.
template <typename Real>
struct MaterialParameters {
  MaterialParameters() = default;
  explicit MaterialParameters(const Material& material)
      : albedo(vec_cast<Real>(material.albedo)),
        fuzz(static_cast<Real>(material.fuzz)),
        ior(static_cast<Real>(material.ior)),
        inverse_ior(Real(1) / static_cast<Real>(material.ior)),
        type(material.type) {
    const Real ratio = (Real(1) - ior) / (Real(1) + ior);
    normal_reflectance = ratio * ratio;
  }

  Vec3<Real> albedo;
  Real fuzz;
  Real ior;
  Real inverse_ior;
  Real normal_reflectance;  ///< Schlick's R0
  MaterialType type;        ///< a single value even with lanes
};

/// A direction that a path may take, and the lanes with a special event.
template <typename Real, typename Mask>
struct MaskedDirection {
  Vec3<Real> direction;  ///< unit length but for rounding; undefined when absorbed
  Mask mask;             ///< metal: absorbed; dielectric: refracted
};

// Below, `incoming` is the unit direction in which the path travels to the surface, and `m` is the
// unit normal on the path's own side. Returned directions are those in which the path continues.

/// Returns the cosine of the angle between -incoming and `m`, clamped to [0, 1], because rounding
/// may place a tangent ray on either side of the surface.
template <typename Real>
PARRAY_INLINE Real incident_cosine(const Vec3<Real>& incoming, const Vec3<Real>& m) {
  return min_of(max_of(-dot(incoming, m), Real(0)), Real(1));
}

/// Returns the mirror direction about `m`; `cosine` = incident_cosine(incoming, m).
template <typename Real>
PARRAY_INLINE Vec3<Real> mirror(const Vec3<Real>& incoming, const Vec3<Real>& m, Real cosine) {
  return incoming + Real(2) * cosine * m;
}

/// Returns the direction of a Lambertian reflection: `m` plus a uniform unit vector, never below
/// the surface. `u` is of Purpose::scatter.
template <typename Real>
PARRAY_INLINE Vec3<Real> scatter_diffuse(const Vec3<Real>& m, const Uniform4<Real>& u) {
  const Vec3<Real> sum = m + uniform_direction(u.a, u.b);
  const Real square = dot(sum, sum);
  const Real least(RealTraits<Real>::unit_roundoff * RealTraits<Real>::unit_roundoff);
  // The sum of two opposite unit vectors has no direction. Rounding may also tip a short sum below
  // the surface.
  const MaskOf<Real> good = (dot(sum, m) > Real(0)) & (square > least);
  return select(good, (Real(1) / square_root(square)) * sum, m);
}

/// Returns the direction of a mirror reflection without fuzz.
template <typename Real>
PARRAY_INLINE Vec3<Real> scatter_mirror(const Vec3<Real>& incoming, const Vec3<Real>& m) {
  return normalize(mirror(incoming, m, incident_cosine(incoming, m)));
}

/// Returns a mirror reflection plus fuzz times a uniform point of the unit ball. The path is
/// absorbed if the direction ends below the surface. `u` is of Purpose::scatter, `r` of
/// Purpose::fuzz.
template <typename Real>
PARRAY_INLINE auto scatter_metal(Real fuzz, const Vec3<Real>& incoming, const Vec3<Real>& m,
                                 const Uniform4<Real>& u, const Uniform4<Real>& r) {
  const Vec3<Real> reflected = scatter_mirror(incoming, m);
  const Vec3<Real> blurred = reflected + fuzz * uniform_ball(u.a, u.b, r.a, r.b, r.c);
  const auto fuzzy = fuzz > Real(0);
  const MaskOf<Real> absorbed =
      fuzzy & (dot(blurred, m) <= Real(0));  // not NaN, which is to be counted
  return MaskedDirection<Real, MaskOf<Real>>{select(fuzzy, normalize(blurred), reflected),
                                             absorbed};
}

/// Chooses reflection or refraction by Schlick's reflectance; total internal reflection reflects.
/// `leaving` means that the ray is on the shape's inside. `u` is of Purpose::scatter. Source:
/// Schlick, "An inexpensive BRDF model for physically-based rendering", 1994.
template <typename Real, typename Mask>
PARRAY_INLINE MaskedDirection<Real, Mask> scatter_dielectric(
    const MaterialParameters<Real>& surface, const Vec3<Real>& incoming, const Vec3<Real>& m,
    Mask leaving, const Uniform4<Real>& u) {
  const Real cosine = incident_cosine(incoming, m);
  const Real eta = select(leaving, surface.ior, surface.inverse_ior);
  const Real sine_squared = eta * eta * max_of(Real(1) - cosine * cosine, Real(0));
  const Real x = Real(1) - cosine;
  const Real reflectance =
      surface.normal_reflectance + (Real(1) - surface.normal_reflectance) * ((x * x) * (x * x) * x);
  const Mask refracted = (sine_squared <= Real(1)) & (u.a >= reflectance);
  const Real transmitted_cosine = square_root(max_of(Real(1) - sine_squared, Real(0)));
  const Vec3<Real> direction =
      select(refracted, eta * incoming + (eta * cosine - transmitted_cosine) * m,
             mirror(incoming, m, cosine));
  return {normalize(direction), refracted};
}

enum class Event : std::uint8_t { absorbed, reflected, refracted };

/// What happens to a path at a surface.
template <typename Real>
struct Scattering {
  Event event;
  Vec3<Real> direction;  ///< unit length but for rounding; undefined when absorbed
};

/// Scatters one path on any material. `leaving` means that the path is on the shape's inside.
/// `bounce` is the number of surfaces that the path met before.
template <typename Real>
Scattering<Real> scatter(const MaterialParameters<Real>& surface, const Vec3<Real>& incoming,
                         const Vec3<Real>& m, bool leaving, const SampleRandom& random,
                         std::uint32_t bounce) {
  const auto u = random.at<Real>(bounce, Purpose::scatter);
  if (surface.type == MaterialType::metal) {
    const auto metal =
        scatter_metal(surface.fuzz, incoming, m, u, random.at<Real>(bounce, Purpose::fuzz));
    return {metal.mask ? Event::absorbed : Event::reflected, metal.direction};
  }
  if (surface.type == MaterialType::dielectric) {
    const auto glass = scatter_dielectric(surface, incoming, m, leaving, u);
    return {glass.mask ? Event::refracted : Event::reflected, glass.direction};
  }
  return {Event::reflected, scatter_diffuse(m, u)};
}

}  // namespace parray::trace
