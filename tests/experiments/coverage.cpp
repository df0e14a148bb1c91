// Whether the errors that pictures state are true: many pictures of five scenes with different
// seeds, against references. How often the 95 % intervals of pixels and of the picture's RMSE hold,
// how far adaptive passes bias the mean, what targets cost and whether they are met.
#include "tests/support/coverage.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "common/math/float_mode.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/settings.h"
#include "tests/support/rooms.h"

namespace {

using namespace parray;
using namespace parray::test;

struct Options {
  std::uint32_t seeds = 200;
  std::uint32_t target_seeds = 10;
  std::uint32_t bias_seeds = 400;
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

struct Way {
  Sampler sampler;
  bool adaptive;
};
constexpr std::array<Way, 4> ways{{{Sampler::independent, false},
                                   {Sampler::independent, true},
                                   {Sampler::sobol, false},
                                   {Sampler::sobol, true}}};

struct Trial {
  GrowingPicture picture;
  ErrorEstimate error;
  StopReason stop;
};

Trial trial_of(const NoisyScene& scene, RenderSettings settings) {
  const auto tracer = make_path_tracer(scene.scene, settings);
  GrowingPicture picture(settings, largest_radiance(scene.scene));
  const StopReason stop = grow_in_passes(
      settings, picture,
      [&](const std::vector<std::uint32_t>& until) { picture.trace(*tracer, until); });
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
  for (const Way& way : ways) {
    for (const std::uint32_t samples : {64U, 256U}) {
      Coverage coverage(references);
      for (std::size_t i = 0; i < scenes.size(); ++i) {
        for_seeds(
            options.seeds,
            [&](std::uint32_t seed) {
              RenderSettings settings = scenes[i].settings;
              settings.seed = seed;
              settings.samples_per_pixel = samples;
              settings.sampler = way.sampler;
              settings.adaptive = way.adaptive;
              return trial_of(scenes[i], settings);
            },
            [&](const Trial& trial) { coverage.add(i, trial.picture, trial.error); });
      }
      std::printf("| %s | %s | %u | %.2f %% | %.1f %% | %.1f %% | %.4f |\n",
                  std::string(name_of(way.sampler)).c_str(), way.adaptive ? "yes" : "no", samples,
                  100 * coverage.pooled(), 100 * coverage.least_of_strata(),
                  100 * coverage.pictures(), coverage.claimed_to_true());
      std::fflush(stdout);
      all.emplace_back(std::string(name_of(way.sampler)) +
                           (way.adaptive ? ", adaptive, " : ", uniform, ") +
                           std::to_string(samples),
                       coverage);
    }
  }
  std::puts("");
  for (const auto& [title, coverage] : all) print_strata(coverage, title);
}

using Strata = std::array<double, Coverage::strata>;

/// Sums over strata of what a picture in adaptive passes has more than a uniform one of its seed.
Strata adaptive_less_uniform(const std::vector<NoisyScene>& scenes, std::size_t scene,
                             RenderSettings settings, const Coverage& coverage) {
  Strata sums{};
  for (const bool adaptive : {true, false}) {
    settings.adaptive = adaptive;
    const std::vector<double> means = trial_of(scenes[scene], settings).picture.means();
    for (std::size_t i = 0; i < means.size(); ++i) {
      sums[coverage.stratum_of(scene, i)] += adaptive ? means[i] : -means[i];
    }
  }
  return sums;
}

struct Bias {
  Strata value{};     ///< sums over the pixels and channels of a stratum
  Strata variance{};  ///< of that
};

/// Adds what `seeds` pictures of a scene tell, as a mean.
void add_bias(const std::vector<NoisyScene>& scenes, std::size_t scene, Sampler sampler,
              std::uint32_t seeds, const Coverage& coverage, Bias& bias) {
  Strata sum{};
  Strata squares{};
  for_seeds(
      seeds,
      [&](std::uint32_t seed) {
        RenderSettings settings = scenes[scene].settings;
        settings.seed = seed;
        settings.samples_per_pixel = 256;
        settings.sampler = sampler;
        return adaptive_less_uniform(scenes, scene, settings, coverage);
      },
      [&](const Strata& found) {
        for (std::size_t at = 0; at < found.size(); ++at) {
          sum[at] += found[at];
          squares[at] += found[at] * found[at];
        }
      });
  const double n = seeds;
  for (std::size_t at = 0; at < sum.size(); ++at) {
    bias.value[at] += sum[at] / n;
    bias.variance[at] += (squares[at] - sum[at] * sum[at] / n) / (n * (n - 1));
  }
}

void print_bias(const std::vector<NoisyScene>& scenes, const Options& options,
                const std::vector<Reference>& references) {
  const Coverage coverage(references);
  Strata mean{};
  for (std::size_t scene = 0; scene < scenes.size(); ++scene) {
    for (std::size_t i = 0; i < references[scene].mean.size(); ++i) {
      mean[coverage.stratum_of(scene, i)] += references[scene].mean[i];
    }
  }
  for (const Sampler sampler : {Sampler::independent, Sampler::sobol}) {
    Bias bias;
    for (std::size_t scene = 0; scene < scenes.size(); ++scene) {
      add_bias(scenes, scene, sampler, options.bias_seeds, coverage, bias);
    }
    std::printf("%s, 256 samples: adaptive less uniform passes, in %% of the mean\n\n",
                std::string(name_of(sampler)).c_str());
    std::puts("| mean | variance: least | | | | most |\n|---|---|---|---|---|---|");
    for (std::size_t at = 0; at < Coverage::strata; ++at) {
      std::printf("%s %+.3f +- %.3f |%s",
                  at % 5 == 0 ? ("| " + std::to_string(at / 5 + 1) + " |").c_str() : "",
                  100 * bias.value[at] / mean[at], 100 * std::sqrt(bias.variance[at]) / mean[at],
                  at % 5 == 4 ? "\n" : "");
    }
    std::puts("");
  }
}

struct Found {
  double samples = 0;
  double claimed = 0;
  double truth = 0;
  double met = 0;
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
        const bool met = trial.stop == StopReason::error
                             ? rmse <= asked.target_error
                             : trial.error.half_width_p99 <= asked.target_half_width;
        found.met += met ? 1.0 / seeds : 0;
      });
  return found;
}

/// What a target takes each way: samples, RMSE claimed and true, and how often it is met.
void print_target(const NoisyScene& scene, const Reference& reference, RenderSettings settings,
                  std::uint32_t seeds) {
  const bool widths = settings.target_half_width > 0;
  std::printf("| %s | %s %g |", scene.name.c_str(), widths ? "half-width" : "RMSE",
              widths ? settings.target_half_width : settings.target_error);
  double first = 0;
  for (const auto& [sampler, adaptive] : ways) {
    settings.sampler = sampler;
    settings.adaptive = adaptive;
    const Found found = found_with(scene, reference, settings, seeds);
    first = first > 0 ? first : found.samples;
    std::printf(" %.0f (%.2f): %.5f, %.5f, %.0f %% |", found.samples, first / found.samples,
                found.claimed, found.truth, 100 * found.met);
    std::fflush(stdout);
  }
  std::puts("");
}

void print_targets(const std::vector<NoisyScene>& scenes, const Options& options,
                   const std::vector<Reference>& references) {
  std::puts(
      "Samples a pixel (uniform independent samples / these): RMSE claimed, true; share of "
      "pictures "
      "whose RMSE meets the target\n\n| scene | target | independent, uniform | independent, "
      "adaptive | sobol, uniform | sobol, adaptive |\n|---|---|---|---|---|---|");
  for (std::size_t i = 0; i < targeted_scenes; ++i) {
    RenderSettings settings = scenes[i].settings;
    for (const double target : {0.02, 0.01, 0.005}) {
      settings.target_error = target;
      print_target(scenes[i], references[i], settings, options.target_seeds);
    }
    settings.target_error = 0;
    settings.target_half_width = 0.01;
    print_target(scenes[i], references[i], settings, 2);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const FloatMode mode;
  Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    std::uint32_t& value = std::strcmp(argv[i], "--seeds") == 0          ? options.seeds
                           : std::strcmp(argv[i], "--target-seeds") == 0 ? options.target_seeds
                           : std::strcmp(argv[i], "--bias-seeds") == 0   ? options.bias_seeds
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
  if (options.seeds > 0) print_coverage(scenes, options, references);
  if (options.bias_seeds > 0) print_bias(scenes, options, references);
  if (options.target_seeds > 0) print_targets(scenes, options, references);
}
