#include "cli/output/postprocess/outline_and_depth_cue.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "tests/support/rooms.h"

/// Lines around spheres and the fading of what is far, over pictures of which every pixel is known.
namespace parray {
namespace {

constexpr std::uint32_t side = 100;  ///< pixels; a unit of length takes 10
constexpr std::uint32_t sky = UINT32_MAX;

/// Seen from z = 50 along -z, 10 units high, without perspective.
Scene scene_of(std::vector<Sphere> spheres) {
  Scene scene;
  scene.camera = {.look_from = {0, 0, 50}, .look_at = {0, 0, 0}, .vfov = 0, .aperture = 0};
  scene.camera.projection = Projection::orthographic;
  scene.camera.view_height = 10;
  scene.materials = {Material{}};
  scene.spheres = std::move(spheres);
  return scene;
}

/// What each pixel's centre shows, found sphere by sphere.
struct Seen {
  explicit Seen(const Scene& scene) : depth(side * side, INFINITY), sphere(side * side, sky) {
    for (std::uint32_t i = 0; i < side * side; ++i) {
      const double x = (i % side + 0.5) / 10 - 5;
      const double y = 5 - (static_cast<double>(i / side) + 0.5) / 10;
      for (std::uint32_t k = 0; k < scene.spheres.size(); ++k) {
        const Sphere& s = scene.spheres[k];
        const double off = std::hypot(x - s.center.x, y - s.center.y);
        if (off >= s.radius) continue;
        const double z = s.center.z + std::sqrt(s.radius * s.radius - off * off);
        if (50 - z < depth[i]) {
          depth[i] = static_cast<float>(50 - z);
          sphere[i] = k;
        }
      }
    }
  }
  [[nodiscard]] SeenSpheres view(std::uint32_t scenery = 0) const {
    return {depth, sphere, scenery};
  }

  std::vector<float> depth;
  std::vector<std::uint32_t> sphere;
};

std::vector<float> lines(const Scene& scene, double line_width, std::uint32_t scenery = 0) {
  const Seen seen(scene);
  return outline_of(scene, side, side, seen.view(scenery), line_width);
}

/// Distance of a pixel's centre from a point of the scene, in pixels.
double distance(std::uint32_t pixel, double x, double y) {
  return std::hypot(pixel % side + 0.5 - (50 + 10 * x),
                    static_cast<double>(pixel / side) + 0.5 - (50 - 10 * y));
}

double sum(const std::vector<float>& values) {
  double sum = 0;
  for (const float value : values) sum += static_cast<double>(value);
  return sum;
}

Image gray(float value) { return {side, side, std::vector<float>(3 * side * side, value)}; }

}  // namespace

TEST_CASE("a sphere in front of the sky has a line of the given width around it and none inside") {
  const Scene scene = scene_of({{{0, 0, 0}, 3, 0}});
  for (const double width : {1.0, 2.0, 3.5}) {
    CAPTURE(width);
    const std::vector<float> shares = lines(scene, width);
    for (std::uint32_t i = 0; i < side * side; ++i) {
      const double off = std::abs(distance(i, 0, 0) - 30);
      CAPTURE(off);
      if (off <= width / 2 - 0.5) CHECK(shares[i] == doctest::Approx(1).epsilon(1e-3));
      if (off >= width / 2 + 0.51) CHECK(shares[i] == 0);
      CHECK(shares[i] ==
            doctest::Approx(std::clamp(width / 2 + 0.5 - off, 0.0, 1.0)).epsilon(0.01));
    }
    CHECK(sum(shares) == doctest::Approx(2 * std::numbers::pi * 30 * width).epsilon(0.01));
  }
}

TEST_CASE("one sphere behind another has a line between them, and nothing else inside") {
  // The nearer one at the left covers a part of the other, which is wholly behind.
  const Scene scene = scene_of({{{-1, 0, 5}, 2, 0}, {{1, 0, -5}, 2, 0}});
  const std::vector<float> shares = lines(scene, 2);
  for (std::uint32_t i = 0; i < side * side; ++i) {
    const double near = distance(i, -1, 0) - 20;
    const double far = distance(i, 1, 0) - 20;
    const bool on_near = std::abs(near) < 0.5;
    const bool on_far = std::abs(far) < 0.5 && near > 2;
    if (on_near || on_far) CHECK(shares[i] > 0.98F);
    if (std::abs(near) > 1.51 && (near < 0 || std::abs(far) > 1.51)) CHECK(shares[i] == 0);
  }
}

TEST_CASE("no line is drawn where two spheres intersect") {
  const Scene scene = scene_of({{{-1, 0, 0}, 2, 0}, {{1, 0, 0}, 2, 0}});
  const std::vector<float> shares = lines(scene, 2);
  for (std::uint32_t i = 0; i < side * side; ++i) {
    const double left = distance(i, -1, 0) - 20;
    const double right = distance(i, 1, 0) - 20;
    if (std::min(left, right) < -1.51) CHECK(shares[i] == 0);
    if (std::min(left, right) > 1.51) CHECK(shares[i] == 0);
  }
  CHECK(sum(shares) > 100);
}

TEST_CASE("scenery is background: a sphere in front of a wall has a line, the wall has none") {
  const Scene scene = scene_of({{{0, 0, -1001}, 1000, 0}, {{0, 0, 0}, 1, 0}});
  CHECK(sum(lines(scene, 2, 1)) == doctest::Approx(2 * std::numbers::pi * 10 * 2).epsilon(0.02));
}

TEST_CASE("spheres no wider than the line have no line") {
  std::vector<Sphere> dust;
  for (int i = 0; i < 9; ++i) dust.push_back({{i - 4.03, 0.04, 0}, 0.1, 0});
  CHECK(sum(lines(scene_of(dust), 2)) == 0);
  CHECK(sum(lines(scene_of(dust), 1)) > 0);
}

TEST_CASE("lines are the same for any number of threads") {
  const Scene scene = scene_of({{{-1, 0, 5}, 2, 0}, {{1, 0, -5}, 2, 0}, {{0, 2, 0}, 1, 0}});
  const Seen seen(scene);
  CHECK(outline_of(scene, side, side, seen.view(), 2, {}, 4) ==
        outline_of(scene, side, side, seen.view(), 2, {}, 1));
}

TEST_CASE("with perspective a line lies where the camera shows the silhouette") {
  Scene scene = scene_of({{{2, 1, 0}, 2, 0}});
  scene.camera = {.look_from = {0, 0, 10}, .look_at = {0, 0, 0}, .vfov = 90, .aperture = 0};
  scene.camera.tan_half_vfov = 1;
  Seen seen(scene);
  const Sphere& ball = scene.spheres[0];
  const auto off = [&](std::uint32_t i) {  // of the ray from the sphere's centre, in units
    const Vec3d ray = normalize(
        Vec3d{(i % side + 0.5) / 50 - 1, 1 - (static_cast<double>(i / side) + 0.5) / 50, -1});
    return length(cross(ball.center - scene.camera.look_from, ray));
  };
  for (std::uint32_t i = 0; i < side * side; ++i) seen.sphere[i] = off(i) < ball.radius ? 0 : sky;
  const std::vector<float> shares = outline_of(scene, side, side, seen.view(), 2);
  for (std::uint32_t i = 0; i < side * side; ++i) {
    const double pixels = (off(i) - ball.radius) * 5;  // about: 5 pixels a unit at that distance
    if (std::abs(pixels) < 0.3) CHECK(shares[i] > 0.8F);
    if (std::abs(pixels) > 2) CHECK(shares[i] == 0);
  }
  CHECK(sum(shares) > 50);
}

TEST_CASE("ink covers by its share, and is opaque where the picture is transparent") {
  Image image = gray(0.8F);
  std::vector<float> alpha(side * side, 0.5F);
  std::vector<float> shares(side * side, 0.0F);
  shares[7] = 1;
  shares[8] = 0.5F;
  const Image before = image;
  draw_ink(image, alpha, shares, {0.2, 0.2, 0.2});
  CHECK(image.rgb[3 * 6] == before.rgb[3 * 6]);
  CHECK(alpha[6] == 0.5F);
  CHECK(image.rgb[3 * 7] == doctest::Approx(0.2));
  CHECK(alpha[7] == 1);
  CHECK(image.rgb[3 * 8] == doctest::Approx(0.5));
  CHECK(alpha[8] == 0.75F);
}

TEST_CASE("the nearest surface keeps its colour and the farthest loses the given share") {
  const Scene scene = scene_of({{{-2, 0, 3}, 1, 0}, {{2, 0, -3}, 1, 0}});
  const Seen seen(scene);
  const DepthFade fade_by(seen.view(), side, 0.5);
  const auto [near, far] = std::ranges::minmax_element(seen.depth, [](float a, float b) {
    return (std::isfinite(a) ? a : -1) < (std::isfinite(b) ? b : -1);
  });
  (void)near;
  double nearest = 1e9;
  double farthest = 0;
  for (std::uint32_t i = 0; i < side * side; ++i) {
    const auto inner = [&](std::uint32_t k) { return seen.sphere[k] != sky; };
    if (!inner(i) || !inner(i - 1) || !inner(i + 1) || !inner(i - side) || !inner(i + side)) {
      continue;
    }
    nearest = std::min(nearest, static_cast<double>(seen.depth[i]));
    farthest = std::max(farthest, static_cast<double>(seen.depth[i]));
  }
  CHECK(fade_by(nearest) == 0);
  CHECK(fade_by(farthest) == 0.5);
  CHECK(fade_by((nearest + farthest) / 2) == doctest::Approx(0.25));
  CHECK(fade_by(static_cast<double>(*far)) == 0.5);  // beside the background: no more than that

  Image image = gray(0.0F);
  std::vector<float> opaque;
  fade(image, opaque, seen.view(), fade_by, {1, 0.5, 0});
  for (std::uint32_t i = 0; i < side * side; ++i) {
    const float depth = seen.depth[i];
    if (!std::isfinite(depth)) CHECK(image.rgb[3 * i] == 0);
    if (static_cast<double>(depth) == nearest) CHECK(image.rgb[3 * i] == 0);
    if (static_cast<double>(depth) == farthest) {
      CHECK(image.rgb[3 * i] == 0.5F);
      CHECK(image.rgb[3 * i + 1] == 0.25F);
      CHECK(image.rgb[3 * i + 2] == 0);
    }
  }
}

TEST_CASE("a pixel that also shows a wall far away does not decide the range of depths") {
  const Scene scene = scene_of({{{0, 0, 3}, 2, 0}, {{0, 0, -3}, 4, 0}});
  Seen seen(scene);
  seen.depth[50 * side + 50 + 30] = 9000;  // a gap in the farther sphere
  SeenSpheres view = seen.view();
  CHECK(DepthFade(view, side, 1)(60) < 0.01);
  view.farthest = 57;
  CHECK(DepthFade(view, side, 1)(60) == 1);
}

TEST_CASE("a film gives the range of depths") {
  const DepthFade fade(40, 60, 0.5);
  CHECK(fade(30) == 0);
  CHECK(fade(50) == 0.25);
  CHECK(fade(70) == 0.5);
}

TEST_CASE("with a transparent background distant surfaces become transparent") {
  const Scene scene = scene_of({{{-2, 0, 3}, 1, 0}, {{2, 0, -3}, 1, 0}});
  const Seen seen(scene);
  const DepthFade all(seen.view(), side, 1);
  Image image = gray(0.5F);
  std::vector<float> alpha(side * side, 1.0F);
  fade(image, alpha, seen.view(), all, {1, 1, 1});
  const auto nearest = static_cast<std::size_t>(
      std::min_element(seen.depth.begin(), seen.depth.end()) - seen.depth.begin());
  CHECK(alpha[nearest] == 1);
  CHECK(image.rgb[3 * nearest] == 0.5F);
  const std::size_t rim = 50 * side + 50 + 29;  // of the far sphere
  CHECK(alpha[rim] < 0.05F);
  CHECK(image.rgb[3 * rim] == doctest::Approx(0.5 * static_cast<double>(alpha[rim])));
}

TEST_CASE("the background has the colour of its pixels, or of the sky if there are none") {
  Scene scene = scene_of({{{0, 0, 0}, 2, 0}});
  scene.sky = {{0.25, 0.5, 4}, {0.25, 0.5, 4}};
  const Seen seen(scene);
  Image image = gray(0.0F);
  for (std::uint32_t i = 0; i < side * side; ++i) {
    if (seen.sphere[i] == sky) image.rgb[3 * i] = 0.75F;
    if (seen.sphere[i] == sky) image.rgb[3 * i + 1] = 2.0F;
  }
  CHECK(background_color(image, seen.view(), scene) == Vec3d{0.75, 1, 0});
  const Scene full = scene_of({{{0, 0, 0}, 20, 0}});
  Scene lit = full;
  lit.sky = scene.sky;
  CHECK(background_color(image, Seen(full).view(), lit) == Vec3d{0.25, 0.5, 1});
  // A portrait's wall counts as background.
  CHECK(background_color(gray(0.125F), Seen(full).view(1), lit).x == doctest::Approx(0.125));
}

TEST_CASE("lines fade with their spheres") {
  const Scene scene = scene_of({{{-2, 0, 3}, 1, 0}, {{2, 0, -3}, 1, 0}});
  const Seen seen(scene);
  const std::vector<float> plain = outline_of(scene, side, side, seen.view(), 2);
  const std::vector<float> faded =
      outline_of(scene, side, side, seen.view(), 2, DepthFade(seen.view(), side, 1));
  double far = 0;
  double near = 0;
  for (std::uint32_t i = 0; i < side * side; ++i) {
    CHECK(faded[i] <= plain[i]);
    (i % side < 50 ? near : far) += static_cast<double>(faded[i]);
  }
  CHECK(near > 0.8 * sum(plain) / 2);
  CHECK(far < 0.05 * sum(plain) / 2);
}

}  // namespace parray
