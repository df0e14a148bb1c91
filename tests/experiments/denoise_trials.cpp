// Whether the errors that denoised pictures state are true, what denoising saves, and that it harms
// nowhere: many pictures with different seeds, against references.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "cli/output/denoise/denoise.h"
#include "common/adaptive/pixel_noise.h"
#include "common/adaptive/replicates.h"
#include "common/math/float_mode.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/requirements.h"
#include "common/scene/settings.h"
#include "tests/support/coverage.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"

namespace {

using namespace parray;
using namespace parray::test;

struct Options {
  std::uint32_t seeds = 250;
  std::uint32_t reference = 8192;
  std::uint32_t gain_reference = 2048;
  std::uint32_t width = 96;
  std::uint32_t height = 64;
  std::uint32_t gain_width = 600;
  std::uint32_t gain_height = 400;
};

constexpr std::array<std::uint32_t, 2> sample_counts{8, 32};

/// A picture as its samples make it, and denoised.
struct Trial {
  std::vector<double> raw;
  Denoised denoised;
};

Trial trial_of(const NoisyScene& scene, std::uint32_t samples, std::uint64_t seed) {
  RenderSettings settings = scene.settings;
  settings.seed = seed;
  settings.samples_per_pixel = samples;
  const auto tracer = make_path_tracer(scene.scene, settings);
  GrowingPicture picture(settings, largest_radiance(scene.scene));
  picture.trace(*tracer, std::vector<std::uint32_t>(picture.counts.size(), samples));
  const Features features = trace_features(*tracer, *steady_tracer(*tracer, scene.scene, settings),
                                           scene.scene, settings, samples, 1);
  return {picture.means(), denoise::denoise(replicates_of(picture.state()), features, 1)};
}

/// Mean square error of a value of the picture, the reference's own taken off.
template <typename Values>
double square_error(const Values& values, const Reference& reference, std::size_t i) {
  const double off = static_cast<double>(values[i]) - reference.mean[i];
  return off * off - reference.variance[i] / reference.samples;
}

template <typename Values>
double square_error(const Values& values, const Reference& reference) {
  double sum = 0;
  for (std::size_t i = 0; i < reference.mean.size(); ++i) sum += square_error(values, reference, i);
  return sum / static_cast<double>(reference.mean.size());
}

struct Tally {
  double pictures = 0;
  double hold = 0;
  double claimed = 0;
  double real = 0;
  double raw = 0;
  std::array<double, Coverage::strata> strata{};
  std::array<double, Coverage::strata> raw_strata{};

  void add(const Trial& trial, const Reference& reference, const Coverage& coverage,
           std::size_t scene) {
    for (std::size_t i = 0; i < reference.mean.size(); ++i) {
      const std::size_t stratum = coverage.stratum_of(scene, i);
      strata[stratum] += square_error(trial.denoised.rgb, reference, i);
      raw_strata[stratum] += square_error(trial.raw, reference, i);
    }
    const double square = square_error(trial.denoised.rgb, reference);
    const double low = trial.denoised.low * trial.denoised.low;
    const double high = trial.denoised.high * trial.denoised.high;
    pictures += 1;
    hold += low <= square && square <= high ? 1 : 0;
    claimed += trial.denoised.rmse * trial.denoised.rmse;
    real += square;
    raw += square_error(trial.raw, reference);
  }
  void print(const std::string& title) const {
    std::printf("| %s | %.0f | %.5f | %.5f | %.2f | %.4f | %.1f %% |\n", title.c_str(), pictures,
                std::sqrt(raw / pictures), std::sqrt(real / pictures), raw / real,
                std::sqrt(claimed / real), 100 * hold / pictures);
  }
  Tally& operator+=(const Tally& other) {
    pictures += other.pictures;
    hold += other.hold;
    claimed += other.claimed;
    real += other.real;
    raw += other.raw;
    for (std::size_t i = 0; i < strata.size(); ++i) {
      strata[i] += other.strata[i];
      raw_strata[i] += other.raw_strata[i];
    }
    return *this;
  }
};

void print_strata(const Tally& tally) {
  std::puts(
      "\nRMSE of denoised over that of raw pictures, by stratum:\n\n"
      "| mean | variance: least | | | | most |\n|---|---|---|---|---|---|");
  for (std::size_t at = 0; at < tally.strata.size(); ++at) {
    if (at % 5 == 0) std::printf("| %zu |", at / 5 + 1);
    std::printf(" %.3f |%s", std::sqrt(tally.strata[at] / tally.raw_strata[at]),
                at % 5 == 4 ? "\n" : "");
  }
  std::puts("");
}

void print_coverage(const Options& options) {
  const std::vector<NoisyScene> scenes = noisy_scenes(options.width, options.height);
  std::vector<Reference> references(scenes.size());
#pragma omp parallel for schedule(dynamic)
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const FloatMode ieee;
    references[i] = trace_reference(scenes[i], options.reference);
  }
  const Coverage coverage(references);
  std::puts(
      "| scene, samples | pictures | raw RMSE | denoised RMSE | square of their ratio | "
      "claimed / true | [low, high] that hold |\n|---|---|---|---|---|---|---|");
  Tally all;
  for (std::size_t scene = 0; scene < scenes.size(); ++scene) {
    for (const std::uint32_t samples : sample_counts) {
      Tally tally;
#pragma omp parallel for schedule(dynamic)
      for (std::uint32_t seed = 1; seed <= options.seeds; ++seed) {
        const FloatMode ieee;
        const Trial trial = trial_of(scenes[scene], samples, seed);
#pragma omp critical
        tally.add(trial, references[scene], coverage, scene);
      }
      tally.print(scenes[scene].name + ", " + std::to_string(samples));
      std::fflush(stdout);
      all += tally;
    }
  }
  all.print("all");
  print_strata(all);
}

// ---- What it saves ------------------------------------------------------------------------------

NoisyScene particles(std::string name, std::vector<Sphere> spheres, double reach) {
  Scene scene;
  scene.camera.look_from = {reach * 0.9, reach * 1.1, reach * 3.2};
  scene.camera.look_at = {0, 0, 0};
  scene.camera.vfov = 32;
  scene.camera.aperture = 0;
  scene.camera.tan_half_vfov = std::tan(16 * std::acos(-1.0) / 180);
  scene.sky = {{1.15, 1.15, 1.15}, {1.15, 1.15, 1.15}};
  for (const Vec3d& albedo : {Vec3d{0.8, 0.3, 0.2}, Vec3d{0.2, 0.5, 0.8}, Vec3d{0.75, 0.75, 0.75},
                              Vec3d{0.85, 0.7, 0.2}}) {
    scene.materials.push_back({MaterialType::diffuse, albedo, 0, 1});
  }
  scene.spheres = std::move(spheres);
  RenderSettings settings = resolve_settings(requirements_of(scene), {}).settings;
  settings.max_depth = 10;
  return {std::move(name), std::move(scene), settings};
}

/// A crystal of two elements with vacancies and thermal motion.
NoisyScene crystal() {
  Dice dice(1);
  std::vector<Sphere> spheres;
  constexpr int side = 18;
  for (int i = 0; i < side * side * side; ++i) {
    if (dice.one_in(20)) continue;
    const Vec3d site{i % side - 8.5, i / side % side - 8.5, i / side / side - 8.5};
    const auto element = static_cast<std::uint32_t>(i + i / side + i / side / side) % 2;
    spheres.push_back({site + dice.in_cube(0.08), element == 0 ? 0.48 : 0.36, element});
  }
  return particles("crystal", std::move(spheres), 12);
}

/// A chain of 30,000 atoms.
NoisyScene chain() {
  Dice dice(2);
  std::vector<Sphere> spheres;
  Vec3d at{0, 0, 0};
  for (int i = 0; i < 30000; ++i) {
    at = 0.998 * at + 1.5 * dice.direction();
    spheres.push_back({at, dice.between(1.1, 1.8), dice.below32(4)});
  }
  return particles("chain", std::move(spheres), 55);
}

/// 200,000 particles of a cloud, about a pixel each.
NoisyScene cloud() {
  Dice dice(3);
  std::vector<Sphere> spheres;
  for (int i = 0; i < 200000; ++i) {
    const Vec3d at = dice.in_cube(1) + dice.in_cube(1) + dice.in_cube(1);
    spheres.push_back({60 * at, 0.8, dice.below32(4)});
  }
  return particles("cloud", std::move(spheres), 130);
}

/// The picture's rows are traced by all cores.
std::vector<double> raw_picture(const NoisyScene& scene, std::uint32_t samples, std::uint64_t seed,
                                GrowingPicture& picture) {
  RenderSettings settings = scene.settings;
  settings.seed = seed;
  const auto tracer = make_path_tracer(scene.scene, settings);
#pragma omp parallel for schedule(dynamic)
  for (std::uint32_t y = 0; y < settings.height; ++y) {
    const FloatMode ieee;
    TraceCounts ignored;
    const std::size_t first = std::size_t{y} * settings.width;
    tracer->trace({y, 0, settings.width}, {0, samples},
                  std::span(picture.pixels).subspan(first, settings.width), ignored);
  }
  std::fill(picture.counts.begin(), picture.counts.end(), samples);
  return picture.means();
}

Reference large_reference(const NoisyScene& scene, std::uint32_t samples) {
  GrowingPicture picture(scene.settings, largest_radiance(scene.scene));
  NoisyScene independent = scene;
  independent.settings.sampler = Sampler::independent;
  Reference reference{
      raw_picture(independent, samples, 1'000'003, picture), {}, static_cast<double>(samples)};
  const RadianceScale scale(picture.largest_radiance);
  for (const PixelSums& pixel : picture.pixels) {
    for (const double variance : noise_of(pixel, samples, scale).variance) {
      reference.variance.push_back(variance);
    }
  }
  return reference;
}

/// Samples a pixel with which a raw picture has this mean square error, between the powers of two
/// that were tried.
double samples_for(double square, const std::vector<std::pair<double, double>>& tried) {
  for (std::size_t i = 1; i < tried.size(); ++i) {
    const auto [fewer, above] = tried[i - 1];
    const auto [more, below] = tried[i];
    if (below <= square) {
      const double share = std::log(above / square) / std::log(above / below);
      return fewer * std::pow(more / fewer, share);
    }
  }
  return tried.back().first;  // and more
}

void print_gain(const Options& options) {
  const std::array scenes{noisy_scenes(options.gain_width, options.gain_height)[0], crystal(),
                          chain(), cloud()};
  std::printf("%u x %u pixels:\n\n", options.gain_width, options.gain_height);
  std::puts(
      "| scene | samples | raw RMSE | denoised RMSE | stated | raw samples for that error | "
      "times |\n|---|---|---|---|---|---|---|");
  for (NoisyScene scene : scenes) {
    scene.settings.width = options.gain_width;
    scene.settings.height = options.gain_height;
    const Reference reference = large_reference(scene, options.gain_reference);
    std::vector<std::pair<double, double>> tried;
    for (std::uint32_t samples = 8; samples <= 512; samples *= 2) {
      GrowingPicture picture(scene.settings, largest_radiance(scene.scene));
      tried.emplace_back(samples, square_error(raw_picture(scene, samples, 5, picture), reference));
    }
    for (const std::uint32_t samples : sample_counts) {
      const Trial trial = trial_of(scene, samples, 1);
      const double square = square_error(trial.denoised.rgb, reference);
      const double needed = samples_for(square, tried);
      std::printf("| %s | %u | %.5f | %.5f | %.5f (%.5f to %.5f) | %.0f | %.1f |\n",
                  scene.name.c_str(), samples, std::sqrt(square_error(trial.raw, reference)),
                  std::sqrt(square), trial.denoised.rmse, trial.denoised.low, trial.denoised.high,
                  needed, needed / samples);
      std::fflush(stdout);
    }
  }
}

bool read_number(const char* text, std::uint32_t& value) {
  const auto [end, error] = std::from_chars(text, text + std::strlen(text), value);
  return error == std::errc() && *end == 0 && value > 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  const std::array<std::pair<const char*, std::uint32_t*>, 7> known{
      {{"--seeds", &options.seeds},
       {"--reference", &options.reference},
       {"--gain-reference", &options.gain_reference},
       {"--width", &options.width},
       {"--height", &options.height},
       {"--gain-width", &options.gain_width},
       {"--gain-height", &options.gain_height}}};
  for (int i = 1; i < argc; i += 2) {
    const auto option = std::find_if(known.begin(), known.end(), [&](const auto& pair) {
      return std::strcmp(pair.first, argv[i]) == 0;
    });
    if (option == known.end() || i + 1 == argc || !read_number(argv[i + 1], *option->second)) {
      std::fprintf(stderr, "denoise_trials: %s: not an option with a whole number > 0\n", argv[i]);
      return 2;
    }
  }
  print_coverage(options);
  print_gain(options);
  return 0;
}
