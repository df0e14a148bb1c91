// Row 46 of the table of numerical extremes: stated errors are true. tests/experiments/coverage
// tests more pictures.
#include "tests/support/coverage.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "common/scene/largest_radiance.h"
#include "common/scene/settings.h"
#include "tests/support/rooms.h"

namespace parray::test {
namespace {

TEST_CASE("row 46: stated errors hold, for both samplers, with uniform and with adaptive passes") {
  constexpr std::uint64_t seeds = 8;
  const std::vector<NoisyScene> scenes = noisy_scenes(32, 24);
  std::vector<Reference> references;
  for (const NoisyScene& scene : scenes) references.push_back(trace_reference(scene, 3072));
  for (const Sampler sampler : {Sampler::independent, Sampler::sobol}) {
    for (const bool adaptive : {false, true}) {
      CAPTURE(std::string(name_of(sampler)));
      CAPTURE(adaptive);
      Coverage coverage(references);
      for (std::size_t i = 0; i < scenes.size(); ++i) {
        for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
          RenderSettings settings = scenes[i].settings;
          settings.seed = seed;
          settings.samples_per_pixel = 64;
          settings.sampler = sampler;
          settings.adaptive = adaptive;
          const auto tracer = make_path_tracer(scenes[i].scene, settings);
          GrowingPicture picture(settings, largest_radiance(scenes[i].scene));
          grow_in_passes(settings, picture, [&](const std::vector<std::uint32_t>& until) {
            picture.trace(*tracer, until);
          });
          coverage.add(i, picture, estimate_error(picture.state()));
        }
      }
      CHECK(coverage.pooled() > 0.93);
      CHECK(coverage.pooled() < 0.97);
      CHECK(coverage.least_of_strata() > 0.88);
      CHECK(coverage.pictures() > 0.88);
      CHECK(coverage.claimed_to_true() == doctest::Approx(1).epsilon(0.03));
    }
  }
}

}  // namespace
}  // namespace parray::test
