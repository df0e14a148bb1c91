#include "cli/measure/plan/plan.h"

#include <doctest/doctest.h>

#include <atomic>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "cli/measure/plan/effort.h"
#include "cli/measure/plan/part_of_picture.h"
#include "common/base/error.h"
#include "common/scene/settings.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"

namespace parray {
namespace {

using doctest::Approx;

TEST_CASE("a part of a picture has the picture's own pixels, spread over all of it") {
  const Scene scene = test::small_scene();
  RenderSettings settings = test::small_settings(scene);
  settings.width = 200;
  settings.height = 100;
  const auto tracer = make_path_tracer(scene, settings);
  const PartOfPicture part(*tracer, settings.width, settings.height, 2000, {16, 8});
  CHECK(part.width() % 16 == 0);
  CHECK(part.height() % 8 == 0);
  CHECK(part.width() * part.height() == Approx(2000).epsilon(0.3));
  CHECK(part.columns().front() < 50);
  CHECK(part.columns().back() >= 150);
  CHECK(part.rows().front() < 25);
  CHECK(part.rows().back() >= 75);
  for (std::uint32_t y = 0; y < part.height(); ++y) {
    std::vector<PixelSums> of_part(part.width());
    std::vector<PixelSums> of_picture(settings.width);
    TraceCounts counts;
    part.trace({y, 0, part.width()}, {0, 3}, of_part, counts);
    CHECK(counts.samples == 3 * part.width());
    tracer->trace({part.rows()[y], 0, settings.width}, {0, 3}, of_picture, counts);
    for (std::uint32_t x = 0; x < part.width(); ++x) {
      REQUIRE(of_part[x] == of_picture[part.columns()[x]]);
    }
  }
}

TEST_CASE("a part's columns and rows never repeat, whatever the picture's shape") {
  const Scene scene = test::small_scene();
  RenderSettings settings = test::small_settings(scene);
  const auto tracer = make_path_tracer(scene, settings);
  struct Shape {
    std::uint32_t width, height;
    std::uint64_t pixels;
  };
  for (const Shape& shape : {Shape{1, 1, 1},
                             {65536, 1, 100},
                             {1, 65536, 5000},
                             {33, 31, 500},
                             {1000, 10, 1},
                             {640, 480, 640 * 480},
                             {640, 480, 200000}}) {
    const PartOfPicture part(*tracer, shape.width, shape.height, shape.pixels, {32, 32});
    const std::set<std::uint32_t> columns(part.columns().begin(), part.columns().end());
    const std::set<std::uint32_t> rows(part.rows().begin(), part.rows().end());
    CHECK(columns.size() == part.width());
    CHECK(rows.size() == part.height());
    CHECK(*columns.rbegin() < shape.width);
    CHECK(*rows.rbegin() < shape.height);
  }
}

TEST_CASE("the time of a pass is separated from the time of its samples") {
  // 2 s a pass and 0.01 s a sample of processor time, with half of the processors it could have.
  std::vector<TracedPass> passes;
  for (const double samples : {100.0, 400.0, 1000.0}) {
    passes.push_back({samples, {2 * (2 + 0.01 * samples), 2 + 0.01 * samples}});
  }
  const PassCost times = fit_pass_cost(passes);
  CHECK(times.pass.cpu == Approx(2));
  CHECK(times.pass.wall == Approx(4));
  CHECK(times.sample.cpu == Approx(0.01));
  CHECK(times.sample.wall == Approx(0.02));
  CHECK(times.doubt == Approx(0.05));
  passes = {{50, {9, 7}}};
  CHECK(sample_effort(passes, times.pass).cpu == Approx(0.1));
}

TEST_CASE("passes with uneven wall times widen the interval") {
  const std::vector<TracedPass> passes = {{100, {1, 1}}, {100, {3, 1}}};
  CHECK(fit_pass_cost(passes).doubt == Approx(0.5));
}

/// A made-up probe: a sample of each of a million pixels takes a millisecond and has a deviation
/// of 1.
Probe simple_probe(std::vector<Sampler> samplers) {
  Probe probe;
  probe.fixed = {1, 1};
  probe.overheads = {2, 2};
  probe.largest_radiance = 1;
  for (const Sampler sampler : samplers) {
    const double exponent = sampler == Sampler::sobol ? 0.1 : 0;
    const std::vector<MeasuredError> measured = {{1, 1, 0.01}};
    const ErrorModel law(ModelError::uniform(1), measured, {exponent, 0});
    probe.samplers.push_back({sampler, law, law, {1e-6, 2e-6}, {1e-6, 2e-6}});
  }
  return probe;
}

RenderSettings megapixel() {
  RenderSettings settings;
  settings.width = 1000;
  settings.height = 1000;
  return settings;
}

TEST_CASE("times add up: once, samples, finish") {
  const auto all = choices(simple_probe({Sampler::independent}), megapixel(), {0.1, 0}, {0.5, 0.5});
  REQUIRE(all.size() == 2);
  for (const Choice& choice : all) {
    CHECK(choice.seconds.value == Approx(0.5 + 1 + 2 + choice.samples.value));
    CHECK(choice.cpu_seconds == Approx(0.5 + 1 + 2 + 2 * choice.samples.value));
    CHECK(choice.error.value <= 0.1);
    CHECK(choice.error.value > 0.095);
  }
}

TEST_CASE("the sampler that needs fewer samples is recommended") {
  const auto all =
      choices(simple_probe({Sampler::independent, Sampler::sobol}), megapixel(), {0.01, 0}, {});
  REQUIRE(all.size() == 4);
  CHECK(all.front().sampler == Sampler::sobol);
  CHECK(all.back().sampler == Sampler::independent);
}

TEST_CASE("uniform samples use a time up, and adaptive ones get a time limit") {
  const auto all = choices(simple_probe({Sampler::independent}), megapixel(), {0, 103.1}, {});
  REQUIRE(all.size() == 2);
  for (const Choice& choice : all) {
    if (choice.adaptive) {
      CHECK(choice.time_limit == 103.1);  // the time limit keeps the time
      CHECK(choice.seconds.high <= 103.1);
    } else {
      CHECK(choice.samples_per_pixel == 100);
      CHECK(choice.seconds.value == Approx(103));
      CHECK(choice.error.value == Approx(0.1));
    }
  }
}

TEST_CASE("a time limit is recommended for a time too short for the first pass, too") {
  const auto all = choices(simple_probe({Sampler::independent}), megapixel(), {0, 13.1}, {});
  REQUIRE(all.size() == 2);
  CHECK(all.front().time_limit == 13.1);
  CHECK(all.front().samples.value < 10);
  CHECK(all.back().samples_per_pixel == 10);
}

TEST_CASE("commands that stop at the goal come before numbers of samples, even faster ones") {
  Probe probe = simple_probe({Sampler::independent, Sampler::sobol});
  for (SamplerProbe& sampler : probe.samplers) sampler.adaptive_sample = 3 * sampler.uniform_sample;
  for (const PlanGoal goal : {PlanGoal{0.02, 0}, PlanGoal{0, 200}}) {
    const auto all = choices(probe, megapixel(), goal, {});
    REQUIRE(all.size() == 4);
    for (std::size_t i = 0; i < 4; ++i) CHECK((all[i].samples_per_pixel > 0) == (i >= 2));
    CHECK(all[0].target_error == goal.error);
    CHECK((all[0].time_limit > 0) == (goal.seconds > 0));
  }
}

TEST_CASE("the recommended command keeps the goal with the required probability, not more") {
  Probe probe = simple_probe({Sampler::independent, Sampler::sobol});
  probe.timing_doubt = 0.1;
  probe.stated_adaptive.factor = 1.1;
  for (const double confidence : {0.5, 0.9, 0.95, 0.99, 0.999}) {
    const double quantile = normal_quantile(confidence);
    for (const PlanGoal goal : {PlanGoal{0.01, 0, confidence}, PlanGoal{0, 5000, confidence}}) {
      const auto all = choices(probe, megapixel(), goal, {});
      REQUIRE(all.size() == 4);
      for (const Choice& choice : all) {
        CHECK(choice.keeps >= confidence - 1e-6);
        const Expected& of = goal.error > 0 ? choice.error : choice.seconds;
        const double most = goal.error > 0 ? goal.error : goal.seconds;
        if (!choice.adaptive) {
          CHECK(choice.keeps < confidence + 0.02);
          const double relative = std::log(of.high / of.value) / 1.96;
          CHECK(of.value * std::exp(quantile * relative) == Approx(most).epsilon(0.01));
        }
      }
    }
  }
  CHECK(normal_quantile(0.95) == Approx(1.6448536));
  CHECK(normal_quantile(0.5) == Approx(0));
}

TEST_CASE("the best of the commands that stop at the goal is recommended") {
  Probe probe = simple_probe({Sampler::independent, Sampler::sobol});
  for (SamplerProbe& sampler : probe.samplers) {
    sampler.adaptive_sample = 1.1 * sampler.uniform_sample;  // adaptive passes cost more
  }
  probe.timing_doubt = 0.02;
  const auto of_time = choices(probe, megapixel(), {0, 200}, {});
  for (const Choice& choice : of_time) {
    if (choice.samples_per_pixel > 0) continue;
    CHECK(of_time.front().error.value <= choice.error.value);
  }
  const auto of_error = choices(probe, megapixel(), {0.02, 0}, {});
  for (const Choice& choice : of_error) {
    if (choice.samples_per_pixel > 0) continue;
    CHECK(of_error.front().seconds.value <= choice.seconds.value);
  }
}

TEST_CASE(
    "adaptive passes aim below the error only if the required probability exceeds their interval") {
  Probe probe = simple_probe({Sampler::independent});
  probe.stated_adaptive.factor = 1.1;
  const auto target = [&](double confidence) {
    for (const Choice& choice : choices(probe, megapixel(), {0.01, 0, confidence}, {})) {
      if (choice.adaptive) return choice.target_error;
    }
    return 0.0;
  };
  CHECK(target(0.5) == 0.01);
  CHECK(target(0.975) == Approx(0.01).epsilon(1e-5));
  CHECK(target(0.999) == Approx(0.01 * std::pow(1.1, -0.5 * (3.0902 / 1.95996 - 1))));
}

TEST_CASE("the tracing time of a farm is divided by the total speed of its workers") {
  const RenderSettings settings = megapixel();
  const FarmModel farm(settings, {1, 0.5, 2.5}, 2);
  CHECK(farm.seconds(400, 100, 1) == Approx(100).epsilon(0.02));
  CHECK(farm.seconds(4e6, 100, 1) == Approx(1e6).epsilon(0.001));
  CHECK(farm.seconds(400, 100, 4) >= farm.seconds(400, 100, 1));
  CHECK(FarmModel().seconds(400, 100, 1) == 400);
  const FarmModel crowd(settings, std::vector<double>(1000, 1), 2);
  CHECK(crowd.seconds(1, 1, 1) > 1.0 / 1000);  // a short pass has too little work for these threads
  CHECK(crowd.seconds(1e5, 100, 1) == Approx(100).epsilon(0.05));
}

TEST_CASE("a farm shares only the tracing, so a time reserves the rest for this machine") {
  const FarmModel farm(megapixel(), {1, 1, 1, 1}, 1);
  const Probe probe = simple_probe({Sampler::independent});
  for (const Choice& choice : choices(probe, megapixel(), {0.1, 0}, {0.5, 0.5}, farm)) {
    CHECK(choice.seconds.value == Approx(0.5 + 1 + 2 + choice.samples.value / 4).epsilon(0.02));
  }
  for (const Choice& choice : choices(probe, megapixel(), {0, 103}, {}, farm)) {
    CHECK(choice.seconds.value < 103.1);
    CHECK(choice.samples.value > (choice.adaptive ? 200 : 390));
  }
}

std::string refusal(PlanGoal goal) {
  try {
    choices(simple_probe({Sampler::sobol}), megapixel(), goal, {});
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST_CASE("an impossible goal is refused, with a possible one") {
  CHECK(refusal({1e-9, 0}).find("32-bit numbers") != std::string::npos);
  CHECK(refusal({1e-9, 0}).find("use 4.6e-08 or more") != std::string::npos);
  // 1 / 2^24^0.6 = 4.7e-5
  CHECK(refusal({4e-5, 0}).find("use --error 5.1e-05") != std::string::npos);
  CHECK(refusal({1e-4, 0}).empty());
  CHECK(refusal({0, 3}).find("use a longer time") != std::string::npos);
}

TEST_CASE("a probe can be stopped") {
  const Scene scene = test::small_scene();
  ProbeRequest request;
  request.scene = &scene;
  request.settings = test::small_settings(scene);
  request.samplers = {Sampler::sobol};
  request.image = "picture.exr";
  const std::atomic<bool> stop = true;
  CHECK_FALSE(probe(request, stop));
}

}  // namespace
}  // namespace parray
