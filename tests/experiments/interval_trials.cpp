// Whether intervals of 50, 80, 90 and 95 % hold as often as they say, of pixels and of pictures'
// RMSE: many small pictures with different seeds, samplers and numbers of samples, against
// references. On five scenes that ways to estimate noise were found with, and on five others.
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "cli/measure/tradeoff/analysis.h"
#include "common/math/float_mode.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/settings.h"
#include "tests/support/coverage.h"
#include "tests/support/rooms.h"

namespace {

using namespace parray;
using namespace parray::test;

struct Options {
  std::uint32_t seeds = 60;
  std::uint32_t other_seeds = 30;
  std::uint32_t reference = 16384;
};

constexpr std::size_t levels = 4;  ///< the first of interval_levels

/// How often intervals hold, by level.
struct Holding {
  std::array<double, levels> hold{};
  double asked = 0;

  void add(const Holding& other) {
    for (std::size_t level = 0; level < levels; ++level) hold[level] += other.hold[level];
    asked += other.asked;
  }
  void print() const {
    for (const double one : hold) std::printf(" %.1f |", 100 * one / asked);
  }
};

struct Found {
  Holding pixels;
  Holding as_normal;  ///< pixels, all intervals being the stated ones scaled as a normal's
  Holding pictures;

  void add(const Found& other) {
    pixels.add(other.pixels);
    as_normal.add(other.as_normal);
    pictures.add(other.pictures);
  }
};

Found found_in(const GrowingPicture& picture, const Reference& reference) {
  const ErrorEstimate error = estimate_error(picture.state());
  const ErrorIntervals intervals(picture.state(), error);
  const std::vector<double> means = picture.means();
  Found found;
  for (std::size_t i = 0; i < means.size(); ++i) {
    const double mean = reference.mean[i];
    // Without noise there is nothing that an interval could miss.
    if (reference.variance[i] <= 1e-12 * mean * mean) continue;
    found.pixels.asked += 1;
    found.as_normal.asked += 1;
    for (std::size_t level = 0; level < levels; ++level) {
      const double normal = normal_half_widths[level];
      // The reference has an error, too: with that of a right interval, it widens the interval so.
      const double doubt = normal * std::sqrt(reference.variance[i] / reference.samples);
      const auto holds = [&](double scale) {
        return std::abs(means[i] - mean) <= std::hypot(scale * error.half_width[i], doubt) ? 1 : 0;
      };
      found.pixels.hold[level] += holds(intervals.scale(level));
      found.as_normal.hold[level] += holds(normal / normal_half_widths[stated_level]);
    }
  }
  const double rmse = true_rmse(picture, reference);
  found.pictures.asked = 1;
  for (std::size_t level = 0; level < levels; ++level) {
    const auto [low, high] = intervals.rmse(level);
    found.pictures.hold[level] = low <= rmse && rmse <= high ? 1 : 0;
  }
  return found;
}

struct Way {
  Sampler sampler;
  bool adaptive;
  std::uint32_t samples;
};

std::vector<Way> all_ways() {
  std::vector<Way> ways;
  for (const Sampler sampler : {Sampler::independent, Sampler::sobol}) {
    for (const std::uint32_t samples : {16U, 64U, 256U}) ways.push_back({sampler, false, samples});
    for (const std::uint32_t samples : {64U, 256U}) ways.push_back({sampler, true, samples});
  }
  return ways;
}

Found trial(const NoisyScene& scene, const Reference& reference, const Way& way,
            std::uint32_t seed) {
  RenderSettings settings = scene.settings;
  settings.seed = seed;
  settings.samples_per_pixel = way.samples;
  settings.sampler = way.sampler;
  settings.adaptive = way.adaptive;
  const auto tracer = make_path_tracer(scene.scene, settings);
  GrowingPicture picture(settings, largest_radiance(scene.scene));
  grow_in_passes(settings, picture,
                 [&](const std::vector<std::uint32_t>& until) { picture.trace(*tracer, until); });
  return found_in(picture, reference);
}

void print(const std::string& name, const Found& found) {
  std::printf("| %s |", name.c_str());
  found.pixels.print();
  found.as_normal.print();
  found.pictures.print();
  std::printf(" %.0f |\n", found.pictures.asked);
  std::fflush(stdout);
}

std::string name_of_way(const Way& way) {
  return std::string(name_of(way.sampler)) + (way.adaptive ? ", adaptive, " : ", uniform, ") +
         std::to_string(way.samples);
}

void print_scenes(const std::vector<NoisyScene>& scenes, std::uint32_t seeds,
                  std::uint32_t reference_samples) {
  if (seeds == 0) return;
  std::puts(
      "| | pixels: 50 % | 80 % | 90 % | 95 % | as a normal's: 50 % | 80 % | 90 % | 95 % | "
      "pictures: 50 % | 80 % | 90 % | 95 % | pictures asked |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
  const std::vector<Way> ways = all_ways();
  std::vector<Found> by_way(ways.size());
  Found all;
  for (const NoisyScene& scene : scenes) {
    const Reference reference = trace_reference(scene, reference_samples);
    Found of_scene;
    for (std::size_t w = 0; w < ways.size(); ++w) {
#pragma omp parallel for schedule(dynamic)
      for (std::uint32_t seed = 1; seed <= seeds; ++seed) {
        const FloatMode mode;
        const Found found = trial(scene, reference, ways[w], seed);
#pragma omp critical
        {
          of_scene.add(found);
          by_way[w].add(found);
        }
      }
    }
    print(scene.name, of_scene);
    all.add(of_scene);
  }
  for (std::size_t w = 0; w < ways.size(); ++w) print(name_of_way(ways[w]), by_way[w]);
  print("all", all);
  std::puts("");
}

}  // namespace

int main(int argc, char** argv) {
  const FloatMode mode;
  Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    std::uint32_t& value = std::strcmp(argv[i], "--seeds") == 0         ? options.seeds
                           : std::strcmp(argv[i], "--other-seeds") == 0 ? options.other_seeds
                                                                        : options.reference;
    std::from_chars(argv[i + 1], argv[i + 1] + std::strlen(argv[i + 1]), value);
  }
  constexpr std::uint32_t width = 64;
  constexpr std::uint32_t height = 48;
  print_scenes(noisy_scenes(width, height), options.seeds, options.reference);
  print_scenes(other_scenes(width, height), options.other_seeds, options.reference);
}
