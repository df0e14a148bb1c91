// Whether the errors that pictures state are true: many pictures of five scenes with different
// seeds, against references. How often the 95 % intervals of pixels and of the picture's RMSE hold,
// how far adaptive passes bias the mean, what targets cost and whether they are met.
#include "tests/support/coverage.h"

#include <charconv>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "common/math/float_mode.h"

namespace {

using namespace parray;
using namespace parray::test;

struct Options {
  std::uint32_t seeds = 200;
  std::uint32_t target_seeds = 20;
  std::uint32_t reference = 16384;
};

constexpr std::uint32_t width = 64;
constexpr std::uint32_t height = 48;
constexpr std::uint32_t targeted_scenes = 3;
constexpr std::uint64_t most_samples = 1 << 20;  ///< a pixel, with targets

/// Calls make(seed) for each seed on all cores, and take(its result) one at a time.
template <typename Make, typename Take>
void for_seeds(std::uint32_t seeds, const Make& make, const Take& take) {
#pragma omp parallel for schedule(dynamic)
  for (std::uint32_t seed = 1; seed <= seeds; ++seed) {
    const FloatMode mode;
    const auto made = make(seed);
#pragma omp critical
    take(made);
  }
}

struct Trial {
  GrowingPicture picture;
  ErrorEstimate error;
  StopReason stop;
};

Trial trial_of(const NoisyScene& scene, RenderSettings settings) {
  const auto kernel = make_kernel(scene.scene, settings);
  GrowingPicture picture(settings, largest_radiance(scene.scene));
  const StopReason stop = grow_in_passes(
      settings, picture,
      [&](const std::vector<std::uint32_t>& until) { picture.trace(*kernel, until); });
  ErrorEstimate error = estimate_error(picture.state());
  return {std::move(picture), std::move(error), stop};
}

void print_strata(const Coverage& coverage, const std::string& title) {
  std::printf(
      "%s, by stratum: coverage, and mean error +- its standard error in %% of the mean\n\n",
      title.c_str());
  std::puts("| mean | variance: least | | | | most |\n|---|---|---|---|---|---|");
  for (std::size_t at = 0; at < Coverage::strata; ++at) {
    const Coverage::Bias bias = coverage.bias(at);
    std::printf("%s %.3f, %+.2f +- %.2f |%s",
                at % 5 == 0 ? ("| " + std::to_string(at / 5 + 1) + " |").c_str() : "",
                coverage.of_stratum(at), 100 * bias.value, 100 * bias.scatter,
                at % 5 == 4 ? "\n" : "");
  }
  std::puts("");
}

void print_coverage(const std::vector<NoisyScene>& scenes, const Options& options,
                    const std::vector<Reference>& references) {
  std::puts(
      "| sampler | adaptive | samples | intervals that hold | least of 20 strata | pictures' "
      "[low, high] that hold | claimed / true RMSE |\n|---|---|---|---|---|---|---|");
  std::vector<std::pair<std::string, Coverage>> all;
  for (const bool adaptive : {false, true}) {
    for (const std::uint32_t samples : {64U, 256U}) {
      Coverage coverage(references);
      for (std::size_t i = 0; i < scenes.size(); ++i) {
        for_seeds(
            options.seeds,
            [&](std::uint32_t seed) {
              RenderSettings settings = scenes[i].settings;
              settings.seed = seed;
              settings.samples_per_pixel = samples;
              settings.adaptive = adaptive;
              return trial_of(scenes[i], settings);
            },
            [&](const Trial& trial) { coverage.add(i, trial.picture, trial.error); });
      }
      std::printf("| independent | %s | %u | %.2f %% | %.1f %% | %.1f %% | %.4f |\n",
                  adaptive ? "yes" : "no", samples, 100 * coverage.pooled(),
                  100 * coverage.least_of_strata(), 100 * coverage.pictures(),
                  coverage.claimed_to_true());
      std::fflush(stdout);
      all.emplace_back(std::string(adaptive ? "adaptive " : "uniform ") + std::to_string(samples),
                       coverage);
    }
  }
  std::puts("");
  for (const auto& [title, coverage] : all) {
    print_strata(coverage, title);
  }
}

struct Found {
  double samples = 0;
  double passes = 0;
  double claimed = 0;
  double truth = 0;
  double met = 0;
  double half_width = 0;
};

Found found_with(const NoisyScene& scene, const Reference& reference, const RenderSettings& asked,
                 std::uint32_t seeds) {
  Found found;
  for_seeds(
      seeds,
      [&](std::uint32_t seed) {
        RenderSettings settings = asked;
        settings.seed = seed;
        settings.samples_per_pixel = most_samples;
        return trial_of(scene, settings);
      },
      [&](const Trial& trial) {
        const double rmse = true_rmse(trial.picture, reference);
        found.samples += static_cast<double>(trial.picture.samples()) / (width * height * seeds);
        found.claimed += trial.error.rmse / seeds;
        found.truth += rmse / seeds;
        found.met += rmse <= asked.target_error ? 1.0 / seeds : 0;
        found.half_width += trial.error.half_width_p99 / seeds;
      });
  return found;
}

void print_targets(const std::vector<NoisyScene>& scenes, const Options& options,
                   const std::vector<Reference>& references) {
  std::puts(
      "| scene | target | uniform: samples | claimed | true | met | adaptive: samples | "
      "claimed | true | met | uniform / adaptive |\n|---|---|---|---|---|---|---|---|---|---|---|");
  for (std::size_t i = 0; i < targeted_scenes; ++i) {
    for (const double target : {0.02, 0.01, 0.005}) {
      RenderSettings settings = scenes[i].settings;
      settings.target_error = target;
      const Found uniform = found_with(scenes[i], references[i], settings, options.target_seeds);
      settings.adaptive = true;
      const Found adaptive = found_with(scenes[i], references[i], settings, options.target_seeds);
      std::printf("| %s | RMSE %g |", scenes[i].name.c_str(), target);
      for (const Found& found : {uniform, adaptive}) {
        std::printf(" %.0f | %.5f | %.5f | %.0f %% |", found.samples, found.claimed, found.truth,
                    100 * found.met);
      }
      std::printf(" %.2f |\n", uniform.samples / adaptive.samples);
      std::fflush(stdout);
    }
  }
  std::puts(
      "\n| scene | target | uniform: samples | adaptive: samples | uniform / adaptive |\n"
      "|---|---|---|---|---|");
  for (std::size_t i = 0; i < targeted_scenes; ++i) {
    RenderSettings settings = scenes[i].settings;
    settings.target_half_width = 0.01;
    const std::uint32_t seeds = 2;
    const Found uniform = found_with(scenes[i], references[i], settings, seeds);
    settings.adaptive = true;
    const Found adaptive = found_with(scenes[i], references[i], settings, seeds);
    std::printf("| %s | half-width 0.01 | %.0f | %.0f | %.2f |\n", scenes[i].name.c_str(),
                uniform.samples, adaptive.samples, uniform.samples / adaptive.samples);
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const FloatMode mode;
  Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    std::uint32_t& value = std::strcmp(argv[i], "--seeds") == 0          ? options.seeds
                           : std::strcmp(argv[i], "--target-seeds") == 0 ? options.target_seeds
                                                                         : options.reference;
    std::from_chars(argv[i + 1], argv[i + 1] + std::strlen(argv[i + 1]), value);
  }
  const std::vector<NoisyScene> scenes = noisy_scenes(width, height);
  std::vector<Reference> references(scenes.size());
#pragma omp parallel for schedule(dynamic)
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const FloatMode of_thread;
    references[i] = trace_reference(scenes[i], options.reference);
  }
  print_coverage(scenes, options, references);
  print_targets(scenes, options, references);
}
