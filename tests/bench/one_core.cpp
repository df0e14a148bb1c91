// Samples a second on one core, by scene, precision and accelerator. Variants take turns within
// each round, and medians of rounds are printed, so that a machine whose speed drifts drifts for
// all.
#include <sched.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "common/scene/requirements.h"
#include "common/scene/scene_file.h"
#include "common/trace/kernel.h"
#include "proto/clock.h"

namespace {

using namespace parray;

constexpr std::size_t rounds = 7;
constexpr double seconds_a_turn = 0.3;

struct Variant {
  const char* name;
  Precision precision;
  AcceleratorKind accelerator;
  Isa isa;
  bool general = false;
};
constexpr std::array<Variant, 9> variants{
    {{"f32 bvh", Precision::f32, AcceleratorKind::bvh, Isa::automatic},
     {"mixed bvh", Precision::mixed, AcceleratorKind::bvh, Isa::automatic},
     {"f64 bvh", Precision::f64, AcceleratorKind::bvh, Isa::automatic},
     {"f32 linear", Precision::f32, AcceleratorKind::linear, Isa::automatic},
     {"mixed linear", Precision::mixed, AcceleratorKind::linear, Isa::automatic},
     {"f64 linear", Precision::f64, AcceleratorKind::linear, Isa::automatic},
     {"general", Precision::f32, AcceleratorKind::bvh, Isa::automatic, true},
     {"avx2", Precision::f32, AcceleratorKind::bvh, Isa::avx2},
     {"scalar", Precision::f32, AcceleratorKind::bvh, Isa::scalar}}};

struct Rate {
  double samples = 0;  ///< a second
  double rays = 0;
};

/// Traces rows spread over the picture until the turn is over.
Rate take_turn(const Kernel& kernel, const RenderSettings& settings) {
  const SteadyClock clock;
  const Time begin = clock.now();
  std::vector<PixelSums> sums(settings.width);
  TraceCounts counts;
  double elapsed = 0;
  for (std::uint32_t step = 0; elapsed < seconds_a_turn; ++step) {
    const std::uint32_t row = step * 67 % settings.height;  // 67 and 200 share no factor
    kernel.trace({row, 0, settings.width}, {0, 4}, sums, counts);
    elapsed = to_seconds(clock.now() - begin);
  }
  return {static_cast<double>(counts.samples) / elapsed,
          static_cast<double>(counts.rays) / elapsed};
}

Rate median(std::vector<Rate> rates) {
  std::sort(rates.begin(), rates.end(),
            [](const Rate& a, const Rate& b) { return a.samples < b.samples; });
  return rates[rates.size() / 2];
}

void pin_to_one_core() {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  sched_getaffinity(0, sizeof allowed, &allowed);
  for (int cpu = CPU_SETSIZE - 1; cpu >= 0; --cpu) {
    if (CPU_ISSET(cpu, &allowed)) {
      cpu_set_t one;
      CPU_ZERO(&one);
      CPU_SET(cpu, &one);
      sched_setaffinity(0, sizeof one, &one);
      return;
    }
  }
}

std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) {
      return line.substr(line.find(':') + 2);
    }
  }
  return "unknown processor";
}

void measure(const std::filesystem::path& file) {
  const Scene scene = read_scene_file(file).scene;
  RenderSettings settings;
  settings.width = 300;
  settings.height = 200;
  std::vector<std::unique_ptr<Kernel>> kernels;
  for (const Variant& variant : variants) {
    settings.precision = variant.precision;
    settings.accelerator = variant.accelerator;
    settings.isa = variant.isa;
    KernelOptions options;
    options.general = variant.general;
    kernels.push_back(make_kernel(scene, settings, options));
  }
  std::array<std::vector<Rate>, variants.size()> rates;
  for (std::size_t round = 0; round < rounds; ++round) {
    for (std::size_t v = 0; v < variants.size(); ++v) {
      rates[v].push_back(take_turn(*kernels[v], settings));
    }
  }
  const double base = median(rates[0]).samples;
  for (std::size_t v = 0; v < variants.size(); ++v) {
    const Rate rate = median(rates[v]);
    std::printf("%8zu  %-12s  %8.3f  %8.3f  %6.2f\n", scene.spheres.size(), variants[v].name,
                rate.samples / 1e6, rate.rays / 1e6, rate.samples / base);
  }
}

}  // namespace

int main(int argc, char** argv) {
#ifndef NDEBUG
  std::puts("warning: built with assertions; these figures mean nothing");
#endif
  if (argc < 2) {
    std::puts("usage: one_core SCENE...");
    return 2;
  }
  pin_to_one_core();
  std::printf("%s, one core; 300 x 200 pixels, depth 10; median of %zu rounds\n",
              processor().c_str(), rounds);
  std::puts(" spheres  variant     Msamples/s   Mrays/s  to f32 bvh");
  for (int i = 1; i < argc; ++i) {
    measure(argv[i]);
  }
  return 0;
}
