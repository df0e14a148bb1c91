// What the Sobol sampler gains: the mean square error of a picture with independent samples, over
// that with Sobol points, for the same number of samples and for the same time. Errors are the
// variance of each pixel and channel over seeds, which leaves no reference to be wrong. Seconds of
// processor, the samplers by turns; medians.
#include <algorithm>
#include <array>
#include <charconv>
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
#include "common/trace/tracer.h"
#include "tests/bench/bench.h"
#include "tests/support/rooms.h"

namespace {

using namespace parray;

constexpr std::array<std::uint32_t, 4> sample_counts{16, 64, 256, 1024};
constexpr std::array<Sampler, 2> samplers{Sampler::independent, Sampler::sobol};
constexpr std::uint32_t least_seeds = 8;
constexpr std::uint64_t most_pixels = 60'000;  ///< of larger pictures only some rows are traced

/// Variance over pictures, of each pixel and channel; their mean.
class Spread {
 public:
  explicit Spread(std::size_t values) : sum_(values), square_(values) {}

  void add(const std::vector<double>& picture) {
    ++count_;
    for (std::size_t i = 0; i < picture.size(); ++i) {
      sum_[i] += picture[i];
      square_[i] += picture[i] * picture[i];
    }
  }
  [[nodiscard]] double mean_variance() const {
    double total = 0;
    for (std::size_t i = 0; i < sum_.size(); ++i) {
      total += (square_[i] - sum_[i] * sum_[i] / count_) / (count_ - 1);
    }
    return total / static_cast<double>(sum_.size());
  }

 private:
  double count_ = 0;
  std::vector<double> sum_, square_;
};

/// Rows between two that are traced.
std::uint32_t row_step(const RenderSettings& settings) {
  const std::uint64_t pixels = std::uint64_t{settings.width} * settings.height;
  return static_cast<std::uint32_t>((pixels + most_pixels - 1) / most_pixels);
}

/// Means of all pixels and channels of the rows that are traced.
std::vector<double> picture_of(const PathTracer& tracer, const RenderSettings& settings,
                               const RadianceScale& scale) {
  std::vector<double> picture;
  for (std::uint32_t y = 0; y < settings.height; y += row_step(settings)) {
    std::vector<PixelSums> row(settings.width);
    TraceCounts counts;
    tracer.trace({y, 0, settings.width}, {0, settings.samples_per_pixel}, row, counts);
    for (const PixelSums& pixel : row) {
      for (const std::uint64_t sum : pixel.sum) {
        picture.push_back(scale.mean(sum, settings.samples_per_pixel));
      }
    }
  }
  return picture;
}

void measure(const std::string& name, const Scene& scene, RenderSettings settings,
             std::uint64_t budget) {
  const std::uint32_t step = row_step(settings);
  const std::uint64_t pixels =
      std::uint64_t{settings.width} * ((settings.height + step - 1) / step);
  const RadianceScale scale(largest_radiance(scene));
  const std::uint64_t seeds =
      std::max<std::uint64_t>(least_seeds, budget / (pixels * settings.samples_per_pixel));
  std::array<Spread, 2> spreads{Spread(3 * pixels), Spread(3 * pixels)};
  std::array<std::vector<double>, 2> seconds;
  for (std::uint64_t turn = 0; turn < seeds * samplers.size(); ++turn) {
    const std::size_t s = turn % samplers.size();
    settings.sampler = samplers[s];
    settings.seed = 1000 + turn;
    const auto tracer = make_path_tracer(scene, settings);
    const double begin = bench::cpu_seconds();
    spreads[s].add(picture_of(*tracer, settings, scale));
    seconds[s].push_back(bench::cpu_seconds() - begin);
  }
  const double gain = spreads[0].mean_variance() / spreads[1].mean_variance();
  const double time = bench::median(seconds[1]) / bench::median(seconds[0]);
  std::printf("%s,%u,%u,%u,%llu,%.3e,%.3f,%.3f,%.3f\n", name.c_str(), settings.width,
              settings.height, settings.samples_per_pixel, static_cast<unsigned long long>(seeds),
              spreads[0].mean_variance(), gain, time, gain / time);
  std::fflush(stdout);
}

int run(int argc, char** argv) {
  std::array<std::uint64_t, 2> numbers{};  // width, millions of samples
  for (int i = 1; i <= 2 && i < argc; ++i) {
    std::from_chars(argv[i], argv[i] + std::strlen(argv[i]),
                    numbers.at(static_cast<std::size_t>(i - 1)));
  }
  const auto [width, millions] = numbers;
  if (argc < 4 || width < 8 || width > 4096 || millions < 1 || millions > 1'000'000) {
    std::puts(
        "usage: sampler_gain WIDTH MILLIONS SCENE...\n"
        "pictures WIDTH (8 .. 4096) across; samples of each measurement, at least 8 pictures");
    return 2;
  }
  bench::pin_to_one_core();
  std::puts("scene,width,height,samples,seeds,independent MSE,gain,time ratio,equal-time gain");
  for (int i = 3; i < argc; ++i) {
    const SceneFile file = read_scene_file(argv[i]);
    RenderSettings settings = resolve_settings(requirements_of(file.scene), file.settings).settings;
    settings.height = static_cast<std::uint32_t>(
        std::max<std::uint64_t>(1, width * settings.height / settings.width));
    settings.width = static_cast<std::uint32_t>(width);
    const std::string path = argv[i];
    const std::string name = path.substr(path.rfind('/') + 1);
    for (const std::uint32_t samples : sample_counts) {
      settings.samples_per_pixel = samples;
      measure(name.substr(0, name.rfind(".json")), file.scene, settings, millions * 1'000'000);
    }
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const FloatMode mode;
  try {
    return run(argc, argv);
  } catch (const InputError& error) {
    std::fprintf(stderr, "sampler_gain: %s\n", error.what());
    return 2;
  }
}
