#pragma once

#include "common/math/directions.h"
#include "common/scene/scene.h"
#include "common/trace/integrator/random.h"
#include "common/trace/ray.h"

namespace parray::trace {

/// A material as the kernel reads it: a row of eight numbers, so that lanes can gather from it.
/// `Real` is a scalar, or lanes of one: then each lane has a material of its own.
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
  MaterialType type;        ///< not of lanes
};

/// A direction that a path may take, and where something happens to it instead or besides.
template <typename Real, typename Mask>
struct MaskedDirection {
  Vec3<Real> direction;  ///< unit length but for rounding; undefined when absorbed
  Mask mask;             ///< metal: absorbed; dielectric: refracted
};

/// -cos of the angle to the normal, clamped, because at a tangent rounding may place the ray on
/// either side of the surface.
template <typename Real>
PARRAY_INLINE Real incident_cosine(const Vec3<Real>& incoming, const Vec3<Real>& m) {
  return min_of(max_of(-dot(incoming, m), Real(0)), Real(1));
}

/// Mirror direction about the unit vector `m`; `cosine` = -dot(incoming, m) >= 0.
template <typename Real>
PARRAY_INLINE Vec3<Real> mirror(const Vec3<Real>& incoming, const Vec3<Real>& m, Real cosine) {
  return incoming + Real(2) * cosine * m;
}

/// Lambertian reflection: `m` plus a uniform unit vector, never below the surface.
template <typename Real>
PARRAY_INLINE Vec3<Real> scatter_diffuse(const Vec3<Real>& m, const Uniform4<Real>& u) {
  const Vec3<Real> sum = m + uniform_direction(u.a, u.b);
  const Real square = dot(sum, sum);
  const Real least(RealTraits<Real>::unit_roundoff * RealTraits<Real>::unit_roundoff);
  // The sum of two opposite unit vectors has no direction; rounding may also tip a short one below.
  const MaskOf<Real> good = (dot(sum, m) > Real(0)) & (square > least);
  return select(good, (Real(1) / square_root(square)) * sum, m);
}

/// Mirror reflection without fuzz.
template <typename Real>
PARRAY_INLINE Vec3<Real> scatter_mirror(const Vec3<Real>& incoming, const Vec3<Real>& m) {
  return normalize(mirror(incoming, m, incident_cosine(incoming, m)));
}

/// Mirror reflection plus fuzz times a uniform point of the unit ball; absorbed if that ends below
/// the surface. `u` of Purpose::scatter, `r` of Purpose::fuzz.
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

/// Schlick's reflectance picks reflection or refraction; total internal reflection reflects.
/// `leaving` says that this is the sphere's inside.
/// Source: Schlick, "An inexpensive BRDF model for physically-based rendering", 1994.
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

template <typename Real>
struct Scattering {
  Event event;
  Vec3<Real> direction;  ///< unit length but for rounding; undefined when absorbed
};

/// One path's scattering, whatever the material. `incoming` is the unit direction of travel, `m`
/// the unit normal on the path's own side, `leaving` says that this is the sphere's inside.
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
