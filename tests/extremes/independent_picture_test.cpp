// Compares pictures with a render in double precision with many samples, linear search and another
// seed, and with a simple textbook tracer that shares no code with ParRay. Means of blocks must
// agree within 5 standard errors.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <vector>

#include "common/scene/largest_radiance.h"
#include "common/scene/requirements.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "tests/support/rooms.h"
#include "tests/support/shipped_scene.h"
#include "tests/support/textbook_tracer.h"

namespace parray::test {
namespace {

Picture our_picture(const Scene& scene, RenderSettings settings) {
  settings.width = picture_width;
  settings.height = picture_height;
  settings = resolve_settings(requirements_of(scene), settings).settings;
  const auto tracer = make_path_tracer(scene, settings);
  const RadianceScale scale(largest_radiance(scene));
  const std::uint32_t n = settings.samples_per_pixel;
  Accumulator result;
  for (std::uint32_t y = 0; y < picture_height; ++y) {
    std::vector<PixelSums> sums(picture_width);
    TraceCounts counts;
    tracer->trace({y, 0, picture_width}, {0, n}, sums, counts);
    for (std::uint32_t x = 0; x < picture_width; ++x) {
      std::array<double, 3> mean{};
      std::array<double, 3> square{};
      for (std::size_t c = 0; c < 3; ++c) {
        mean[c] = scale.mean(sums[x].sum[c], n);
        square[c] = scale.mean_square(sums[x].sum_of_squares[c], n);
      }
      result.add(x, y, mean, square, n);
    }
  }
  return result.take();
}

}  // namespace

TEST_CASE("f32 over the BVH agrees with f64 by linear search and another seed") {
  const Scene scene = shipped("one-weekend-484.json").scene;
  RenderSettings quick;
  quick.samples_per_pixel = 256;
  quick.precision = Precision::f32;
  quick.accelerator = AcceleratorKind::bvh;
  RenderSettings careful;
  careful.samples_per_pixel = 512;
  careful.precision = Precision::f64;
  careful.accelerator = AcceleratorKind::linear;
  careful.seed = 987654321;
  const double worst = worst_deviation(our_picture(scene, quick), our_picture(scene, careful));
  MESSAGE("worst block: " << worst << " standard errors");
  CHECK(worst < 5);
}

TEST_CASE("pictures agree with a textbook tracer that shares no tracing code") {
  for (const std::string name : {"one-weekend-20.json", "glass.json", "shells.json"}) {
    CAPTURE(name);
    const Scene scene = shipped(name).scene;
    RenderSettings settings;
    settings.samples_per_pixel = 500;
    settings.max_depth = 12;
    const Picture ours = our_picture(scene, settings);
    const Picture theirs = TextbookTracer(scene, settings.max_depth).render(500);
    const double worst = worst_deviation(ours, theirs);
    MESSAGE(name << ": worst block " << worst << " standard errors");
    CHECK(worst < 5);
  }
}

TEST_CASE("the comparison notices a wrong picture") {
  const Scene scene = shipped("one-weekend-20.json").scene;
  RenderSettings settings;
  settings.samples_per_pixel = 500;
  Scene other = scene;
  for (Material& material : other.materials) {
    material.albedo = 0.98 * material.albedo;  // two percent darker
  }
  CHECK(worst_deviation(our_picture(scene, settings), our_picture(other, settings)) > 5);
}

}  // namespace parray::test
