#include "common/scene/settings.h"

#include <doctest/doctest.h>

#include <string>

#include "common/base/error.h"
#include "common/scene/limits.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::message_of;

std::string problem_of(const RenderSettings& settings) {
  return message_of<InputError>([&] { check_settings(settings); });
}

}  // namespace

TEST_CASE("the name of every setting reads back as it") {
  for (const auto value :
       {Precision::automatic, Precision::f32, Precision::f64, Precision::mixed}) {
    CHECK(precision_from(name_of(value)) == value);
  }
  for (const auto value : {Isa::automatic, Isa::scalar, Isa::avx2, Isa::avx512, Isa::neon}) {
    CHECK(isa_from(name_of(value)) == value);
  }
  for (const auto value : {Sampler::independent, Sampler::sobol}) {
    CHECK(sampler_from(name_of(value)) == value);
  }
  for (const auto value : {AcceleratorKind::automatic, AcceleratorKind::linear,
                           AcceleratorKind::bvh, AcceleratorKind::octree}) {
    CHECK(accelerator_from(name_of(value)) == value);
  }
  for (const auto value : {SchedulePolicy::static_split, SchedulePolicy::guided,
                           SchedulePolicy::factoring, SchedulePolicy::weighted}) {
    CHECK(schedule_from(name_of(value)) == value);
  }
  for (const auto value : {RowOrder::automatic, RowOrder::sequential, RowOrder::interleaved}) {
    CHECK(row_order_from(name_of(value)) == value);
  }
}

TEST_CASE("settings are named as users write them") {
  CHECK(name_of(Precision::automatic) == "auto");
  CHECK(name_of(AcceleratorKind::bvh) == "bvh");
  CHECK(name_of(Precision::mixed) == "mixed");
  CHECK(name_of(Isa::avx512) == "avx512");
  CHECK(name_of(AcceleratorKind::octree) == "octree");
  CHECK(name_of(Sampler::sobol) == "sobol");
  CHECK(name_of(SchedulePolicy::static_split) == "static");
  CHECK(name_of(RowOrder::interleaved) == "interleaved");
  CHECK(name_of(static_cast<Precision>(77)) == "unknown");
}

TEST_CASE("an unknown setting is refused with the known names and the nearest") {
  CHECK(message_of<InputError>([] { precision_from("f23"); }) ==
        "unknown precision 'f23': did you mean 'f32'? known: auto, f32, f64, mixed");
  CHECK(message_of<InputError>([] { accelerator_from("BHV"); }) ==
        "unknown accelerator 'BHV': did you mean 'bvh'? known: auto, linear, bvh, octree");
  CHECK(message_of<InputError>([] { schedule_from("wieghted"); }) ==
        "unknown schedule 'wieghted': did you mean 'weighted'? "
        "known: static, guided, factoring, weighted");
  CHECK(message_of<InputError>([] { isa_from("avx-512"); }) ==
        "unknown instruction set 'avx-512': did you mean 'avx512'? "
        "known: auto, scalar, avx2, avx512, neon");
  CHECK(message_of<InputError>([] { sampler_from("soboll"); }) ==
        "unknown sampler 'soboll': did you mean 'sobol'? known: independent, sobol");
  CHECK(message_of<InputError>([] { row_order_from("random"); }) ==
        "unknown row order 'random': known: auto, sequential, interleaved");
  CHECK(message_of<InputError>([] { precision_from(""); }) ==
        "unknown precision '': known: auto, f32, f64, mixed");
  CHECK(message_of<InputError>([] { precision_from("\x1b[2J"); }) ==
        "unknown precision '\\x1b[2J': known: auto, f32, f64, mixed");
}

TEST_CASE("default settings and settings at their limits are accepted") {
  CHECK(problem_of({}) == "no error");
  RenderSettings settings;
  settings.width = limits::max_image_side;
  settings.height = static_cast<std::uint32_t>(limits::max_pixels / limits::max_image_side);
  settings.samples_per_pixel = limits::max_samples_per_pixel;
  settings.max_depth = limits::max_depth;
  settings.seed = UINT64_MAX;
  CHECK(problem_of(settings) == "no error");
  settings = {};
  settings.width = settings.height = settings.samples_per_pixel = settings.max_depth = 1;
  settings.seed = 0;
  CHECK(problem_of(settings) == "no error");
}

TEST_CASE("a setting out of its range is named") {
  const auto with = [](auto change) {
    RenderSettings settings;
    change(settings);
    return problem_of(settings);
  };
  CHECK(with([](auto& s) { s.width = 0; }) ==
        "width: 0 is out of range: use a whole number from 1 to 65536");
  CHECK(with([](auto& s) { s.height = 65537; }) ==
        "height: 65537 is out of range: use a whole number from 1 to 65536");
  CHECK(with([](auto& s) { s.width = s.height = 65536; }) ==
        "image of 65536 x 65536 pixels is too large: use at most 67108864 pixels");
  CHECK(with([](auto& s) { s.samples_per_pixel = 0; }) ==
        "samples_per_pixel: 0 is out of range: use a whole number from 1 to 16777216");
  CHECK(with([](auto& s) { s.max_depth = 0; }) ==
        "max_depth: 0 is out of range: use a whole number from 1 to 1048576");
  CHECK(with([](auto& s) { s.precision = static_cast<Precision>(9); }) ==
        "precision: value 9 is unknown: known: auto, f32, f64, mixed");
  CHECK(with([](auto& s) { s.isa = static_cast<Isa>(5); }) ==
        "isa: value 5 is unknown: known: auto, scalar, avx2, avx512, neon");
  CHECK(with([](auto& s) { s.sampler = static_cast<Sampler>(2); }) ==
        "sampler: value 2 is unknown: known: independent, sobol");
  CHECK(with([](auto& s) { s.row_order = static_cast<RowOrder>(3); }) ==
        "row order: value 3 is unknown: known: auto, sequential, interleaved");
}

}  // namespace parray
