// Checks that the choice of `precision: auto` shows no rounding: compares generated extreme scenes
// with f64 (tests/support/paired_pictures.h).
#include <doctest/doctest.h>

#include <algorithm>
#include <string>

#include "common/scene/requirements.h"
#include "common/scene/settings.h"
#include "tests/support/extreme_scenes.h"
#include "tests/support/extremes.h"
#include "tests/support/paired_pictures.h"
#include "tests/support/rooms.h"

namespace parray::test {
namespace {

RenderSettings small_picture(const Scene& scene) {
  RenderSettings settings;
  settings.width = 48;
  settings.height = 32;
  settings.max_depth = 12;
  return resolve_settings(requirements_of(scene), settings).settings;
}

}  // namespace

TEST_CASE(
    "precision auto: on generated extremes it differs from f64 by less than 4096 samples' noise") {
  const ExtremeScenes scenes(seeded(1));
  const std::uint64_t count = environment_number("PARRAY_PRECISION_SCENES", 22);
  double worst = 0;
  double nonfinite = 0;
  std::uint64_t single = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    const ExtremeScene extreme = scenes.make(i);
    CAPTURE(i);
    CAPTURE(extreme.kind);
    const RenderSettings settings = small_picture(extreme.scene);
    single += settings.precision == Precision::f32 ? 1U : 0U;
    if (settings.precision == Precision::f64) {
      continue;  // the same picture
    }
    PairedPictures pictures(extreme.scene, settings, settings.precision);
    const PairedDifference difference = pictures.decide();
    CHECK(difference.least < 1);
    worst = std::max(worst, difference.least);
    nonfinite += static_cast<double>(pictures.nonfinite());
  }
  within(44, "auto, generated extremes: difference to f64 / noise of 4096 samples", worst, 1);
  within(44, "auto, generated extremes: samples that are not finite", nonfinite, 0);
  CHECK(single > count / 4);  // the choice is not always a safe one
}

TEST_CASE(
    "precision auto: the comparison detects the error of f32 for a ball on a ground of 1e7 radii") {
  Scene scene;
  scene.camera.look_from = {0, 2, 8};
  scene.camera.aperture = 0;
  scene.camera.tan_half_vfov = 0.2;
  scene.materials = {{MaterialType::diffuse, {0.5, 0.5, 0.5}, 0, 1}};
  scene.spheres = {{{0, -1e7, 0}, 1e7, 0}, {{0, 1, 0}, 1, 0}};
  const RenderSettings settings = small_picture(scene);
  CHECK(settings.precision == Precision::mixed);
  CHECK(PairedPictures(scene, settings, Precision::mixed).decide().least < 1);
  CHECK(PairedPictures(scene, settings, Precision::f32).decide().least > 1);
  CHECK(PairedPictures(scene, settings, Precision::f64).decide().found == 0);
}

}  // namespace parray::test
