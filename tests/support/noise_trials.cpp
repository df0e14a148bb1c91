#include "tests/support/noise_trials.h"

#include <cmath>
#include <numeric>

#include "cli/input/scene_file/scene_file.h"
#include "common/scene/requirements.h"
#include "common/scene/settings.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"

namespace parray::test {
namespace {

NoisyScene sized(std::string name, Scene scene, std::uint32_t max_depth) {
  RenderSettings settings;
  settings.max_depth = max_depth;
  settings = resolve_settings(requirements_of(scene), settings).settings;
  return {std::move(name), std::move(scene), settings};
}

NoisyScene from_file(std::string name, const std::string& path) {
  const SceneFile file = read_scene_file(std::string(PARRAY_SOURCE_DIR) + "/scenes/" + path);
  return sized(std::move(name), file.scene, file.settings->max_depth);
}

Material diffuse(const Vec3d& albedo) { return {MaterialType::diffuse, albedo, 0, 1}; }

Camera camera_at(const Vec3d& from, const Vec3d& at, double vfov) {
  Camera camera;
  camera.look_from = from;
  camera.look_at = at;
  camera.vfov = vfov;
  camera.aperture = 0;
  camera.tan_half_vfov = std::tan(vfov / 2 * std::acos(-1.0) / 180);
  return camera;
}

/// A drift of grains a fifth of a pixel wide, dense in the middle and single at its rim.
NoisyScene grains() {
  Scene scene;
  scene.camera = camera_at({0, 0, 10}, {0, 0, 0}, 40);
  scene.materials = {diffuse({0.8, 0.3, 0.1}),
                     diffuse({0.2, 0.3, 0.8}),
                     {MaterialType::metal, {0.9, 0.9, 0.9}, 0, 1}};
  Dice dice(5);
  for (int i = 0; i < 8000; ++i) {
    const Vec3d at = 5 * std::sqrt(dice.unit()) * dice.unit() * dice.direction();
    scene.spheres.push_back({at, 0.015, dice.below32(3)});
  }
  return sized("grains", std::move(scene), 10);
}

/// A room under a ceiling of overlapping balls. Light enters only through small gaps between them.
NoisyScene gaps() {
  Scene scene;
  scene.camera = camera_at({0, 1.5, 9}, {0, 1.2, 0}, 50);
  scene.sky = {{1, 1, 1}, {1, 0.9, 0.7}};
  scene.materials = {diffuse({0.7, 0.7, 0.7}),
                     diffuse({0.3, 0.3, 0.3}),
                     {MaterialType::metal, {0.9, 0.8, 0.6}, 0.1, 1},
                     diffuse({0.6, 0.2, 0.1}),
                     {MaterialType::dielectric, {1, 1, 1}, 0, 1.5}};
  scene.spheres = {
      {{0, -1000, 0}, 1000, 0}, {{-2.2, 1, 0}, 1, 2}, {{0, 1, -1}, 1, 3}, {{2.2, 1, 0}, 1, 4}};
  const double step = 1.8;
  for (int row = -14; row <= 14; ++row) {
    for (int column = -14; column <= 14; ++column) {
      const double shift = row % 2 == 0 ? 0 : step / 2;
      scene.spheres.push_back(
          {{column * step + shift, 4.5, row * step * std::sqrt(0.75)}, 0.525 * step, 1});
    }
  }
  for (int i = 0; i < 24; ++i) {  // walls
    const double turn = i * std::acos(-1.0) / 12;
    scene.spheres.push_back({{24 * std::cos(turn), 3, 24 * std::sin(turn)}, 9, 1});
  }
  return sized("gaps", std::move(scene), 6);
}

std::vector<NoisyScene> of_size(std::vector<NoisyScene> scenes, std::uint32_t width,
                                std::uint32_t height) {
  for (NoisyScene& scene : scenes) {
    scene.settings.width = width;
    scene.settings.height = height;
  }
  return scenes;
}

}  // namespace

std::vector<NoisyScene> noisy_scenes(std::uint32_t width, std::uint32_t height) {
  return of_size({from_file("one-weekend", "one-weekend-484.json"),
                  from_file("crevice", "regression/contact.json"),
                  from_file("shells", "shells.json"), grains(), gaps()},
                 width, height);
}

std::vector<NoisyScene> other_scenes(std::uint32_t width, std::uint32_t height) {
  return of_size(
      {from_file("glass", "glass.json"), from_file("coated-ball", "regression/coated-ball.json"),
       from_file("one-weekend-20", "one-weekend-20.json"),
       from_file("ball-lens", "regression/ball-lens.json"),
       from_file("close-particles", "regression/close-particles.json")},
      width, height);
}

GrowingPicture::GrowingPicture(const RenderSettings& settings, double largest)
    : width(settings.width),
      largest_radiance(largest),
      pixels(std::size_t{settings.width} * settings.height),
      counts(pixels.size()) {}

FramebufferView GrowingPicture::state() const {
  return {width, static_cast<std::uint32_t>(pixels.size() / width), pixels, counts,
          largest_radiance};
}

std::uint64_t GrowingPicture::samples() const {
  return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
}

void GrowingPicture::trace(const PathTracer& tracer, const std::vector<std::uint32_t>& until) {
  TraceCounts ignored;
  std::vector<SampleRange> ranges(width);
  for (std::uint32_t y = 0; y < pixels.size() / width; ++y) {
    const std::size_t first = std::size_t{y} * width;
    for (std::size_t x = 0; x < width; ++x) ranges[x] = {counts[first + x], until[first + x]};
    tracer.trace_run({y, 0, width}, RunSamples(ranges), std::span(pixels).subspan(first, width),
                     ignored);
  }
  counts = until;
}

std::vector<double> GrowingPicture::means() const {
  const RadianceScale scale(largest_radiance);
  std::vector<double> values;
  values.reserve(pixels.size() * 3);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    for (const std::uint64_t sum : pixels[i].sum) values.push_back(scale.mean(sum, counts[i]));
  }
  return values;
}

}  // namespace parray::test
