// The passes of a picture, whoever traces them; their sizes: passes_test.cpp.
#include "common/adaptive/pass_controller.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "common/scene/largest_radiance.h"
#include "common/scene/settings.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"

namespace parray::test {
namespace {

RenderSettings adaptive_settings() {
  RenderSettings settings = small_settings(small_scene());
  settings.samples_per_pixel = 300;
  settings.adaptive = true;
  return settings;
}

/// A picture that is traced pass by pass.
struct Picture {
  explicit Picture(const RenderSettings& its_settings, std::vector<std::uint64_t> begun = {})
      : settings(its_settings),
        passes(settings, largest_radiance(small_scene()), std::move(begun)) {}

  /// False: complete.
  bool trace_pass(const PassTimes& times = {}) {
    const auto pass = passes.next(framebuffer, times);
    if (!pass) return false;
    latest = pass->stages;
    std::vector<SampleRange> ranges(framebuffer.pixels().size());
    for (const Stage& stage : pass->stages) {
      for (std::size_t i = 0; i < ranges.size(); ++i) {
        const bool has = i % settings.width % stage.lattice.step == stage.lattice.x &&
                         i / settings.width % stage.lattice.step == stage.lattice.y;
        ranges[i] = has ? SampleRange(stage) : SampleRange{};
        if (has && !pass->samples.empty()) ranges[i] = common_of(stage, pass->samples[i]);
      }
      trace_into(framebuffer, *tracer, ranges);
    }
    return true;
  }
  [[nodiscard]] std::uint64_t samples() const { return framebuffer.counts().samples; }
  [[nodiscard]] std::string sha256() const {
    return image_sha256(resolve_image(framebuffer, largest_radiance(small_scene())));
  }

  RenderSettings settings;
  std::shared_ptr<const PathTracer> tracer = make_path_tracer(small_scene(), settings);
  Framebuffer framebuffer{settings.width, settings.height};
  std::vector<Stage> latest;  ///< of the latest pass
  PassController passes;
};

}  // namespace

TEST_CASE("a picture without targets has one pass, of all samples") {
  RenderSettings settings = small_settings(small_scene());
  Picture picture(settings);
  const auto pass = picture.passes.next(picture.framebuffer);
  REQUIRE(pass);
  CHECK(pass->stages == std::vector<Stage>{{0, 6}});
  CHECK(pass->samples.empty());
  CHECK(picture.passes.pass() == 0);
  CHECK_FALSE(picture.passes.next(picture.framebuffer));
  CHECK(picture.passes.begun().empty());
}

TEST_CASE("a picture of one sample in all has a pass, whatever it is to stop at") {
  RenderSettings one = small_settings(small_scene());
  one.width = one.height = one.samples_per_pixel = 1;
  RenderSettings adaptive = one;
  adaptive.adaptive = true;
  RenderSettings with_target = adaptive;
  with_target.target_error = 0.1;
  RenderSettings with_limit = adaptive;
  with_limit.time_limit = 1;
  for (const RenderSettings& settings : {one, adaptive, with_target, with_limit}) {
    Picture picture(settings);
    CHECK(picture.trace_pass());
    CHECK(picture.samples() == 1);
    CHECK_FALSE(picture.trace_pass());
  }
}

TEST_CASE(
    "a progressive picture begins with a sample of every pixel, by lattices, then some, then all, "
    "and is the same") {
  RenderSettings settings = small_settings(small_scene());
  for (const std::uint32_t samples : {1U, 2U, 16U, 40U}) {
    settings.samples_per_pixel = samples;
    settings.progressive = false;
    Picture at_once(settings);
    CHECK(at_once.trace_pass());
    settings.progressive = true;
    Picture picture(settings);
    CHECK(picture.trace_pass());
    std::vector<Stage> lattices;
    for (const Lattice& lattice : nested_lattices(settings.width, settings.height)) {
      lattices.emplace_back(0, 1, lattice);
    }
    CHECK(picture.latest == lattices);
    CHECK(picture.framebuffer.whole());
    for (const Stage& stage : {Stage{1, std::min(samples, 16U)}, Stage{16, samples}}) {
      if (stage.begin < stage.end) {
        CHECK(picture.trace_pass());
        CHECK(picture.latest == std::vector{stage});
      }
    }
    CHECK_FALSE(picture.trace_pass());
    CHECK(picture.passes.begun().empty());
    CHECK(picture.sha256() == at_once.sha256());
  }
}

TEST_CASE(
    "a progressive picture with a target shows every pixel first and goes in the same passes") {
  RenderSettings settings = adaptive_settings();
  settings.target_error = 0.05;
  Picture at_once(settings);
  while (at_once.trace_pass()) {
  }
  settings.progressive = true;
  Picture picture(settings);
  CHECK(picture.trace_pass());
  CHECK(picture.latest == std::vector<Stage>{{0, 1}, {1, 8}});
  while (picture.trace_pass()) {
  }
  CHECK(picture.passes.begun() == at_once.passes.begun());
  CHECK(picture.sha256() == at_once.sha256());
}

TEST_CASE(
    "a target that counts the denoised picture is met by what the judge says, in large steps") {
  RenderSettings settings = adaptive_settings();
  settings.adaptive = false;
  settings.samples_per_pixel = 1 << 20;
  settings.target_error = 0.1;
  settings.target_denoised = true;
  CHECK_THROWS_AS(PassController(settings, 1), std::logic_error);
  int asked = 0;
  const auto judge = [&](const FramebufferView& state) {
    ++asked;
    ErrorFigures error;
    error.rmse = error.low = error.high = 3.2 * std::pow(state.counts[0], -0.4);
    return error;
  };
  PassController passes(settings, largest_radiance(small_scene()), {}, judge);
  Framebuffer framebuffer(settings.width, settings.height);
  const std::shared_ptr<const PathTracer> tracer = make_path_tracer(small_scene(), settings);
  std::vector<std::uint32_t> ends;
  while (const auto pass = passes.next(framebuffer)) {
    REQUIRE(pass->stages.size() == 1);
    ends.push_back(pass->stages[0].end);
    trace_into(framebuffer, *tracer,
               std::vector<SampleRange>(framebuffer.pixels().size(), pass->stages[0]));
  }
  // 3.2 n^(-0.4) is 0.1 for n = 5793.
  CHECK(ends.front() == first_samples);
  CHECK(ends.back() >= 5793);
  CHECK(ends.back() <= 1.5 * 5793);
  CHECK(asked == static_cast<int>(ends.size()));
  CHECK(ends.size() <= 8);
  CHECK(passes.stopped_by() == StopReason::error);
  CHECK(passes.error().high <= 0.1);
}

TEST_CASE("a picture in passes is that of one tracer, pass by pass") {
  Picture picture(adaptive_settings());
  std::uint32_t passes = 0;
  for (std::uint64_t before = 0; picture.trace_pass(); ++passes) {
    CHECK(picture.passes.pass() == passes);
    REQUIRE(picture.passes.begun().size() == passes + 1);
    CHECK(picture.passes.begun()[passes] == picture.samples() - before);
    CHECK_FALSE(picture.passes.repeats());
    before = picture.samples();
  }
  CHECK(passes >= 3);
  CHECK(picture.passes.stopped_by() == StopReason::samples);
  CHECK(picture.sha256() == reference_passes_sha256(small_scene(), adaptive_settings()));
}

TEST_CASE("passes of an earlier life are repeated and not decided anew; the next are decided") {
  Picture first(adaptive_settings());
  while (first.trace_pass()) {
  }
  std::vector<std::uint64_t> begun = first.passes.begun();
  begun.resize(2);
  begun[1] += 100;  // not what would be decided now
  Picture second(adaptive_settings(), begun);
  for (int pass = 0; second.trace_pass(); ++pass) CHECK(second.passes.repeats() == (pass < 2));
  CHECK(second.passes.begun()[1] == begun[1]);
  CHECK(second.passes.begun().size() > 2);
  RenderSettings settings = adaptive_settings();
  settings.passes = second.passes.begun();
  CHECK(second.sha256() == reference_passes_sha256(small_scene(), settings));
}

TEST_CASE("a picture with a target is expected to end as soon as its first pass tells") {
  RenderSettings settings = adaptive_settings();
  settings.samples_per_pixel = 1'000'000;
  settings.target_error = 0.004;
  Picture picture(settings);
  REQUIRE(picture.trace_pass());
  std::vector<double> progress;
  while (picture.trace_pass()) {
    const std::uint64_t before = picture.samples() - picture.passes.begun()[picture.passes.pass()];
    REQUIRE(picture.passes.expected_samples() > 0);
    progress.push_back(static_cast<double>(before) /
                       static_cast<double>(picture.passes.expected_samples()));
  }
  REQUIRE(progress.size() >= 2);
  CHECK(progress.front() > 0.01);
  for (std::size_t i = 1; i < progress.size(); ++i) CHECK(progress[i] > progress[i - 1]);
  CHECK(progress.back() < 1);
  CHECK(picture.passes.stopped_by() == StopReason::error);
  CHECK(picture.passes.expected_samples() == picture.samples());
}

TEST_CASE(
    "early forecasts of the samples for a target are within a factor of two, also with Sobol") {
  for (const Sampler sampler : {Sampler::independent, Sampler::sobol}) {
    RenderSettings settings = adaptive_settings();
    settings.adaptive = false;
    settings.sampler = sampler;
    settings.samples_per_pixel = 1'000'000;
    settings.target_error = 0.004;
    Picture picture(settings);
    REQUIRE(picture.trace_pass());
    std::vector<double> forecasts;
    while (picture.trace_pass()) {
      forecasts.push_back(static_cast<double>(picture.passes.expected_samples()));
    }
    REQUIRE(forecasts.size() >= 2);
    const auto all = static_cast<double>(picture.samples());
    CAPTURE(all / forecasts.front());
    CHECK(forecasts.front() > all / 2);
    CHECK(forecasts.front() < all * 2);
  }
}

TEST_CASE("the error that decides on a pass can be asked for, from the first decision on") {
  RenderSettings settings = adaptive_settings();
  settings.samples_per_pixel = 1'000'000;
  settings.target_error = 0.004;
  const auto trace = [&settings](std::vector<std::uint64_t> begun) {
    Picture picture(settings, std::move(begun));
    std::vector<double> errors;
    for (bool goes_on = true; goes_on;) {
      const ErrorFigures stated =
          estimate_rmse(picture.framebuffer.view(largest_radiance(small_scene())));
      goes_on = picture.trace_pass();
      const ErrorFigures& error = picture.passes.error();
      errors.push_back(error.rmse);
      CHECK((!error.known() || error.rmse == stated.rmse));
      CHECK(error.high == (error.known() ? stated.high : -1));
    }
    CHECK(picture.passes.error().high <= settings.target_error);
    return std::pair(errors, picture.passes.begun());
  };
  const auto [errors, begun] = trace({});
  REQUIRE(errors.size() > 2);
  CHECK(errors[0] == -1);
  CHECK(errors[1] > 0);
  auto [again, passes] = trace(begun);  // passes that are repeated are not decided anew
  CHECK(std::count(again.begin(), again.end(), -1) == static_cast<int>(begun.size()));
  CHECK(again.back() == errors.back());

  settings.target_error = 0;  // nobody asks: nothing is estimated
  settings.samples_per_pixel = 64;
  Picture picture(settings);
  while (picture.trace_pass()) CHECK_FALSE(picture.passes.error().known());
}

TEST_CASE("passes under a time limit are sized by the speed of the pass before") {
  RenderSettings settings = adaptive_settings();
  settings.samples_per_pixel = 1'000'000;
  settings.time_limit = 1000;
  const auto second_pass = [&](const PassTimes& times) {
    Picture picture(settings);
    REQUIRE(picture.trace_pass());
    return picture.passes.next(picture.framebuffer, times) ? picture.passes.begun()[1] : 0;
  };
  const std::uint64_t slow = second_pass({800, 70});
  CHECK(slow > 0);
  CHECK(second_pass({100, 1}) > slow);
  CHECK(second_pass({1001, 1}) == 0);
  CHECK(second_pass({100, 0}) == 0);  // it cannot be told how fast that was
}

TEST_CASE(
    "a picture that time is too short for is spread over the image, and its passes repeat it") {
  RenderSettings settings = adaptive_settings();
  settings.width = 233;
  settings.height = 150;
  settings.time_limit = 1000;
  for (const double speed : {0.2, 7.0, 12.0, 30.0, 50.0, 65.0, 120.0}) {  // samples a second
    Picture limited(settings);
    double total = 0;
    double pass = 0;
    std::uint64_t before = 0;
    while (limited.trace_pass({total, pass, 0, 0})) {
      pass = static_cast<double>(limited.samples() - before) / speed;
      before = limited.samples();
      total += pass;
      REQUIRE(limited.passes.begun().size() < 40);
    }
    CHECK(limited.passes.stopped_by() == StopReason::time);
    const std::vector<std::uint64_t>& passes = limited.passes.begun();
    if (passes.size() > 1) CHECK(total <= settings.time_limit);
    // A lattice more would have taken too long, or half of what is left would not have held it.
    CHECK(limited.samples() >= 0.2 * speed * settings.time_limit);
    RenderSettings again = settings;
    again.time_limit = 0;
    again.passes = passes;
    Picture repeated(again);
    while (repeated.trace_pass()) {
    }
    CHECK(repeated.sha256() == limited.sha256());
    const auto counts = [](const Picture& picture) {
      const auto samples = picture.framebuffer.samples();
      return std::vector<std::uint32_t>(samples.begin(), samples.end());
    };
    CHECK(counts(repeated) == counts(limited));
  }
}

TEST_CASE("a picture that could be traced twice, but not state its error, is traced once") {
  RenderSettings settings = adaptive_settings();
  settings.width = 200;
  settings.height = 200;
  settings.time_limit = 1000;
  Picture picture(settings);
  REQUIRE(picture.trace_pass());
  while (picture.trace_pass({500, 0.001 * static_cast<double>(picture.samples()), 0, 499.999})) {
  }
  CHECK(picture.samples() == 40'000 + 30'000);  // but for the last lattice
}

TEST_CASE("a pass that took no time to speak of leaves time for all that are left") {
  RenderSettings settings = adaptive_settings();
  settings.time_limit = 1e7;
  Picture picture(settings);
  REQUIRE(picture.trace_pass());
  CHECK(picture.trace_pass({1e-12, 1e-12}));
}

TEST_CASE("a picture with a time limit that is taken up between passes does not run away") {
  RenderSettings settings = adaptive_settings();
  settings.samples_per_pixel = 1'000'000;
  settings.time_limit = 1000;
  Picture picture(settings);
  REQUIRE(picture.trace_pass());
  const auto next = picture.passes.next(picture.framebuffer, {});  // nothing is known of its speed
  REQUIRE(next);
  CHECK(picture.passes.begun()[1] <= picture.passes.begun()[0]);
}

TEST_CASE("what was merged of an earlier life does not count as this life's speed") {
  RenderSettings settings = adaptive_settings();
  settings.samples_per_pixel = 1'000'000;
  settings.time_limit = 1000;
  const auto second_pass = [&](bool replayed) {
    Picture picture(settings);
    REQUIRE(picture.trace_pass());
    if (replayed) picture.passes.begin_timing(picture.framebuffer);
    return picture.passes.next(picture.framebuffer, {10, 1}) ? picture.passes.begun()[1] : 0;
  };
  CHECK(second_pass(true) < second_pass(false));
}

}  // namespace parray::test
