#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "common/scene/limits.h"
#include "common/scene/scene.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"

/// Seeded scenes that cover the extremes of the numbers that scene files allow.
namespace parray::test {

struct ExtremeScene {
  std::string kind;
  Scene scene;
};

/// Makes scene number `index` of a seed. Kinds of scenes take turns. Ratios of sizes are random on
/// a logarithmic scale. Then the whole scene is turned, scaled and moved.
class ExtremeScenes {
 public:
  explicit ExtremeScenes(std::uint64_t seed) : seed_(seed) {}

  [[nodiscard]] ExtremeScene make(std::uint64_t index) const {
    Maker maker(seed_ * 1'000'003 + index);
    return maker.make(index);
  }

 private:
  class Maker {
   public:
    explicit Maker(std::uint64_t seed) : dice_(seed) {}

    ExtremeScene make(std::uint64_t index) {
      struct Kind {
        const char* name;
        void (Maker::*build)();
      };
      constexpr std::array<Kind, 11> kinds{{{"balls on a ground", &Maker::balls_on_ground},
                                            {"contact", &Maker::contact},
                                            {"eye at a surface", &Maker::near_eye},
                                            {"distant eye", &Maker::distant_eye},
                                            {"glass shell", &Maker::glass_shell},
                                            {"bubbles", &Maker::bubbles},
                                            {"particles", &Maker::particles},
                                            {"specks", &Maker::specks},
                                            {"narrow view", &Maker::narrow_view},
                                            {"two clusters", &Maker::two_clusters},
                                            {"fog", &Maker::fog}}};
      const Kind& kind = kinds[index % kinds.size()];
      add_materials();
      axis_ = dice_.one_in(2) ? Vec3d{0, 1, 0} : dice_.direction();
      (this->*kind.build)();
      place();
      return {kind.name, std::move(scene_)};
    }

   private:
    static constexpr std::uint32_t red = 0;
    static constexpr std::uint32_t glass = 4;

    void add_materials() {
      scene_.materials = {{MaterialType::diffuse, {0.8, 0.2, 0.1}, 0, 1},
                          {MaterialType::diffuse, {0.5, 0.6, 0.7}, 0, 1},
                          {MaterialType::metal, {0.9, 0.8, 0.7}, 0, 1},
                          {MaterialType::metal, {0.8, 0.8, 0.9}, 0.3, 1},
                          {MaterialType::dielectric, {1, 1, 1}, 0, dice_.between(1.1, 2)},
                          {MaterialType::dielectric, {1, 1, 1}, 0, 1 / 1.5}};
      scene_.camera.aperture = 0;
    }

    std::uint32_t any_material() { return static_cast<std::uint32_t>(dice_.below(5)); }
    std::uint32_t opaque() { return static_cast<std::uint32_t>(dice_.below(4)); }
    void add(const Vec3d& center, double radius, std::uint32_t material) {
      scene_.spheres.push_back({center, radius, material});
    }
    /// Returns a ground that touches the plane through 0 across the axis.
    void add_ground(double radius) { add(-radius * axis_, radius, 1); }

    /// Makes the camera look from `from` to `at`, where the picture is `height` high.
    void look(const Vec3d& from, const Vec3d& at, double height) {
      Camera& camera = scene_.camera;
      camera.look_from = from;
      camera.look_at = at;
      camera.focus_distance = length(at - from);
      camera.up = dice_.across(normalize(at - from));
      const double degree = std::acos(-1.0) / 180;
      camera.vfov =
          std::clamp(2 * std::atan(height / 2 / camera.focus_distance) / degree, 1e-6, 170.0);
      camera.tan_half_vfov = std::tan(camera.vfov / 2 * degree);
    }
    /// Returns a direction that points upwards from the ground, at least a little.
    Vec3d upwards() {
      const Vec3d d = dice_.direction();
      return normalize((dot(d, axis_) < 0 ? -1.0 : 1.0) * d + 0.2 * axis_);
    }

    void balls_on_ground() {
      add_ground(dice_.ten_to(0.5, 8));
      const Vec3d side = dice_.across(axis_);
      const Vec3d other = cross(axis_, side);
      for (int i = 0; i < 30; ++i) {
        const double r = dice_.between(0.1, 0.5);
        const double ground = scene_.spheres[0].radius;
        const Vec3d foot = dice_.between(-3, 3) * side + dice_.between(-3, 3) * other;
        const Vec3d up = normalize(foot + ground * axis_);
        add((ground + r) * up - ground * axis_, r, any_material());
      }
      look(dice_.between(4, 12) * upwards(), 0.2 * axis_, dice_.between(1, 6));
    }

    void contact() {
      add_ground(dice_.ten_to(0, 5));
      add(axis_, 1, opaque());
      const Vec3d side = normalize(dice_.across(axis_) + dice_.ten_to(-3, -1) * axis_);
      look(dice_.ten_to(0.5, 1.5) * side, {}, dice_.ten_to(-3, 0.5));
    }

    void near_eye() {
      add({}, 1, any_material());
      for (int i = 0; i < 6; ++i) {
        const double r = dice_.ten_to(-3, 0);
        add((1 + r) * dice_.direction(), r, any_material());
      }
      const Vec3d out = dice_.direction();
      const double height = dice_.ten_to(-3, 0);
      const Vec3d from = (1 + height) * out;
      look(from, from + dice_.across(out) - dice_.between(0, 1) * out, dice_.between(0.3, 8));
    }

    void distant_eye() {
      for (int i = 0; i < 5; ++i) add(dice_.in_cube(1), dice_.ten_to(-1, 0), any_material());
      if (dice_.one_in(2)) {
        axis_ = normalize(axis_ + Vec3d{0.1, 0, 0});
        add_ground(dice_.ten_to(0, 3));
      }
      look(dice_.ten_to(1, 6) * upwards(), {}, dice_.between(1, 4));
    }

    void glass_shell() {
      const Vec3d center = dice_.one_in(3) ? Vec3d{} : dice_.ten_to(-1, 3) * dice_.direction();
      const double inner = 1 - dice_.ten_to(-6, -1);
      add(center, 1, glass);
      add(center, inner, dice_.one_in(2) ? red : glass + 1);
      if (dice_.one_in(2)) add(center, inner * (1 - dice_.ten_to(-6, -1)), glass);
      add(center - 101 * axis_, 100, 1);
      look(center + dice_.ten_to(0.3, 3) * upwards(), center, dice_.between(0.5, 3));
    }

    void bubbles() {
      add({}, 1, glass);
      for (int i = 0; i < 60; ++i) {
        const double r = dice_.ten_to(-4, -0.7);
        add(dice_.between(0, 0.99 - r) * dice_.direction(), r, glass + 1);
      }
      add(-1001 * axis_, 1000, 1);
      look(dice_.between(2, 10) * upwards(), dice_.one_in(2) ? Vec3d{} : scene_.spheres[9].center,
           dice_.ten_to(-2, 0.5));
    }

    void particles() {
      const double small = dice_.ten_to(-4, -1);
      for (int i = 0; i < 500; ++i) add(dice_.in_cube(1), small * dice_.between(0.5, 1), opaque());
      if (dice_.one_in(2)) add({}, dice_.between(0.2, 0.6), any_material());
      const double distance = dice_.ten_to(-0.3, 4);
      look(distance * upwards(), {}, dice_.between(0.2, 1) * std::min(distance, 3.0));
    }

    void specks() {
      const double r = dice_.ten_to(-8, -1);
      add({}, 1, opaque());
      const Vec3d pole = dice_.direction();
      const Vec3d side = dice_.across(pole);
      const Vec3d other = cross(pole, side);
      for (int i = 0; i < 40; ++i) {
        const Vec3d p = normalize(pole + (r * dice_.between(-9, 9)) * side +
                                  (r * dice_.between(-9, 9)) * other);
        add((1 + r) * p, r, any_material());
      }
      const Vec3d slant = normalize(pole + dice_.between(0.3, 2) * side);
      const double height = dice_.one_in(4) ? 2 : 20 * r;
      look(pole + dice_.between(1.5, 4) * std::max(height, 40 * r) * slant, pole, height);
    }

    void narrow_view() {
      for (int i = 0; i < 200; ++i) add(dice_.in_cube(1), dice_.ten_to(-2, -1), any_material());
      const Sphere& shown = scene_.spheres[dice_.below(200)];
      const Vec3d towards = upwards();
      const double height = shown.radius * dice_.ten_to(-2, 0.5);
      look(shown.center + dice_.ten_to(1, 6) * towards,
           shown.center + shown.radius * dice_.between(0.8, 1) * dice_.across(towards), height);
    }

    void two_clusters() {
      const Vec3d far = dice_.ten_to(2, 7) * dice_.direction();
      const auto center = [&](int i) { return i % 2 == 0 ? Vec3d{} : far; };
      for (int i = 0; i < 60; ++i) {
        add(center(i) + dice_.in_cube(2), dice_.between(0.1, 0.6), any_material());
      }
      const Vec3d shown = center(static_cast<int>(dice_.below(2)));
      look(shown + dice_.between(5, 20) * upwards(), shown, dice_.between(2, 6));
    }

    /// Grains of about a pixel that cover half of the picture, seen from a growing distance.
    void fog() {
      const double r = dice_.between(0.01, 0.03);
      const double grains = 0.5 / (r * r);
      for (int i = 0; i < grains; ++i) add(dice_.in_cube(1), r, opaque());
      look(r * dice_.ten_to(4, 7) * upwards(), {}, 2);
    }

    double reach() const {
      double most = length(scene_.camera.look_from);
      for (const Sphere& sphere : scene_.spheres) {
        most = std::max(most, length(sphere.center) + sphere.radius);
      }
      return most;
    }

    /// Scales by 1e-12 to 1e12 and moves by up to 1e9 of the size, within the limits of scene
    /// files.
    void place() {
      double smallest = scene_.spheres[0].radius;
      for (const Sphere& sphere : scene_.spheres) smallest = std::min(smallest, sphere.radius);
      const double far = dice_.one_in(2) ? 0 : dice_.ten_to(0, 9);
      const double largest = limits::max_length / (10 * reach() * (1 + far));
      const double scale =
          std::min(std::max(dice_.ten_to(-12, 12), 10 * limits::min_radius / smallest), largest);
      const Vec3d by = far * reach() * dice_.direction();
      const auto put = [&](const Vec3d& v) { return scale * (v + by); };
      Camera& camera = scene_.camera;
      camera.look_from = put(camera.look_from);
      camera.look_at = put(camera.look_at);
      camera.focus_distance *= scale;
      for (Sphere& sphere : scene_.spheres) {
        sphere.center = put(sphere.center);
        sphere.radius *= scale;
      }
    }

    Dice dice_;
    Scene scene_;
    Vec3d axis_;
  };

  std::uint64_t seed_;
};

}  // namespace parray::test
