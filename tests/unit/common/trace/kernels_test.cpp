#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "tests/support/dice.h"
#include "tests/support/lane_search.h"
#include "tests/support/precisions.h"
#include "tests/support/reference_tracer.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/shipped_scene.h"
#include "tests/support/tracers.h"

/// The lane kernels' sums against those of the scalar reference, to the last bit.
namespace parray::test {
namespace {

/// small_scene() with every sphere of one material.
Scene all_of(const Material& material) {
  Scene scene = small_scene();
  scene.materials = {material};
  for (Sphere& sphere : scene.spheres) sphere.material = 0;
  return scene;
}

/// The lens reaches across the walls of two glass shells, and one sphere is metal.
Scene lens_in_glass() {
  Scene scene = small_scene();
  scene.camera.aperture = 0.5;
  const Vec3d eye = scene.camera.look_from;
  scene.spheres.push_back({eye, 0.2, 2});
  scene.spheres.push_back({eye + Vec3d{0.1, 0, 0}, 0.6, 3});
  scene.spheres.push_back({eye - Vec3d{0, 0, 0.3}, 0.4, 1});
  scene.spheres.push_back({eye + Vec3d{0, 0.3, 0}, 0.2, 2});  // only the lens's rim reaches it
  return scene;
}

/// Glass balls, each there three times, all around a point: paths are inside of many at once.
Scene crowded_glass() {
  Scene scene = small_scene();
  Dice dice(4);
  for (int i = 0; i < 30; ++i) {
    const Vec3d center = dice.in_cube(1.5);
    const double radius = dice.between(0.3, 2);
    for (int copy = 0; copy < 3; ++copy) scene.spheres.push_back({center, radius, 2});
  }
  return scene;
}

/// Sticks of all materials among spheres: long and short ones, without length, along the axes, and
/// some of them twice.
Scene sticks(std::uint32_t count) {
  Scene scene = small_scene();
  Dice dice(17);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3d from = dice.in_cube(2.5) + Vec3d{0, 1.5, 0};
    const Vec3d along = dice.one_in(4) ? Vec3d{0, 0, 1} : dice.direction();
    const double length = dice.one_in(8) ? 0 : dice.ten_to(-3, 0.3);
    scene.capsules.push_back({from, from + length * along, dice.ten_to(-2, -0.5), i % 4});
    if (dice.one_in(16)) scene.capsules.push_back(scene.capsules.back());
  }
  return scene;
}

/// The lens reaches across the walls of two glass sticks, and of one that is metal.
Scene lens_in_sticks() {
  Scene scene = sticks(40);
  scene.camera.aperture = 0.5;
  const Vec3d eye = scene.camera.look_from;
  scene.capsules.push_back({eye, eye + Vec3d{1, 0, 0}, 0.2, 2});
  scene.capsules.push_back({eye + Vec3d{0.1, 1, 0}, eye - Vec3d{0.1, 1, 0}, 0.3, 3});
  scene.capsules.push_back({eye - Vec3d{0, 0, 0.3}, eye - Vec3d{0, 1, 0.3}, 0.2, 1});
  return scene;
}

/// Very many small spheres around a point, and some large ones around them.
Scene cut_crowd() {
  Scene scene = small_scene();
  Dice dice(9);
  for (int i = 0; i < 3000; ++i) {
    scene.spheres.push_back({dice.in_cube(4), dice.between(0.02, 0.3), i % 2 == 0 ? 0U : 1U});
  }
  for (int i = 0; i < 9; ++i) scene.spheres.push_back({dice.in_cube(1), 6, 2});
  return scene;
}

/// Seen by parallel rays: as high as `view_height`, from so far.
Scene seen_by_parallel_rays(Scene scene, double view_height, double distance = 13) {
  Camera& camera = scene.camera;
  const Vec3d back = normalize(camera.look_from - camera.look_at);
  camera.look_from = camera.look_at + distance * back;
  camera.projection = Projection::orthographic;
  camera.view_height = view_height;
  camera.vfov = camera.tan_half_vfov = 0;
  return scene;
}

struct NamedScene {
  std::string name;
  Scene scene;
};

std::vector<NamedScene> scenes() {
  std::vector<NamedScene> result;
  result.push_back({"small", small_scene()});
  result.push_back({"one weekend", shipped("one-weekend-20.json").scene});
  result.push_back({"one weekend, a deep tree", shipped("one-weekend-484.json").scene});
  result.push_back({"glass", shipped("glass.json").scene});
  result.push_back({"shells", shipped("shells.json").scene});
  result.push_back({"lens in glass", lens_in_glass()});
  result.push_back({"crowded glass", crowded_glass()});
  result.push_back({"glass in the same glass", crowded_glass()});
  for (Sphere& sphere : result.back().scene.spheres) sphere.material = 2;
  result.push_back({"diffuse only", all_of({MaterialType::diffuse, {0.5, 0.9, 0.1}, 0, 1})});
  result.push_back({"mirrors only", all_of({MaterialType::metal, {0.9, 0.8, 1}, 0, 1})});
  result.push_back({"fuzz only", all_of({MaterialType::metal, {0.9, 0.8, 1}, 1, 1})});
  result.push_back({"pinhole", small_scene()});
  result.back().scene.camera.aperture = 0;
  result.push_back({"no spheres", small_scene()});
  result.back().scene.spheres.clear();
  result.push_back({"nothing at all", {}});
  result.back().scene.camera.tan_half_vfov = 0.3;
  result.push_back({"one sphere", small_scene()});
  result.back().scene.spheres.resize(1);
  result.push_back({"orthographic, a lens", seen_by_parallel_rays(small_scene(), 4)});
  result.push_back({"orthographic, a deep tree",
                    seen_by_parallel_rays(shipped("one-weekend-484.json").scene, 6)});
  result.back().scene.camera.aperture = 0;
  result.push_back(
      {"shells cut by the camera", seen_by_parallel_rays(shipped("shells.json").scene, 3, 0.01)});
  result.push_back({"a crowd cut by the camera", seen_by_parallel_rays(crowded_glass(), 5, 0.3)});
  result.back().scene.camera.aperture = 0.4;
  result.push_back({"matt spheres cut by the camera", seen_by_parallel_rays(cut_crowd(), 8, 0.2)});
  result.push_back({"sticks", sticks(300)});
  result.push_back({"one stick", sticks(1)});
  result.push_back({"sticks alone", sticks(30)});
  result.back().scene.spheres.clear();
  result.push_back({"sticks of one matt material", sticks(100)});
  result.back().scene.materials.resize(1);
  for (Sphere& sphere : result.back().scene.spheres) sphere.material = 0;
  for (Capsule& capsule : result.back().scene.capsules) capsule.material = 0;
  result.push_back({"lens in sticks", lens_in_sticks()});
  result.push_back({"sticks cut by the camera", seen_by_parallel_rays(sticks(300), 5, 0.3)});
  result.push_back({"no number", small_scene()});
  result.back().scene.camera.focus_distance = 1e-300;  // no reader accepts it
  return result;
}

RenderSettings kernel_settings(Precision precision) {
  RenderSettings settings;
  settings.width = 37;  // no multiple of any width of lanes
  settings.height = 4;
  settings.samples_per_pixel = 5;
  settings.max_depth = 12;
  settings.seed = 0x123456789ABCDEF;
  settings.precision = precision;
  return settings;
}

/// `check` for a scene's tracers of every instruction set and accelerator, for what it holds and
/// with everything that a scene could contain.
void for_all_kernels(const Scene& scene, RenderSettings settings,
                     const std::function<void(const PathTracer&)>& check) {
  for (const Isa isa : instruction_sets()) {
    for (const AcceleratorKind accelerator : accelerators) {
      for (const bool general : {false, true}) {
        CAPTURE(name_of(isa));
        CAPTURE(name_of(accelerator));
        CAPTURE(general);
        const bool scalar = accelerator == AcceleratorKind::octree;  // whatever is asked for
        if (scalar && (isa != Isa::scalar || general)) continue;
        settings.isa = isa;
        settings.accelerator = accelerator;
        const auto tracer =
            make_path_tracer(make_accelerator(scene, settings.precision, accelerator, isa),
                             scene.camera, settings, general);
        CHECK(tracer->isa() == name_of(isa));
        check(*tracer);
      }
    }
  }
}

/// What path.h says that the camera rays of a picture meet: pixel after pixel, in each sample after
/// sample.
template <typename Real, typename Store>
std::vector<FirstHit> reference_hits_in(const Scene& scene, const RenderSettings& settings) {
  const TracedPicture<Real> traced = reference_scene<Real, Store>(scene, settings);
  const Linear<Real> linear(traced.spheres);
  std::vector<FirstHit> hits;
  InsideStack<Real> sides;
  for (std::uint32_t pixel = 0; pixel < settings.width * settings.height; ++pixel) {
    for (std::uint32_t s = 0; s < settings.samples_per_pixel; ++s) {
      const SampleRandom random(settings.seed, pixel, s, settings.sampler);
      const Ray<Real> ray =
          traced.view.template ray<Real>(pixel % settings.width, pixel / settings.width, random);
      start_sides(traced, traced, pixel % settings.width, pixel / settings.width, ray.origin,
                  sides);
      const Hit<Real> hit = first_crossing(traced, linear, ray, sides);
      FirstHit& first = hits.emplace_back();
      first.direction = vec_cast<double>(ray.direction);
      if (hit.shape == no_shape) continue;
      const Vec3d outward = vec_cast<double>(surface_point(traced, ray, sides, hit).normal);
      first = {hit.shape, static_cast<double>(hit.t), vec_cast<double>(ray.direction),
               hit.leaving ? -outward : outward};
    }
  }
  return hits;
}

bool any_nan(const Vec3d& v) { return std::isnan(v.x) || std::isnan(v.y) || std::isnan(v.z); }

/// The direction of a camera that has none is no number, in both.
bool same_hit(FirstHit a, FirstHit b) {
  if (any_nan(a.direction) && any_nan(b.direction)) a.direction = b.direction = {};
  return a == b;
}

std::vector<FirstHit> reference_hits(const Scene& scene, const RenderSettings& settings) {
  switch (settings.precision) {
    case Precision::f64: return reference_hits_in<double, double>(scene, settings);
    case Precision::mixed: return reference_hits_in<double, float>(scene, settings);
    default: return reference_hits_in<float, float>(scene, settings);
  }
}

/// Cuts pixels and samples in two at random, again and again, and traces the pieces.
void trace_in_pieces(const PathTracer& tracer, const PixelRun& run, const SampleRange& samples,
                     std::span<PixelSums> sums, TraceCounts& counts, Dice& dice) {
  const std::uint32_t columns = run.x_end - run.x_begin;
  if (dice.one_in(4) || (columns < 2 && samples.count() < 2)) {
    tracer.trace(run, samples, sums, counts);
  } else if (samples.count() < 2 || (columns > 1 && dice.one_in(2))) {
    const std::uint32_t cut = 1 + dice.below32(columns - 1);
    trace_in_pieces(tracer, {run.y, run.x_begin + cut, run.x_end}, samples, sums.subspan(cut),
                    counts, dice);
    trace_in_pieces(tracer, {run.y, run.x_begin, run.x_begin + cut}, samples, sums.first(cut),
                    counts, dice);
  } else {
    const std::uint32_t cut = samples.begin + 1 + dice.below32(samples.count() - 1);
    trace_in_pieces(tracer, run, {cut, samples.end}, sums, counts, dice);
    trace_in_pieces(tracer, run, {samples.begin, cut}, sums, counts, dice);
  }
}

}  // namespace

TEST_CASE("every kernel's sums and counts are those of the scalar reference") {
  for (const NamedScene& named : scenes()) {
    CAPTURE(named.name);
    for (const Precision precision : precisions) {
      CAPTURE(name_of(precision));
      for (const Sampler sampler : {Sampler::independent, Sampler::sobol}) {
        CAPTURE(name_of(sampler));
        RenderSettings settings = kernel_settings(precision);
        settings.sampler = sampler;
        const ReferenceSums expected = reference_sums(named.scene, settings);
        for_all_kernels(named.scene, settings, [&](const PathTracer& tracer) {
          const ReferenceSums found = sums_of(tracer, settings);
          CHECK(found.counts.samples == expected.counts.samples);
          CHECK(found.counts.rays == expected.counts.rays);
          CHECK(found.counts.nonfinite == expected.counts.nonfinite);
          CHECK_UNARY(found.pixels == expected.pixels);
        });
      }
    }
  }
}

TEST_CASE("every kernel's camera rays meet what the scalar reference's meet") {
  for (const NamedScene& named : scenes()) {
    CAPTURE(named.name);
    for (const Precision precision : precisions) {
      CAPTURE(name_of(precision));
      const RenderSettings settings = kernel_settings(precision);
      const auto expected = reference_hits(named.scene, settings);
      for_all_kernels(named.scene, settings, [&](const PathTracer& tracer) {
        const std::size_t in_row = std::size_t{settings.width} * settings.samples_per_pixel;
        std::vector<FirstHit> found(expected.size());
        for (std::uint32_t y = 0; y < settings.height; ++y) {
          tracer.first_hits({y, 0, settings.width}, {0, settings.samples_per_pixel},
                            std::span(found).subspan(y * in_row, in_row));
        }
        CHECK_UNARY(std::ranges::equal(found, expected, same_hit));
      });
    }
  }
}

TEST_CASE("every kernel's background is what the scalar reference's rays do not meet") {
  for (const NamedScene& named : scenes()) {
    CAPTURE(named.name);
    if (named.name == "no number") continue;
    for (const Precision precision : precisions) {
      CAPTURE(name_of(precision));
      RenderSettings settings = kernel_settings(precision);
      const auto expected = reference_hits(named.scene, settings);
      settings.max_depth = 1;  // what a picture of camera rays alone adds up
      const ReferenceSums sums = reference_sums(named.scene, settings);
      for_all_kernels(named.scene, settings, [&](const PathTracer& tracer) {
        bool same = true;
        for (std::uint32_t y = 0; y < settings.height; ++y) {
          std::vector<SkySamples> sky(settings.width);
          const SampleRange all{0, settings.samples_per_pixel};
          tracer.add_sky_samples({y, 0, settings.width}, RunSamples(all), sky);
          for (std::uint32_t x = 0; x < settings.width; ++x) {
            const std::size_t pixel = std::size_t{y} * settings.width + x;
            const auto hits = std::span(expected).subspan(pixel * all.count(), all.count());
            const auto missed = std::ranges::count(hits, no_shape, &FirstHit::shape);
            same = same && sky[x].count == missed && sky[x].sum == sums.pixels[pixel].sum;
          }
        }
        CHECK_UNARY(same);
      });
    }
  }
}

TEST_CASE("what camera rays meet depends on pixel and sample, not on the run that asks") {
  const Scene scene = lens_in_glass();
  const RenderSettings settings = kernel_settings(Precision::f32);
  const auto expected = reference_hits(scene, settings);
  for_all_kernels(scene, settings, [&](const PathTracer& tracer) {
    std::vector<FirstHit> found(3 * 2);
    tracer.first_hits({3, 30, 33}, {2, 4}, found);
    for (std::size_t i = 0; i < found.size(); ++i) {
      const std::size_t pixel = 3 * settings.width + 30 + i / 2;
      CHECK(found[i] == expected[pixel * settings.samples_per_pixel + 2 + i % 2]);
    }
  });
}

TEST_CASE("the reference's scenes show what their names say") {
  const RenderSettings settings = kernel_settings(Precision::f32);
  for (const NamedScene& named : scenes()) {
    CAPTURE(named.name);
    const TraceCounts counts = reference_sums(named.scene, settings).counts;
    const bool empty = named.scene.spheres.empty() && named.scene.capsules.empty();
    const bool no_number = named.name == "no number";
    CHECK((counts.rays > counts.samples) == (!empty && !no_number));
    CHECK((counts.nonfinite > 0) == no_number);
  }
}

TEST_CASE("paths as long as a picture allows are cut off where the reference cuts them") {
  for (const std::uint32_t depth : {1U, 2U, 3U, 200U}) {
    CAPTURE(depth);
    RenderSettings settings = kernel_settings(Precision::f32);
    settings.max_depth = depth;
    const ReferenceSums expected = reference_sums(crowded_glass(), settings);
    for_all_kernels(crowded_glass(), settings, [&](const PathTracer& tracer) {
      CHECK_UNARY(sums_of(tracer, settings) == expected);
    });
  }
}

TEST_CASE("any split of pixels and samples gives the same sums") {
  Dice dice(5);
  const Scene scene = lens_in_glass();
  for (const Precision precision : precisions) {
    CAPTURE(name_of(precision));
    RenderSettings settings = kernel_settings(precision);
    settings.height = 3;
    settings.samples_per_pixel = 40;
    const ReferenceSums expected = reference_sums(scene, settings);
    for_all_kernels(scene, settings, [&](const PathTracer& tracer) {
      ReferenceSums found{std::vector<PixelSums>(expected.pixels.size()), {}};
      for (std::uint32_t y = 0; y < settings.height; ++y) {
        const auto row =
            std::span(found.pixels).subspan(std::size_t{y} * settings.width, settings.width);
        trace_in_pieces(tracer, {y, 0, settings.width}, {0, settings.samples_per_pixel}, row,
                        found.counts, dice);
      }
      CHECK_UNARY(found == expected);
    });
  }
}

TEST_CASE("runs of one sample a pixel and of one pixel fill batches alike") {
  const Scene scene = small_scene();
  for (const Precision precision : precisions) {
    CAPTURE(name_of(precision));
    RenderSettings settings = kernel_settings(precision);
    settings.height = 1;
    using Size = std::pair<std::uint32_t, std::uint32_t>;
    constexpr std::uint32_t most = SampleBatch::most;
    for (const Size& size : {Size(700, 1), Size(1, 700), Size(3, most / 2), Size(most, 1),
                             Size(1, most), Size(1, most + 1)}) {
      CAPTURE(size.first);
      settings.width = size.first;
      settings.samples_per_pixel = size.second;
      const ReferenceSums expected = reference_sums(scene, settings);
      for_all_kernels(scene, settings, [&](const PathTracer& tracer) {
        CHECK_UNARY(sums_of(tracer, settings) == expected);
      });
    }
  }
}

}  // namespace parray::test
