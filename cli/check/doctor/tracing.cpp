#include "cli/check/doctor/tracing.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <exception>
#include <sstream>
#include <utility>
#include <vector>

#include "cli/farm/direct_render.h"
#include "cli/output/text.h"
#include "common/base/error.h"
#include "common/image/image.h"
#include "common/math/float_mode.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/requirements.h"

namespace parray::doctor {

const std::string_view doctor_scene_text = R"({"version": 1,
"camera": {"look_from": [3, 2, 5], "look_at": [0, 0.5, 0], "up": [0, 1, 0], "vfov": 40,
           "aperture": 0.1, "focus_distance": 6},
"image": {"width": 48, "height": 32},
"render": {"samples_per_pixel": 16, "max_depth": 12, "seed": 1},
"sky": {"horizon": [1, 1, 1], "zenith": [0.5, 0.7, 1.0]},
"materials": {"ground": {"type": "diffuse", "albedo": [0.5, 0.5, 0.5]},
              "gold": {"type": "metal", "albedo": [0.8, 0.6, 0.2], "fuzz": 0.1},
              "glass": {"type": "dielectric", "ior": 1.5},
              "bubble": {"type": "dielectric", "ior": 0.6666666666666666}},
"spheres": [{"center": [0, -100, 0], "radius": 100, "material": "ground"},
            {"center": [-1.1, 0.5, 0], "radius": 0.5, "material": "gold"},
            {"center": [0, 0.5, 0], "radius": 0.5, "material": "glass"},
            {"center": [0, 0.5, 0], "radius": 0.4, "material": "bubble"},
            {"center": [1.1, 0.5, 0], "radius": 0.5, "material": "ground"},
            {"center": [0.4, 0.2, 1], "radius": 0.2, "material": "gold"},
            {"center": [-0.5, 0.2, 1.2], "radius": 0.2, "material": "glass"}]}
)";

namespace {

constexpr const char* wrong_bits =
    "use another --isa; if none is right, do not render on this machine: please report it";

constexpr std::array precisions{Precision::f32, Precision::mixed, Precision::f64};
constexpr std::array accelerators{AcceleratorKind::linear, AcceleratorKind::bvh};

struct Sums {
  std::vector<PixelSums> pixels;
  TraceCounts counts;
};

Sums sums_of(const PathTracer& tracer, const RenderSettings& settings) {
  const FloatMode ieee;
  Sums sums{std::vector<PixelSums>(std::size_t{settings.width} * settings.height), {}};
  for (std::uint32_t y = 0; y < settings.height; ++y) {
    tracer.trace({y, 0, settings.width}, {0, settings.samples_per_pixel},
                 std::span(sums.pixels).subspan(std::size_t{y} * settings.width, settings.width),
                 sums.counts);
  }
  return sums;
}

RenderSettings sized(std::uint32_t side, std::uint32_t samples, std::uint32_t depth) {
  RenderSettings settings;
  settings.width = side;
  settings.height = side;
  settings.samples_per_pixel = samples;
  settings.max_depth = depth;
  return settings;
}

/// The names of those among the precisions and accelerators that `wrong` is true of.
std::string wrong_ones(RenderSettings settings,
                       const std::function<bool(const RenderSettings&)>& wrong) {
  std::string names;
  for (const Precision precision : precisions) {
    for (const AcceleratorKind accelerator : accelerators) {
      settings.precision = precision;
      settings.accelerator = accelerator;
      if (wrong(settings)) {
        names += (names.empty() ? "" : ", ") + std::string(name_of(precision)) + " " +
                 std::string(name_of(accelerator));
      }
    }
  }
  return names;
}

/// Whether all samples of all pixels have the radiance `radiance`, a power of two at most 1.
bool all_samples_are(const Sums& sums, double radiance, std::uint64_t samples) {
  const std::uint64_t fixed = RadianceScale(1).to_fixed(radiance);
  PixelSums expected;
  expected.sum.fill(samples * fixed);
  expected.sum_of_squares.fill(samples * RadianceScale::square_of(fixed));
  expected.odd.fill(samples / 2 * fixed);
  return sums.counts.nonfinite == 0 &&
         std::all_of(sums.pixels.begin(), sums.pixels.end(),
                     [&](const PixelSums& pixel) { return pixel == expected; });
}

Scene under_white_sky() {
  Scene scene;
  scene.sky = {{1, 1, 1}, {1, 1, 1}};
  scene.camera.look_from = {0, 0, 6};
  scene.camera.aperture = 0;
  scene.camera.tan_half_vfov = 0.4;
  return scene;
}

/// White, mirror and glass balls that touch, and a bubble in the glass.
Scene white_balls() {
  Scene scene = under_white_sky();
  scene.materials = {{MaterialType::diffuse, {1, 1, 1}, 0, 1},
                     {MaterialType::metal, {1, 1, 1}, 0, 1},
                     {MaterialType::dielectric, {1, 1, 1}, 0, 1.5},
                     {MaterialType::dielectric, {1, 1, 1}, 0, 1 / 1.5}};
  scene.spheres = {
      {{-1, 0, 0}, 1, 0}, {{1, 0, 0}, 1, 1}, {{0, 1.75, 0}, 1, 2}, {{0, 1.75, 0}, 0.875, 3}};
  return scene;
}

Scene closed_ball() {
  Scene scene = under_white_sky();
  scene.camera.look_from = {0.75, 0, 0};
  scene.camera.look_at = {-1, -0.25, 0.25};
  scene.materials = {{MaterialType::diffuse, {1, 1, 1}, 0, 1}};
  scene.spheres = {{{0, 0, 0}, 1, 0}};
  return scene;
}

/// Nothing but a grey ball in the picture.
Scene grey_ball() {
  Scene scene = under_white_sky();
  scene.camera.look_from = {0, 0, 3};
  scene.camera.tan_half_vfov = 0.2;
  scene.materials = {{MaterialType::diffuse, {0.5, 0.5, 0.5}, 0, 1}};
  scene.spheres = {{{0, 0, 0}, 1, 0}};
  return scene;
}

Scene scaled(Scene scene, int k) {
  const auto by = [k](const Vec3d& v) {
    return Vec3d{std::ldexp(v.x, k), std::ldexp(v.y, k), std::ldexp(v.z, k)};
  };
  scene.camera.look_from = by(scene.camera.look_from);
  scene.camera.look_at = by(scene.camera.look_at);
  scene.camera.aperture = std::ldexp(scene.camera.aperture, k);
  scene.camera.focus_distance = std::ldexp(scene.camera.focus_distance, k);
  for (Sphere& sphere : scene.spheres) {
    sphere.center = by(sphere.center);
    sphere.radius = std::ldexp(sphere.radius, k);
  }
  return scene;
}

Sums definition_of(const Scene& scene, const RenderSettings& settings) {
  const FloatMode ieee;
  return sums_of(*make_scalar_tracer(scene, settings), settings);
}

}  // namespace

TracerMaker tracers_of(Isa isa) {
  return [isa](const Scene& scene, RenderSettings settings) {
    settings.isa = isa;
    return make_path_tracer(scene, settings);
  };
}

SceneFile doctor_scene() {
  std::istringstream text{std::string(doctor_scene_text)};
  return read_scene(text, "the doctor's scene");
}

Finding check_picture(const TracerMaker& make, std::string_view expected) {
  std::string wrong;
  for (const AcceleratorKind accelerator : accelerators) {
    const auto insisting = [&](const Scene& scene, RenderSettings settings) {
      settings.accelerator = accelerator;
      return make(scene, settings);
    };
    const std::string found = trace_fingerprint(insisting);
    if (found != expected) {
      wrong += (wrong.empty() ? "" : ", ") + std::string(name_of(accelerator)) + " traces " +
               found.substr(0, 16);
    }
  }
  if (wrong.empty()) {
    return passed("the built-in picture has its bits in f32, mixed and f64, linear and bvh");
  }
  return failed("the built-in picture is not " + std::string(expected.substr(0, 16)) + ": " + wrong,
                wrong_bits);
}

Finding check_furnaces(const TracerMaker& make) {
  const RenderSettings open = sized(24, 8, 1U << 16);
  const RenderSettings closed = sized(8, 2, 1000);
  const Scene balls = white_balls();
  const Scene ball = closed_ball();
  std::uint64_t bounces = 0;
  const std::string dark = wrong_ones(open, [&](const RenderSettings& settings) {
    const Sums sums = sums_of(*make(balls, settings), settings);
    return !all_samples_are(sums, 1, settings.samples_per_pixel);
  });
  const std::string leaky = wrong_ones(closed, [&](const RenderSettings& settings) {
    const Sums sums = sums_of(*make(ball, settings), settings);
    bounces += sums.counts.rays;
    return !all_samples_are(sums, 0, settings.samples_per_pixel) ||
           sums.counts.rays != sums.counts.samples * settings.max_depth;
  });
  if (dark.empty() && leaky.empty()) {
    return passed("white furnace exactly 1, closed ball exactly 0 after " +
                  with_unit(static_cast<double>(bounces), "bounces"));
  }
  return failed((dark.empty() ? "" : "white furnace not exactly 1 in " + dark) +
                    (dark.empty() || leaky.empty() ? "" : "; ") +
                    (leaky.empty() ? "" : "closed ball not exactly 0 in " + leaky),
                wrong_bits);
}

Finding check_self_hits(const TracerMaker& make) {
  const Scene ball = grey_ball();
  std::uint64_t paths = 0;
  const std::string wrong = wrong_ones(sized(32, 16, 50), [&](const RenderSettings& settings) {
    const Sums sums = sums_of(*make(ball, settings), settings);
    paths += sums.counts.samples;
    return sums.counts.rays != 2 * sums.counts.samples ||
           !all_samples_are(sums, 0.5, settings.samples_per_pixel);
  });
  return wrong.empty() ? passed("none in " + counted(paths, "path"))
                       : failed("paths meet the surface that they leave in " + wrong, wrong_bits);
}

Finding check_scaling(const TracerMaker& make) {
  const Scene scene = doctor_scene().scene;
  const std::string wrong = wrong_ones(sized(24, 2, 12), [&](const RenderSettings& settings) {
    const auto expected = definition_of(scene, settings).pixels;
    const auto differs = [&](int k) {
      const Scene here = scaled(scene, k);
      return sums_of(*make(here, settings), settings).pixels != expected;
    };
    return differs(-40) || differs(0) || differs(40);
  });
  return wrong.empty()
             ? passed("scaled by 2^-40, 1 and 2^40, a picture has the bits of its definition")
             : failed("a scaled picture does not have the bits of its definition in " + wrong,
                      wrong_bits);
}

std::string doctor_image_sha256(const TracerMaker& make, int threads) {
  const SceneFile file = doctor_scene();
  const RenderSettings settings =
      resolve_settings(requirements_of(file.scene), file.settings).settings;
  const std::atomic<bool> stop = false;
  const auto picture =
      render_directly(*make(file.scene, settings), file.scene, settings, threads, stop);
  return image_sha256(resolve_image(picture->framebuffer, picture->largest_radiance));
}

Finding check_threads(const TracerMaker& make, int threads) {
  const std::string alone = doctor_image_sha256(make, 1);
  const std::array others{doctor_image_sha256(make, threads), doctor_image_sha256(make, 1),
                          doctor_image_sha256(make, threads)};
  const auto count = counted(static_cast<std::uint64_t>(threads), "thread");
  if (std::all_of(others.begin(), others.end(),
                  [&](const std::string& other) { return other == alone; })) {
    return passed("1 thread and " + count +
                  " make the same picture, twice: " + alone.substr(0, 16));
  }
  return failed("pictures of 1 thread and " + count + " differ",
                "test the machine's memory, and take back any overclocking");
}

Finding check_repetition(const std::function<std::string()>& picture, int times, int threads) {
  const std::string expected = picture();
  std::uint64_t different = 0;
  std::atomic<bool> thrown = false;
#pragma omp parallel for num_threads(threads) schedule(static) reduction(+ : different)
  for (int i = 0; i < times * threads; ++i) {
    try {
      different += picture() == expected ? 0 : 1;
    } catch (const std::exception&) {  // must not leave the team
      thrown = true;
    }
  }
  if (thrown) throw RunError("tracing the built-in picture failed: out of memory?");
  const auto total = static_cast<std::uint64_t>(times) * static_cast<std::uint64_t>(threads);
  const std::string text = counted(total, "time") + " on " +
                           counted(static_cast<std::uint64_t>(threads), "thread") + " at once";
  return different == 0
             ? passed("the same picture " + text)
             : failed(std::to_string(different) + " other pictures, of the same one traced " + text,
                      "test the machine's memory, and take back any overclocking");
}

}  // namespace parray::doctor
