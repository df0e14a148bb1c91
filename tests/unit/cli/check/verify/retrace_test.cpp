#include "cli/check/verify/retrace.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "common/image/image.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"

namespace parray {
namespace {

/// Radiance 0.5, but for odd samples of odd columns, which are not finite.
class HoleyTracer final : public PathTracer {
 public:
  HoleyTracer()
      : PathTracer(make_accelerator({}, Precision::f32, AcceleratorKind::linear, Isa::automatic)) {}

  void trace_run(const PixelRun& run, const RunSamples& samples, std::span<PixelSums> sums,
                 TraceCounts& counts) const override {
    for (std::uint32_t x = run.x_begin; x < run.x_end; ++x) {
      const SampleRange range = samples[x - run.x_begin];
      for (std::uint32_t s = range.begin; s < range.end; ++s) {
        const bool hole = (x & s & 1U) == 1;
        const double value = hole ? std::numeric_limits<double>::quiet_NaN() : 0.5;
        add_sample({value, value, value}, RadianceScale(1), s, sums[x - run.x_begin], counts);
      }
    }
  }
  void first_hits(const PixelRun& /*run*/, const SampleRange& /*samples*/,
                  std::span<FirstHit> /*hits*/) const override {}
  void add_sky_samples(const PixelRun& /*run*/, const RunSamples& /*samples*/,
                       std::span<SkySamples> /*sky*/) const override {}
};

}  // namespace

TEST_CASE(
    "pixels traced again alone have the picture's bits, each with samples of its own number") {
  const Scene scene = test::small_scene();
  const RenderSettings settings = test::small_settings(scene);
  const auto tracer = make_path_tracer(scene, settings);
  const RadianceScale scale(largest_radiance(scene));
  std::vector<RetracedPixel> pixels;
  for (const std::uint64_t place : choose(40, std::uint64_t{settings.width} * settings.height, 3)) {
    pixels.push_back({static_cast<std::uint32_t>(place % settings.width),
                      static_cast<std::uint32_t>(place / settings.width),
                      1 + static_cast<std::uint32_t>(place % 7)});
  }
  retrace(*tracer, scale, pixels, 3);
  for (const RetracedPixel& pixel : pixels) {
    PixelSums sums;
    TraceCounts counts;
    tracer->trace({pixel.y, pixel.x, pixel.x + 1}, {0, pixel.samples}, {&sums, 1}, counts);
    CHECK(pixel.mean == mean_radiance(sums, pixel.samples, scale));
  }
}

TEST_CASE("samples that are not finite are left out only of their own pixel") {
  std::vector<RetracedPixel> pixels;
  for (std::uint32_t x = 0; x < 6; ++x) pixels.push_back({x, 0, 8});
  pixels[5].samples = 0;
  retrace(HoleyTracer(), RadianceScale(1), pixels, 2);
  for (const RetracedPixel& pixel : pixels) {
    CHECK(pixel.mean[0] == (pixel.samples == 0 ? 0.0F : 0.5F));
  }
}

TEST_CASE(
    "chosen pixels are distinct and sorted, depend only on the seed, and are uniformly "
    "distributed") {
  CHECK(choose(5, 3, 1) == std::vector<std::uint64_t>{0, 1, 2});
  CHECK(choose(299, 100000, 1) == choose(299, 100000, 1));
  CHECK(choose(299, 100000, 1) != choose(299, 100000, 2));
  std::vector<int> seen(10);
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    const auto chosen = choose(3, 10, seed);
    REQUIRE(chosen.size() == 3);
    CHECK(std::set(chosen.begin(), chosen.end()).size() == 3);
    CHECK(std::is_sorted(chosen.begin(), chosen.end()));
    for (const std::uint64_t place : chosen) ++seen.at(place);
  }
  for (const int times : seen) {  // 900 of 3000, 5 standard deviations
    CHECK(std::abs(times - 900) < 126);
  }
}

TEST_CASE("299 pixels find 1 % of wrong pixels with a probability of 95 %") {
  CHECK(share_found(299) < 0.01);
  CHECK(share_found(298) > 0.01);
  // Wrong are the first hundredth of 10000.
  int found = 0;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    found += choose(299, 10000, seed).front() < 100 ? 1 : 0;
  }
  CHECK(found > 1850);
  CHECK(found < 1950);  // 1905 expected, with a standard deviation of 9.5
}

}  // namespace parray
