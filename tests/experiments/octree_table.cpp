// Table 2 of the seed program's report (seconds for a picture of 1200 x 800 pixels, 500 samples,
// depth 10, one core; 8, 20 and 4097 spheres) as ratios: 1/100 of the pixels, fewer samples. In
// each round every accelerator traces the same samples, by turns, so that a machine whose speed
// drifts drifts for all; medians of rounds are printed.
#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "cli/input/scene_file/scene_file.h"
#include "common/math/float_mode.h"
#include "common/scene/requirements.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "tests/bench/bench.h"
#include "tests/support/rooms.h"

namespace {

using namespace parray;

constexpr std::size_t rounds = 5;
/// Linear search and the octree in scalar code, as the seed program had them; the BVH in vectors,
/// and what ParRay picks.
enum Contestant : std::size_t { linear, octree, bvh, automatic, contestants };
using Seconds = std::array<double, contestants>;

struct ReportRow {
  std::size_t spheres;
  double octree;  ///< seconds; the report calls it BVH
  double linear;
};
constexpr std::array<ReportRow, 3> report{
    {{8, 1154, 668}, {20, 921, 2138}, {4097, 44 * 60, 567 * 60}}};
constexpr double report_samples = 1200.0 * 800 * 500;

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

Turn take_turn(const PathTracer& tracer, const RenderSettings& settings, std::uint32_t samples) {
  Turn turn{0, std::vector<PixelSums>(std::size_t{settings.width} * settings.height)};
  TraceCounts counts;
  const double begin = bench::cpu_seconds();  // others may have the core in between
  for (std::uint32_t y = 0; y < settings.height; ++y) {
    tracer.trace({y, 0, settings.width}, {0, samples},
                 std::span(turn.sums).subspan(std::size_t{y} * settings.width, settings.width),
                 counts);
  }
  turn.seconds = bench::cpu_seconds() - begin;
  return turn;
}

/// Medians of the seconds that each accelerator takes for the same samples; nothing if their
/// pictures differ.
std::optional<Seconds> measure(const Scene& scene) {
  const RenderSettings settings = settings_of_report();
  RenderSettings with_octree = settings;
  with_octree.accelerator = AcceleratorKind::octree;
  std::array<std::unique_ptr<PathTracer>, contestants> tracers;
  tracers[linear] = make_scalar_tracer(scene, settings);
  tracers[octree] = make_path_tracer(scene, with_octree);
  RenderSettings with_bvh = resolve_settings(requirements_of(scene), settings).settings;
  with_bvh.accelerator = AcceleratorKind::bvh;
  tracers[bvh] = make_path_tracer(scene, with_bvh);
  tracers[automatic] =
      make_path_tracer(scene, resolve_settings(requirements_of(scene), settings).settings);
  std::uint32_t samples = 1;
  while (take_turn(*tracers[octree], settings, samples).seconds < 0.1) samples *= 2;
  std::array<std::vector<double>, contestants> seconds;
  for (std::size_t round = 0; round < rounds; ++round) {
    std::vector<PixelSums> first;
    for (std::size_t a = 0; a < contestants; ++a) {
      Turn turn = take_turn(*tracers[a], settings, samples);
      seconds[a].push_back(turn.seconds);
      if (a == 0) {
        first = std::move(turn.sums);
      } else if (turn.sums != first) {
        return {};
      }
    }
  }
  const double pixels = static_cast<double>(settings.width) * settings.height;
  Seconds medians{};
  for (std::size_t a = 0; a < contestants; ++a) {
    medians[a] = bench::median(seconds[a]) * report_samples / (pixels * samples);
  }
  return medians;
}

void print_csv(std::size_t spheres, const Seconds& seconds, const ReportRow* row) {
  std::printf("%zu,%.1f,%.1f,%.1f,%.1f", spheres, seconds[linear], seconds[octree], seconds[bvh],
              seconds[automatic]);
  if (row != nullptr) {
    std::printf(",%.0f,%.0f\n", row->linear, row->octree);
  } else {
    std::puts(",,");
  }
}

void print_line(std::size_t spheres, const Seconds& seconds, const ReportRow* row) {
  const auto [line, tree, boxes, picked] = seconds;
  std::printf("%8zu  %15.3f  ", spheres, tree / line);
  if (row == nullptr) {
    std::printf("%13s", "-");
  } else {
    std::printf("%13.3f", row->octree / row->linear);
  }
  std::printf("  %12.4f  %13.4f  %13.2f\n", boxes / line, picked / line, tree / picked);
}

}  // namespace

int main(int argc, char** argv) {
#ifndef NDEBUG
  std::puts("warning: built with assertions; these figures mean nothing");
#endif
  const bool csv = argc > 1 && std::string_view(argv[1]) == "--csv";
  const int first = csv ? 2 : 1;
  if (argc <= first) {
    std::puts("usage: octree_table [--csv] SCENE...");
    return 2;
  }
  const FloatMode mode;
  bench::pin_to_one_core();
  if (csv) {
    std::puts("spheres,linear,octree,bvh,auto,report linear,report octree");
  } else {
    std::printf(
        "time for the same samples; one core, 120 x 80 pixels, depth 10, f64; median of %zu\n",
        rounds);
    std::puts(
        " spheres  octree / linear  in the report  bvh / linear  auto / linear  octree / auto");
  }
  for (int i = first; i < argc; ++i) {
    const Scene scene = read_scene_file(argv[i]).scene;
    const std::optional<Seconds> seconds = measure(scene);
    if (!seconds) {
      std::puts("the accelerators' pictures differ");
      return 1;
    }
    const auto* const row = std::ranges::find(report, scene.spheres.size(), &ReportRow::spheres);
    (csv ? print_csv : print_line)(scene.spheres.size(), *seconds,
                                   row == report.end() ? nullptr : row);
  }
  return 0;
}
