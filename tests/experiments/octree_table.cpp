// Table 2 of the seed program's report (seconds for a picture of 1200 x 800 pixels, 500 samples,
// depth 10, one core; 8, 20 and 4097 spheres) as ratios: 1/100 of the pixels, fewer samples. In
// each round every accelerator traces the same samples, by turns, so that a machine whose speed
// drifts drifts for all; medians of rounds are printed.
#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <optional>
#include <vector>

#include "common/math/float_mode.h"
#include "common/scene/requirements.h"
#include "common/scene/scene_file.h"
#include "common/trace/linear.h"
#include "common/trace/octree.h"
#include "common/trace/scalar_kernel.h"
#include "proto/clock.h"
#include "tests/bench/bench.h"

namespace {

using namespace parray;

constexpr std::size_t rounds = 5;
/// Linear search and the octree in scalar code, as the seed program had them, and what ParRay
/// picks.
enum Contestant : std::size_t { linear, octree, automatic, contestants };
using Seconds = std::array<double, contestants>;

struct ReportRow {
  std::size_t spheres;
  double octree_over_linear;
};
constexpr std::array<ReportRow, 3> report{
    {{8, 1154.0 / 668}, {20, 921.0 / 2138}, {4097, 44.0 / 567}}};

/// Double precision, as the seed program.
RenderSettings settings_of_report() {
  RenderSettings settings;
  settings.width = 120;
  settings.height = 80;
  settings.max_depth = 10;
  settings.precision = Precision::f64;
  return settings;
}

struct Turn {
  double seconds = 0;
  std::vector<PixelSums> sums;
};

Turn take_turn(const Kernel& kernel, const RenderSettings& settings, std::uint32_t samples) {
  const SteadyClock clock;
  Turn turn{0, std::vector<PixelSums>(std::size_t{settings.width} * settings.height)};
  TraceCounts counts;
  const Time begin = clock.now();
  for (std::uint32_t y = 0; y < settings.height; ++y) {
    kernel.trace({y, 0, settings.width}, {0, samples},
                 std::span(turn.sums).subspan(std::size_t{y} * settings.width, settings.width),
                 counts);
  }
  turn.seconds = to_seconds(clock.now() - begin);
  return turn;
}

/// Medians of the seconds that each accelerator takes for the same samples; nothing if their
/// pictures differ.
std::optional<Seconds> measure(const Scene& scene) {
  const RenderSettings settings = settings_of_report();
  RenderSettings with_octree = settings;
  with_octree.accelerator = AcceleratorKind::octree;
  std::array<std::unique_ptr<Kernel>, contestants> kernels;
  kernels[linear] = std::make_unique<ScalarKernel<double, double, Linear<double>>>(scene, settings);
  kernels[octree] = make_kernel(scene, with_octree);
  kernels[automatic] =
      make_kernel(scene, resolve_settings(requirements_of(scene), settings).settings);
  std::uint32_t samples = 1;
  while (take_turn(*kernels[octree], settings, samples).seconds < 0.1) {
    samples *= 2;
  }
  std::array<std::vector<double>, contestants> seconds;
  for (std::size_t round = 0; round < rounds; ++round) {
    std::vector<PixelSums> first;
    for (std::size_t a = 0; a < contestants; ++a) {
      Turn turn = take_turn(*kernels[a], settings, samples);
      seconds[a].push_back(turn.seconds);
      if (a == 0) {
        first = std::move(turn.sums);
      } else if (turn.sums != first) {
        return {};
      }
    }
  }
  return Seconds{bench::median(seconds[linear]), bench::median(seconds[octree]),
                 bench::median(seconds[automatic])};
}

}  // namespace

int main(int argc, char** argv) {
#ifndef NDEBUG
  std::puts("warning: built with assertions; these figures mean nothing");
#endif
  if (argc < 2) {
    std::puts("usage: octree_table SCENE...");
    return 2;
  }
  const FloatMode mode;
  bench::pin_to_one_core();
  std::printf(
      "time for the same samples; one core, 120 x 80 pixels, depth 10, f64; median of %zu\n",
      rounds);
  std::puts(" spheres  octree / linear  in the report  auto / linear  octree / auto");
  for (int i = 1; i < argc; ++i) {
    const Scene scene = read_scene_file(argv[i]).scene;
    const std::optional<Seconds> seconds = measure(scene);
    if (!seconds) {
      std::puts("the accelerators' pictures differ");
      return 1;
    }
    const auto [line, tree, picked] = *seconds;
    const auto* const row = std::ranges::find(report, scene.spheres.size(), &ReportRow::spheres);
    std::printf("%8zu  %15.3f  ", scene.spheres.size(), tree / line);
    if (row == report.end()) {
      std::printf("%13s", "-");
    } else {
      std::printf("%13.3f", row->octree_over_linear);
    }
    std::printf("  %13.4f  %13.2f\n", picked / line, tree / picked);
  }
  return 0;
}
