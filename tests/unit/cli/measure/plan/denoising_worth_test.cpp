#include "cli/measure/plan/denoising_worth.h"

#include <doctest/doctest.h>

#include "common/scene/settings.h"
#include "tests/support/rooms.h"

namespace parray::test {
namespace {

RenderSettings asked(std::uint32_t samples, double target = 0) {
  RenderSettings settings;
  settings.samples_per_pixel = samples;
  settings.target_error = target;
  return settings;
}

/// 8 samples per pixel of two scenes that ship, 300 x 200 pixels.
constexpr DenoisingProbe lens{8, 0.0259, 0.0181, 15};
constexpr DenoisingProbe molecule{8, 0.0400, 0.0055, 15};

}  // namespace

TEST_CASE("denoising pays if it reduces the error more than samples do in the same time") {
  CHECK_FALSE(foresee_denoising(lens, asked(8), 0).pays());
  CHECK(foresee_denoising(molecule, asked(8), 0).pays());
  DenoisingProbe slow = molecule;
  slow.samples_instead = 1000;
  CHECK_FALSE(foresee_denoising(slow, asked(8), 0).pays());
  DenoisingProbe free = lens;
  free.samples_instead = 0;
  CHECK(foresee_denoising(free, asked(8), 0).pays());
}

TEST_CASE("the prediction is for the number of samples in the settings") {
  const DenoisingWorth worth = foresee_denoising(molecule, asked(8), 0);
  CHECK(worth.samples == 8);
  CHECK(worth.denoised == doctest::Approx(0.0055));
  CHECK(worth.undenoised < 0.0400);
  CHECK(foresee_denoising(molecule, asked(1000), 100).samples == 100 - 15);
  CHECK(foresee_denoising(molecule, asked(1000), 3).samples == 2);
  const DenoisingWorth met = foresee_denoising(molecule, asked(100000, 0.002), 0);
  CHECK(met.denoised == doctest::Approx(0.002).epsilon(0.01));
  CHECK(met.samples > 8);
}

TEST_CASE(
    "denoising reduces the error less if there are more samples, as measured for five scenes") {
  double last = 0;
  for (const std::uint32_t samples : {8U, 32U, 128U, 512U}) {
    DenoisingProbe probe = molecule;
    probe.samples_instead = 0;
    const DenoisingWorth worth = foresee_denoising(probe, asked(samples), 0);
    const double left = worth.denoised / worth.undenoised;
    CHECK(left > last);
    CHECK(left < 1);
    last = left;
  }
}

}  // namespace parray::test
