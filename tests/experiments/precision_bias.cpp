// What single precision does to a picture: f32 and mixed against f64 on the same random numbers, so
// that the Monte Carlo noise that they share cancels. Of each scene: the share of paths that meet
// the same surfaces in the same order (by the scalar definition, common/trace/integrator/path.h),
// and the mean difference of the pictures (by the kernels that render) with its 95 % interval (by
// the means of batches of samples) and the Monte Carlo error of that mean, which the difference
// would drown in.
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "cli/input/scene_file/scene_file.h"
#include "common/base/error.h"
#include "common/math/float_mode.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/requirements.h"
#include "common/scene/settings.h"
#include "tests/support/path_steps.h"
#include "tests/support/rooms.h"
#include "tests/support/tracers.h"

namespace {

using namespace parray;

constexpr std::uint32_t batches = 32;
constexpr double student = 2.04;  ///< 97.5 % point of Student's t with 31 degrees of freedom
constexpr std::uint32_t width = 120;
constexpr std::uint32_t paths = 50'000;

/// A mean and half the width of its 95 % interval.
struct Interval {
  double mean = 0;
  double half = 0;
};

Interval interval_of(const std::array<double, batches>& values) {
  double mean = 0;
  double square = 0;
  for (const double value : values) mean += value / batches;
  for (const double value : values) square += (value - mean) * (value - mean) / (batches - 1);
  return {mean, student * std::sqrt(square / batches)};
}

template <typename Real, typename Store>
std::vector<std::vector<test::Step>> steps_in(const Scene& scene, const RenderSettings& settings) {
  const auto traced = test::reference_scene<Real, Store>(scene, settings);
  const Linear<Real> linear(traced.spheres);
  std::vector<std::vector<test::Step>> result;
  result.reserve(paths);
  const std::uint32_t pixels = settings.width * settings.height;
  for (std::uint32_t i = 0; i < paths; ++i) {
    const std::uint32_t pixel = i % pixels;
    const SampleRandom random(settings.seed, pixel, i / pixels);
    result.push_back(
        test::steps_of(traced, linear, pixel % settings.width, pixel / settings.width, random));
  }
  return result;
}

double share_alike(const std::vector<std::vector<test::Step>>& a,
                   const std::vector<std::vector<test::Step>>& b) {
  double alike = 0;
  for (std::size_t i = 0; i < a.size(); ++i) alike += a[i] == b[i] ? 1 : 0;
  return alike / static_cast<double>(a.size());
}

/// Mean radiance, of all pixels and channels, of each batch of samples.
std::array<double, batches> batch_means(const Scene& scene, RenderSettings settings,
                                        Precision precision) {
  settings.precision = precision;
  const auto tracer = make_path_tracer(scene, settings);
  const RadianceScale scale(largest_radiance(scene));
  const std::uint32_t samples = settings.samples_per_pixel / batches;
  std::array<double, batches> means{};
  for (std::uint32_t b = 0; b < batches; ++b) {
    for (std::uint32_t y = 0; y < settings.height; ++y) {
      std::vector<PixelSums> row(settings.width);
      TraceCounts counts;
      tracer->trace({y, 0, settings.width}, {b * samples, (b + 1) * samples}, row, counts);
      for (const PixelSums& pixel : row) {
        for (const std::uint64_t sum : pixel.sum) {
          means[b] += scale.mean(sum, samples) / (3.0 * settings.width * settings.height);
        }
      }
    }
  }
  return means;
}

void print_scene(const std::string& path, std::uint32_t samples) {
  const SceneFile file = read_scene_file(path);
  RenderSettings settings = resolve_settings(requirements_of(file.scene), file.settings).settings;
  const Precision picked = settings.precision;
  settings.height = std::max(1U, width * settings.height / settings.width);
  settings.width = width;
  settings.samples_per_pixel = samples;
  settings.sampler = Sampler::independent;  // so that batches are, too
  const auto steps = steps_in<double, double>(file.scene, settings);
  const double single = share_alike(steps_in<float, float>(file.scene, settings), steps);
  const double mixed = share_alike(steps_in<double, float>(file.scene, settings), steps);
  const auto exactly = batch_means(file.scene, settings, Precision::f64);
  const Interval noise = interval_of(exactly);
  const std::size_t slash = path.rfind('/');
  std::printf("| %s | %s |", path.c_str() + (slash == std::string::npos ? 0 : slash + 1),
              std::string(name_of(picked)).c_str());
  for (const Precision precision : {Precision::f32, Precision::mixed}) {
    std::array<double, batches> difference = batch_means(file.scene, settings, precision);
    for (std::uint32_t b = 0; b < batches; ++b) difference[b] -= exactly[b];
    const Interval bias = interval_of(difference);
    std::printf(" %.3f %% | %+.1e +- %.0e |", 100 * (precision == Precision::f32 ? single : mixed),
                bias.mean, bias.half);
  }
  std::printf(" %.0e |\n", noise.half);
  std::fflush(stdout);
}

int run(int argc, char** argv) {
  std::uint32_t samples = 1024;
  int first = 1;
  if (argc > 2 && std::strcmp(argv[1], "--samples") == 0) {
    std::from_chars(argv[2], argv[2] + std::strlen(argv[2]), samples);
    first = 3;
  }
  if (argc <= first || samples < batches || samples > (1U << 20)) {
    std::puts("usage: precision_bias [--samples N] SCENE...    (N a pixel, 32 .. 1048576)");
    return 2;
  }
  samples -= samples % batches;
  std::printf("%u pixels wide, %u samples per pixel; %u paths followed\n\n", width, samples, paths);
  std::puts(
      "| scene | auto | f32: paths alike | f32 - f64 | mixed: paths alike | mixed - f64 | noise |");
  std::puts("|---|---|---|---|---|---|---|");
  for (int i = first; i < argc; ++i) print_scene(argv[i], samples);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const FloatMode mode;
  try {
    return run(argc, argv);
  } catch (const InputError& error) {
    std::fprintf(stderr, "precision_bias: %s\n", error.what());
    return 2;
  }
}
