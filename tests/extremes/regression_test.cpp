// Small renders of scenes that broke other programs (see scenes/regression/README.md), compared
// with closed forms, with f64, and with the same paths in 113 bits.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "cli/input/scene_file/scene_file.h"
#include "common/base/error.h"
#include "common/scene/requirements.h"
#include "common/scene/settings.h"
#include "tests/support/extremes.h"
#include "tests/support/path_steps.h"
#include "tests/support/precisions.h"
#include "tests/support/quad.h"
#include "tests/support/rooms.h"
#include "tests/support/textbook_tracer.h"
#include "tests/support/tracers.h"

namespace parray::test {
namespace {

struct Named {
  std::string name;
  Scene scene;
  RenderSettings settings;  ///< with the precision that `auto` picks for the scene
};

Named load(const std::string& name) {
  const SceneFile file =
      read_scene_file(std::string(PARRAY_SOURCE_DIR) + "/scenes/regression/" + name + ".json");
  return {name, file.scene, resolve_settings(requirements_of(file.scene), file.settings).settings};
}

std::vector<Named> all() {
  std::vector<std::string> names;
  for (const auto& entry :
       std::filesystem::directory_iterator(PARRAY_SOURCE_DIR "/scenes/regression")) {
    if (entry.path().extension() == ".json") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  std::vector<Named> scenes;
  for (const std::string& name : names) scenes.push_back(load(name));
  return scenes;
}

using PathSteps = std::vector<std::vector<Step>>;

template <typename Real>
PathSteps follow_all(const Named& named, const TracedPicture<Real>& traced, std::uint64_t paths) {
  const Linear<Real> linear(traced.spheres);
  PathSteps result;
  const std::uint32_t width = named.settings.width;
  for (std::uint64_t i = 0; i < paths; ++i) {
    const auto pixel =
        static_cast<std::uint32_t>(i * 2654435761U % (width * named.settings.height));
    const SampleRandom random(seeded(1), pixel, static_cast<std::uint32_t>(i));
    result.push_back(steps_of(traced, linear, pixel % width, pixel / width, random));
  }
  return result;
}

template <typename Real, typename Store>
PathSteps paths_of(const Named& named, std::uint64_t paths) {
  return follow_all(named, reference_scene<Real, Store>(named.scene, named.settings), paths);
}

PathSteps paths_in(Precision precision, const Named& named, std::uint64_t paths) {
  return precision == Precision::f64     ? paths_of<double, double>(named, paths)
         : precision == Precision::mixed ? paths_of<double, float>(named, paths)
                                         : paths_of<float, float>(named, paths);
}

double share_of_others(const PathSteps& a, const PathSteps& b) {
  double other = 0;
  for (std::size_t i = 0; i < a.size(); ++i) other += a[i] == b[i] ? 0 : 1;
  return other / static_cast<double>(a.size());
}

/// Returns the spheres that at least one path meets first.
std::set<std::uint32_t> spheres_seen(const PathSteps& paths) {
  std::set<std::uint32_t> seen;
  for (const std::vector<Step>& steps : paths) {
    if (!steps.empty()) seen.insert(steps.front().shape);
  }
  return seen;
}

/// Returns the same spheres of the same kinds, without absorption and with a sky of 1.
Scene whitened(Scene scene) {
  scene.sky = {{1, 1, 1}, {1, 1, 1}};
  for (Material& material : scene.materials) {
    material.albedo = {1, 1, 1};
    material.fuzz = 0;
  }
  return scene;
}

/// Returns the largest error of rings on a single ball of albedo 1/2 in the middle of the picture
/// under the sky 0.6 + 0.4 y, in standard errors. The mean of n_y over a ring is 0, so the mean of
/// every ring is 0.3. `radius` is that of the ball's disc, in pixels.
double worst_ring(const Scene& scene, RenderSettings settings, double radius) {
  const std::vector<double> means = means_of(lane_sums(scene, settings), scene, settings);
  double worst = 0;
  for (double inner = 0; inner + 2 <= radius - 1; inner += 2) {
    double sum = 0;
    double pixels = 0;
    for (std::uint32_t pixel = 0; pixel < settings.width * settings.height; ++pixel) {
      const double x = pixel % settings.width + 0.5 - settings.width / 2.0;
      const double y = pixel / settings.width + 0.5 - settings.height / 2.0;
      const double b = std::hypot(x, y);
      if (b >= inner && b < inner + 2) {
        sum += means[3UL * pixel];
        ++pixels;
      }
    }
    // The standard deviation of 0.2 y is at most 0.12.
    worst = std::max(worst, std::abs(sum / pixels - 0.3) /
                                (0.12 / std::sqrt(pixels * settings.samples_per_pixel)));
  }
  return worst;
}

}  // namespace

TEST_CASE("regression: with its precision, every scene follows the same paths as with 113 bits") {
  for (const Named& named : all()) {
    CAPTURE(named.name);
    Named cut = named;
    cut.settings.max_depth = std::min(named.settings.max_depth, 60U);
    const std::uint64_t count = trials(600);
    const PathSteps exactly = follow_all(cut, exact_scene(cut.scene, cut.settings), count);
    const Precision precision = named.settings.precision;
    within(100,
           named.name + ": share of other paths, " + std::string(name_of(precision)) + " (its own)",
           share_of_others(paths_in(precision, cut, count), exactly), 0.02);
    within(100, named.name + ": share of other paths, f64",
           share_of_others(paths_in(Precision::f64, cut, count), exactly), 0.001);
  }
}

TEST_CASE("regression: with its precision, the mean of every scene equals that of f64 to 1e-4") {
  for (const Named& named : all()) {
    CAPTURE(named.name);
    RenderSettings settings = named.settings;
    settings.samples_per_pixel = static_cast<std::uint32_t>(trials(32));
    const ReferenceSums sums = lane_sums(named.scene, settings);
    CHECK(sums.counts.nonfinite == 0);
    CHECK(sums.counts.rays > sums.counts.samples);
    const std::vector<double> own = means_of(sums, named.scene, settings);
    settings.precision = Precision::f64;
    const std::vector<double> exactly =
        means_of(lane_sums(named.scene, settings), named.scene, settings);
    within(100,
           named.name + ": |paired mean difference to f64|, " +
               std::string(name_of(named.settings.precision)) + " (its own)",
           std::abs(mean_difference(own, exactly)), 1e-4);
  }
}

TEST_CASE(
    "regression: without absorption, every sample of every scene is exactly 1 in every precision") {
  for (const Named& named : all()) {
    CAPTURE(named.name);
    const Scene white = whitened(named.scene);
    RenderSettings settings = named.settings;
    settings.width = 24;
    settings.height = 16;
    settings.samples_per_pixel = static_cast<std::uint32_t>(trials(2));
    settings.max_depth = 1U << 20;
    double dark = 0;
    for (const Precision precision : precisions) {
      settings.precision = precision;
      for (const Tracer& tracer : tracers()) {
        for (const PixelSums& pixel : tracer.sums(white, settings).pixels) {
          dark += pixel.sum[0] == std::uint64_t{settings.samples_per_pixel} << 32 ? 0 : 1;
        }
      }
    }
    within(100, named.name + ": pixels of the furnace that are not exactly 1", dark, 0);
  }
}

TEST_CASE("regression: no ring on a ball far from the origin (pbrt-v3 265)") {
  const Named named = load("far-sphere");
  for (const Precision precision : precisions) {
    RenderSettings settings = named.settings;
    settings.precision = precision;
    settings.samples_per_pixel = static_cast<std::uint32_t>(trials(256));
    const double disc = 100 / (3200 * std::tan(4 * std::acos(-1.0) / 360)) * 32;  // in pixels
    within(8, "far ball, " + std::string(name_of(precision)) + ": worst ring / standard errors",
           worst_ring(named.scene, settings, disc), 4.5);
  }
}

TEST_CASE("regression: no ring on a ball seen from 10 to 10 million radii (Mitsuba 3 512)") {
  const Named named = load("distant-eye");
  for (const double distance : {10.0, 100.0, 1e3, 1e4, 1e5, 1e7}) {
    Scene scene = named.scene;
    scene.camera.look_from = distance * normalize(scene.camera.look_from);
    scene.camera.tan_half_vfov = 1.2 / distance;
    RenderSettings settings = named.settings;
    settings.precision = Precision::automatic;
    settings = resolve_settings(requirements_of(scene), settings).settings;
    settings.samples_per_pixel = static_cast<std::uint32_t>(trials(256));
    // From nearby, the rim of the disc is that of the tangent cone.
    const double disc = distance / std::sqrt(distance * distance - 1) / 1.2 * 32;
    within(9,
           "ball from " + std::to_string(static_cast<int>(distance)) + " radii, " +
               std::string(name_of(settings.precision)) +
               " (its own): worst ring / standard errors",
           worst_ring(scene, settings, disc), 4.5);
  }
}

TEST_CASE("regression: particles that differ after the eighth digit are all there (VisIt 1142)") {
  const Named named = load("close-particles");
  for (const Precision precision : precisions) {
    const auto seen = spheres_seen(paths_in(precision, named, 20'000));
    within(100, "close particles, " + std::string(name_of(precision)) + ": not seen",
           static_cast<double>(named.scene.spheres.size() - seen.size()), 0);
  }
}

TEST_CASE("regression: specks of 1e-8 on a ball of 2e-3 are seen and never hang (OSPRay 593)") {
  const Named named = load("radius-ratio");
  double specks = 0;
  for (const std::uint32_t sphere :
       spheres_seen(paths_in(named.settings.precision, named, 20'000))) {
    specks += named.scene.spheres[sphere].radius == 1e-8 ? 1 : 0;
  }
  within(100, "specks not seen, " + std::string(name_of(named.settings.precision)), 12 - specks, 0);
}

TEST_CASE("regression: half a metre above the Earth, everything below the horizon is ground") {
  const Named named = load("earth");
  for (const Precision precision : precisions) {
    RenderSettings settings = named.settings;
    settings.precision = precision;
    settings.max_depth = 1;  // every pixel that is not black shows the sky
    const std::vector<double> means =
        means_of(lane_sums(named.scene, settings), named.scene, settings);
    double sky = 0;
    for (std::size_t i = 3UL * settings.width * (settings.height / 2); i < means.size(); ++i) {
      sky = std::max(sky, means[i]);
    }
    within(6, "earth, " + std::string(name_of(precision)) + ": light from below the horizon", sky,
           0);
  }
}

TEST_CASE("row 27: light in the crevice under a ball is exact; with a t_min it is not") {
  Named named = load("contact");
  RenderSettings settings = named.settings;
  settings.width = picture_width;
  settings.height = picture_height;
  settings.samples_per_pixel = static_cast<std::uint32_t>(trials(200));
  const auto mean_in = [&](Precision precision) {
    settings.precision = precision;
    const auto means = means_of(lane_sums(named.scene, settings), named.scene, settings);
    return std::accumulate(means.begin(), means.end(), 0.0) / static_cast<double>(means.size());
  };
  const auto zoom = [&named](double half) {
    named.scene.camera.tan_half_vfov = half;
    named.scene.camera.vfov = 360 / std::acos(-1.0) * std::atan(half);
  };
  zoom(0.0026);  // 6 mm around the contact
  const double close = mean_in(Precision::f64);
  within(27, "crevice, mixed: |bias|", std::abs(mean_in(Precision::mixed) - close), 1e-4);
  // On a ground of radius 1000, f32 rounds heights to 6e-5, the height of the crevice 5 mm from the
  // contact.
  within(27, "crevice, f32: |bias|", std::abs(mean_in(Precision::f32) - close), 5e-4);

  zoom(0.0009);
  const double closer = mean_in(Precision::f64);
  const auto z_of_textbook = [&](double t_min) {
    const Picture picture = TextbookTracer(named.scene, settings.max_depth, t_min).render(100);
    const auto count = static_cast<double>(picture.size());
    double mean = 0;
    double error_squared = 0;
    for (const Estimate& part : picture) {
      mean += part.mean / count;
      error_squared += part.error_squared / (count * count);
    }
    return std::abs(mean - closer) / std::sqrt(error_squared);
  };
  within(27, "crevice, textbook tracer with t_min 1e-7: |z|", z_of_textbook(1e-7), 5);
  CHECK(z_of_textbook(0.001) > 10);  // an epsilon gives wrong light
}

TEST_CASE("regression: spheres with zero or impossible radii are refused (VisRTX 334)") {
  const auto message = [](const std::string& radius) {
    std::istringstream in(R"({"version": 1, "camera": {"look_from": [0, 0, 9], "look_at": [0, 0, 0],
      "vfov": 30}, "materials": {"a": {"type": "dielectric", "ior": 1.5}}, "spheres": [{"center":
      [0, 0, 0], "radius": )" +
                          radius + R"(, "material": "a"}]})");
    try {
      read_scene(in, "s.json");
      return std::string("no error");
    } catch (const InputError& error) {
      return std::string(error.what());
    }
  };
  for (const std::string radius :
       {"0", "-1", "1e-30", "1e-16", "5e-324", "1e18", "1e400", "NaN", "Infinity"}) {
    CAPTURE(radius);
    CHECK(message(radius).find("s.json:") == 0);
  }
  for (const std::string radius : {"1e-15", "1e15", "1"}) {
    CAPTURE(radius);
    CHECK(message(radius) == "no error");
  }
}

}  // namespace parray::test
