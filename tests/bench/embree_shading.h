#pragma once

#include <array>
#include <vector>

#include "common/math/vec.h"
#include "common/scene/scene.h"
#include "tests/bench/lanes.h"
#include "tests/support/rooms.h"

/// ParRay's camera, sky and materials (DESIGN: "the model") for the Embree peer: the same maps from
/// the same random numbers, as templates on one path (F = float) or sixteen (F = lanes::Floats),
/// and with the liberties that a tracer takes that need not repeat its bits: approximate reciprocal
/// square roots, fused multiply-adds, fewer normalisations.
namespace parray::peer {

using lanes::Mask;
using lanes::Word;

template <typename F>
Vec3<F> splat(const Vec3<float>& a) {
  return {F{} + a.x, F{} + a.y, F{} + a.z};
}

/// Where a path's random numbers are: common/trace/integrator/random.h says what the address means.
template <typename F>
struct Address {
  Word<F> pixel;
  Word<F> sample;
  std::array<std::uint32_t, 2> key;
};

template <typename F>
struct Uniform {
  F a, b, c, d;
};

/// Philox4x32-10, as in common/math/philox.h.
template <typename F>
Uniform<F> uniform(const Address<F>& address, std::uint32_t bounce, std::uint32_t purpose) {
  Word<F> c0 = address.pixel;
  Word<F> c1 = address.sample;
  Word<F> c2 = Word<F>{} + (bounce << 8 | purpose);
  Word<F> c3{};
  auto [k0, k1] = address.key;
  for (int round = 0; round < 10; ++round) {
    const auto p0 = lanes::multiply(c0, 0xD2511F53);
    const auto p1 = lanes::multiply(c2, 0xCD9E8D57);
    c0 = p1.high ^ c1 ^ k0;
    c1 = p1.low;
    c2 = p0.high ^ c3 ^ k1;
    c3 = p0.low;
    k0 += 0x9E3779B9;
    k1 += 0xBB67AE85;
  }
  const auto unit = [](const Word<F>& bits) { return lanes::to_float(bits >> 8) * 0x1p-24F; };
  return {unit(c0), unit(c1), unit(c2), unit(c3)};
}

template <typename F>
struct Turn {
  F cos;
  F sin;
};

/// Cosine and sine of x in [-pi/4, pi/4] by Taylor polynomials.
template <typename F>
Turn<F> sincos_near_zero(const F& x) {
  const F xx = x * x;
  const F sine =
      x * (1 + xx * (-1.66666667e-1F +
                     xx * (8.33333333e-3F + xx * (-1.98412698e-4F + xx * 2.75573192e-6F))));
  const F cosine =
      1 + xx * (-0.5F + xx * (4.16666667e-2F + xx * (-1.38888889e-3F + xx * 2.48015873e-5F)));
  return {cosine, sine};
}

/// Cosine and sine of 2 pi u, from the nearest quarter turn.
template <typename F>
Turn<F> sincos_2pi(const F& u) {
  const F quarters = 4 * u;
  const Word<F> quadrant = lanes::truncate(quarters + 0.5F);
  const auto [cosine, sine] =
      sincos_near_zero<F>((quarters - lanes::to_float(quadrant)) * 1.57079633F);
  const Mask<F> odd = (quadrant & 1) != 0;
  const F c = lanes::select(odd, sine, cosine);
  const F s = lanes::select(odd, cosine, sine);
  return {lanes::select(((quadrant + 1) & 2) != 0, -c, c),
          lanes::select((quadrant & 2) != 0, -s, s)};
}

template <typename F>
Vec3<F> uniform_direction(const F& u, const F& v) {
  const F rho = 2 * lanes::square_root(u * (1 - u));
  const Turn<F> phi = sincos_2pi(v);
  return {rho * phi.sin, 1 - 2 * u, rho * phi.cos};
}

template <typename F>
F smaller(const F& a, const F& b) {
  return lanes::select(a < b, a, b);
}
template <typename F>
F larger(const F& a, const F& b) {
  return lanes::select(a > b, a, b);
}

template <typename F>
Vec3<F> unit_vector(const Vec3<F>& a) {
  return lanes::inverse_square_root(dot(a, a)) * a;
}

template <typename F>
struct PrimaryRay {
  Vec3<F> origin;
  Vec3<F> direction;
};

/// As common/trace/integrator/camera_rays.h has it.
class Lens {
 public:
  Lens(const Camera& camera, std::uint32_t width, std::uint32_t height);

  template <typename F>
  [[nodiscard]] PrimaryRay<F> ray(const F& x, const F& y, const Address<F>& address) const {
    const Uniform<F> u = uniform<F>(address, 0, 0);
    const F film_x = (x + u.a) * inverse_width_;
    const F film_y = (y + u.b) * inverse_height_;
    const Vec3<F> direction =
        splat<F>(corner_) + film_x * splat<F>(right_) + film_y * splat<F>(down_);
    if (pinhole_) return {splat<F>(origin_), unit_vector(direction)};
    const F a = 2 * u.c - 1;
    const F b = 2 * u.d - 1;
    const Mask<F> steep = b * b > a * a;
    const F radius = lanes::select(steep, b, a);
    const F nonzero = lanes::select(radius == 0.0F, F{} + 1, radius);
    const Turn<F> phi = sincos_near_zero<F>(lanes::select(steep, a, b) / nonzero * 0.785398163F);
    const Vec3<F> offset =
        (radius * lanes::select(steep, phi.sin, phi.cos)) * splat<F>(lens_right_) +
        (radius * lanes::select(steep, phi.cos, phi.sin)) * splat<F>(lens_up_);
    return {splat<F>(origin_) + offset, unit_vector(direction - (F{} + inverse_focus_) * offset)};
  }

 private:
  Vec3<float> origin_, corner_, right_, down_, lens_right_, lens_up_;
  float inverse_width_, inverse_height_, inverse_focus_;
  bool pinhole_;
};

struct SkyLight {
  Vec3<float> horizon;
  Vec3<float> rise;

  template <typename F>
  [[nodiscard]] Vec3<F> radiance(const Vec3<F>& direction) const {
    const F h = smaller(F{} + 1, larger(F{}, (direction.y + 1) * 0.5F));
    return splat<F>(horizon) + h * splat<F>(rise);
  }
};

/// Materials as columns, so that several paths can gather at once.
struct MaterialColumns {
  explicit MaterialColumns(const std::vector<Material>& materials);

  std::vector<float> red, green, blue;
  std::vector<float> fuzz;  ///< < 0: not a metal
  std::vector<float> ior;   ///< 0: not a dielectric
};

template <typename F>
struct Scattered {
  Vec3<F> direction;  ///< unit length
  Vec3<F> albedo;
  Mask<F> absorbed;
};

/// What happens to paths of unit direction `d` at surfaces whose unit normal on the path's side is
/// `m`. A kind of material that no path meets costs nothing.
template <typename F>
Scattered<F> scatter(const MaterialColumns& materials, const Word<F>& material, const Vec3<F>& d,
                     const Vec3<F>& m, const Mask<F>& leaving, const Address<F>& address,
                     std::uint32_t bounce) {
  const F fuzz = lanes::gather(materials.fuzz.data(), material);
  const F ior = lanes::gather(materials.ior.data(), material);
  const Mask<F> dielectric = ior > 0;
  const Mask<F> fuzzy = fuzz > 0;
  const Mask<F> diffuse = (fuzz < 0) & (ior <= 0);
  const F cosine = smaller(F{} + 1, larger(F{}, -dot(d, m)));
  Vec3<F> out = d + (2 * cosine) * m;  // the mirror direction
  Uniform<F> u{};
  if (lanes::any(diffuse | fuzzy | dielectric)) u = uniform<F>(address, bounce, 1);
  if (lanes::any(diffuse | fuzzy)) {
    const Vec3<F> sphere = uniform_direction(u.a, u.b);
    F radius = F{} + 1;
    if (lanes::any(fuzzy)) {
      const Uniform<F> r = uniform<F>(address, bounce, 2);
      radius = lanes::select(fuzzy, fuzz * larger(r.a, larger(r.b, r.c)), radius);
    }
    const Mask<F> spread = diffuse | fuzzy;
    const auto moved = [&](const F& mirrored, const F& normal, const F& s) {
      const F base = lanes::select(diffuse, normal, mirrored);
      return lanes::select(spread, base + radius * s, mirrored);
    };
    out = {moved(out.x, m.x, sphere.x), moved(out.y, m.y, sphere.y), moved(out.z, m.z, sphere.z)};
  }
  if (lanes::any(dielectric)) {
    const F eta = lanes::select(leaving, ior, 1 / ior);
    const F sine_squared = eta * eta * (1 - cosine * cosine);
    const F ratio = (1 - ior) / (1 + ior);
    const F r0 = ratio * ratio;
    const F x = 1 - cosine;
    const F reflectance = r0 + (1 - r0) * ((x * x) * (x * x) * x);
    const Mask<F> refracts = dielectric & (sine_squared <= 1) & (u.a >= reflectance);
    const F along = eta * cosine - lanes::square_root(larger(F{}, 1 - sine_squared));
    const auto bent = [&](const F& other, const F& incoming, const F& normal) {
      return lanes::select(refracts, eta * incoming + along * normal, other);
    };
    out = {bent(out.x, d.x, m.x), bent(out.y, d.y, m.y), bent(out.z, d.z, m.z)};
  }
  const Mask<F> absorbed = fuzzy & (dot(out, m) <= 0);
  const F square = larger(F{} + 0x1p-96F, dot(out, out));  // opposite unit vectors cancel
  return {lanes::inverse_square_root(square) * out,
          {lanes::gather(materials.red.data(), material),
           lanes::gather(materials.green.data(), material),
           lanes::gather(materials.blue.data(), material)},
          absorbed};
}

}  // namespace parray::peer
