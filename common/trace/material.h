#pragma once

#include "common/math/directions.h"
#include "common/scene/scene.h"
#include "common/trace/random.h"
#include "common/trace/ray.h"

namespace parray {

/// A material as the kernel reads it.
template <typename Real>
struct Surface {
  explicit Surface(const Material& material)
      : type(material.type),
        albedo(vec_cast<Real>(material.albedo)),
        fuzz(static_cast<Real>(material.fuzz)),
        ior(static_cast<Real>(material.ior)),
        inverse_ior(Real(1) / static_cast<Real>(material.ior)) {
    const Real ratio = (Real(1) - ior) / (Real(1) + ior);
    normal_reflectance = ratio * ratio;
  }

  MaterialType type;
  Vec3<Real> albedo;
  Real fuzz;
  Real ior;
  Real inverse_ior;
  Real normal_reflectance;  ///< Schlick's R0
};

enum class Event : std::uint8_t { absorbed, reflected, refracted };

template <typename Real>
struct Scattering {
  Event event;
  Vec3<Real> direction;  ///< unit length but for rounding; undefined when absorbed
};

/// Mirror direction about the unit vector `m`; `cosine` = -dot(incoming, m) >= 0.
template <typename Real>
Vec3<Real> mirror(const Vec3<Real>& incoming, const Vec3<Real>& m, Real cosine) {
  return incoming + Real(2) * cosine * m;
}

/// Lambertian reflection: `m` plus a uniform unit vector, never below the surface.
template <typename Real>
Scattering<Real> scatter_diffuse(const Vec3<Real>& m, const Uniform4<Real>& u) {
  const Vec3<Real> sum = m + uniform_direction(u.a, u.b);
  const Real square = dot(sum, sum);
  // The sum of two opposite unit vectors has no direction; rounding may also tip a short one below.
  if (!(dot(sum, m) > Real(0)) ||
      !(square > RealTraits<Real>::unit_roundoff * RealTraits<Real>::unit_roundoff)) {
    return {Event::reflected, m};
  }
  return {Event::reflected, (Real(1) / square_root(square)) * sum};
}

template <typename Real>
Scattering<Real> scatter_metal(const Surface<Real>& surface, const Vec3<Real>& incoming,
                               const Vec3<Real>& m, Real cosine, const SampleRandom& random,
                               std::uint32_t bounce) {
  const Vec3<Real> reflected = mirror(incoming, m, cosine);
  if (!(surface.fuzz > Real(0))) {
    return {Event::reflected, normalize(reflected)};
  }
  const auto u = random.at<Real>(bounce, Purpose::scatter);
  const auto r = random.at<Real>(bounce, Purpose::fuzz);
  const Vec3<Real> direction =
      normalize(reflected) + surface.fuzz * uniform_ball(u.a, u.b, r.a, r.b, r.c);
  if (dot(direction, m) <= Real(0)) {  // not so for NaN, which is to be counted
    return {Event::absorbed, {}};
  }
  return {Event::reflected, normalize(direction)};
}

/// Schlick's reflectance picks reflection or refraction; total internal reflection reflects.
/// Source: Schlick, "An inexpensive BRDF model for physically-based rendering", 1994.
template <typename Real>
Scattering<Real> scatter_dielectric(const Surface<Real>& surface, const Vec3<Real>& incoming,
                                    const Vec3<Real>& m, Real cosine, bool leaving,
                                    const Uniform4<Real>& u) {
  const Real eta = leaving ? surface.ior : surface.inverse_ior;
  const Real sine_squared = eta * eta * max_of(Real(1) - cosine * cosine, Real(0));
  const Real x = Real(1) - cosine;
  const Real reflectance =
      surface.normal_reflectance + (Real(1) - surface.normal_reflectance) * ((x * x) * (x * x) * x);
  if (sine_squared > Real(1) || u.a < reflectance) {
    return {Event::reflected, normalize(mirror(incoming, m, cosine))};
  }
  const Real transmitted_cosine = square_root(Real(1) - sine_squared);
  return {Event::refracted, normalize(eta * incoming + (eta * cosine - transmitted_cosine) * m)};
}

/// What happens to a path that meets a surface. `incoming` is the unit direction of travel, `m`
/// the unit normal on the path's own side, `leaving` says that this is the sphere's inside.
template <typename Real>
Scattering<Real> scatter(const Surface<Real>& surface, const Vec3<Real>& incoming,
                         const Vec3<Real>& m, bool leaving, const SampleRandom& random,
                         std::uint32_t bounce) {
  // Clamped, because at a tangent rounding may place the ray on either side of the surface.
  const Real cosine = min_of(max_of(-dot(incoming, m), Real(0)), Real(1));
  switch (surface.type) {
    case MaterialType::metal:
      return scatter_metal(surface, incoming, m, cosine, random, bounce);
    case MaterialType::dielectric:
      return scatter_dielectric(surface, incoming, m, cosine, leaving,
                                random.at<Real>(bounce, Purpose::scatter));
    default:
      return scatter_diffuse(m, random.at<Real>(bounce, Purpose::scatter));
  }
}

}  // namespace parray
