// Samples a second on one core, by scene, precision and accelerator. Variants take turns within
// each round, and medians of rounds are printed, so that a machine whose speed drifts drifts for
// all.
#include <array>
#include <cstdio>
#include <filesystem>

#include "cli/input/scene_file/scene_file.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "tests/bench/bench.h"
#include "tests/support/rooms.h"

namespace {

using namespace parray;
using namespace parray::bench;

struct Variant {
  const char* name;
  Precision precision;
  AcceleratorKind accelerator;
  Isa isa;
  bool general = false;
  Sampler sampler = Sampler::independent;
};
constexpr std::array<Variant, 10> variants{
    {{"f32 bvh", Precision::f32, AcceleratorKind::bvh, Isa::automatic},
     {"mixed bvh", Precision::mixed, AcceleratorKind::bvh, Isa::automatic},
     {"f64 bvh", Precision::f64, AcceleratorKind::bvh, Isa::automatic},
     {"f32 linear", Precision::f32, AcceleratorKind::linear, Isa::automatic},
     {"mixed linear", Precision::mixed, AcceleratorKind::linear, Isa::automatic},
     {"f64 linear", Precision::f64, AcceleratorKind::linear, Isa::automatic},
     {"general", Precision::f32, AcceleratorKind::bvh, Isa::automatic, true},
     {"sobol", Precision::f32, AcceleratorKind::bvh, Isa::automatic, false, Sampler::sobol},
     {"avx2", Precision::f32, AcceleratorKind::bvh, Isa::avx2},
     {"scalar", Precision::f32, AcceleratorKind::bvh, Isa::scalar}}};

/// Of one variant, a second, in each round.
struct Rates {
  std::vector<double> samples;
  std::vector<double> rays;
};

/// Traces rows spread over the picture until the turn is over.
void take_turn(const PathTracer& tracer, const RenderSettings& settings, Rates& rates) {
  std::vector<PixelSums> sums(settings.width);
  TraceCounts counts;
  const double begin = cpu_seconds();
  double elapsed = 0;
  for (std::size_t step = 0; elapsed < seconds_a_turn; ++step) {
    tracer.trace({row_at(step, settings), 0, settings.width}, {0, 4}, sums, counts);
    elapsed = cpu_seconds() - begin;
  }
  rates.samples.push_back(static_cast<double>(counts.samples) / elapsed);
  rates.rays.push_back(static_cast<double>(counts.rays) / elapsed);
}

void measure(const std::filesystem::path& file) {
  const Scene scene = read_scene_file(file).scene;
  RenderSettings settings = small_picture();
  std::vector<std::unique_ptr<PathTracer>> tracers;
  for (const Variant& variant : variants) {
    settings.precision = variant.precision;
    settings.sampler = variant.sampler;
    const auto accelerator =
        make_accelerator(scene, variant.precision, variant.accelerator, variant.isa);
    tracers.push_back(make_path_tracer(accelerator, scene.camera, settings, variant.general));
  }
  std::array<Rates, variants.size()> rates;
  for (std::size_t round = 0; round < rounds; ++round) {
    for (std::size_t v = 0; v < variants.size(); ++v) take_turn(*tracers[v], settings, rates[v]);
  }
  const double base = median(rates[0].samples);
  for (std::size_t v = 0; v < variants.size(); ++v) {
    const double samples = median(rates[v].samples);
    std::printf("%8zu  %-12s  %8.3f  %8.3f  %6.2f\n", scene.spheres.size(), variants[v].name,
                samples / 1e6, median(rates[v].rays) / 1e6, samples / base);
  }
}

}  // namespace

int main(int argc, char** argv) {
  warn_of_assertions();
  if (argc < 2) {
    std::puts("usage: one_core SCENE...");
    return 2;
  }
  pin_to_one_core();
  std::printf("%s, one core; 300 x 200 pixels, depth 10; median of %zu rounds\n",
              processor().c_str(), rounds);
  std::puts(" spheres  variant     Msamples/s   Mrays/s  to f32 bvh");
  for (int i = 1; i < argc; ++i) measure(argv[i]);
  return 0;
}
