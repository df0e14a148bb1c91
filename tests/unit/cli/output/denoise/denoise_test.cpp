#include "cli/output/denoise/denoise.h"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <stdexcept>
#include <vector>

#include "common/adaptive/replicates.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/settings.h"
#include "common/trace/isa.h"
#include "common/trace/tracer.h"
#include "tests/support/dice.h"
#include "tests/support/noise_trials.h"
#include "tests/support/rooms.h"

namespace parray::test {
namespace {

/// Mean 0, variance 1, from -1.7 to 1.7.
double centred(Dice& dice) { return dice.between(-1, 1) * std::sqrt(3.0); }

/// A picture whose truth is known: value(x, y) in all channels, seen with noise of known size, and
/// features that say nothing.
struct MadeUp {
  std::uint32_t width;
  std::uint32_t height;
  std::vector<double> truth;  ///< 1 value a pixel
  Replicates replicates;
  Features features;

  MadeUp(std::uint32_t wide, std::uint32_t high, double noise, std::uint64_t seed,
         const std::function<double(std::uint32_t, std::uint32_t)>& value, double scale = 1)
      : width(wide), height(high), features{{planes(), planes()}, planes(), {}} {
    Dice dice(seed);
    for (std::uint32_t y = 0; y < height; ++y) {
      for (std::uint32_t x = 0; x < width; ++x) {
        truth.push_back(scale * value(x, y));
        for (std::vector<float>& mean : replicates.mean) {
          for (int c = 0; c < 3; ++c) {
            mean.push_back(static_cast<float>(truth.back() + scale * noise * centred(dice)));
          }
        }
        replicates.noise.push_back(static_cast<float>(scale * noise));
      }
    }
  }
  [[nodiscard]] FeaturePlanes planes() const { return {feature_count, Plane(width, height)}; }
  [[nodiscard]] Denoised clean(int threads = 1, Isa isa = Isa::automatic) const {
    return denoise::denoise(replicates, features, threads, isa);
  }
  /// Mean square error of values, 3 a pixel.
  template <typename Value>
  [[nodiscard]] double square_error(Value&& value) const {
    double sum = 0;
    for (std::size_t i = 0; i < 3 * truth.size(); ++i) {
      const double off = value(i) - truth[i / 3];
      sum += off * off;
    }
    return sum / static_cast<double>(3 * truth.size());
  }
  [[nodiscard]] double raw_error() const {
    return square_error([&](std::size_t i) {
      return (static_cast<double>(replicates.mean[0][i]) + replicates.mean[1][i]) / 2;
    });
  }
  [[nodiscard]] double error_of(const Denoised& picture) const {
    return square_error([&](std::size_t i) { return static_cast<double>(picture.rgb[i]); });
  }
};

double smooth(std::uint32_t x, std::uint32_t y) { return 1 + 0.01 * x + 0.02 * y; }
double steps(std::uint32_t x, std::uint32_t y) { return (x / 8 + y / 8) % 2 == 0 ? 0.4 : 1.2; }
/// Another value in each pixel: nothing to learn from the neighbours.
double grainy(std::uint32_t x, std::uint32_t y) {
  Dice dice(x + 1000 * y + 7);
  return 1 + centred(dice) / 2;
}

struct Traced {
  Replicates replicates;
  Features features;
};

Traced traced(std::uint32_t samples, int threads, std::uint64_t seed = 1) {
  NoisyScene noisy = noisy_scenes(40, 30)[0];
  noisy.settings.samples_per_pixel = samples;
  noisy.settings.seed = seed;
  const auto tracer = make_path_tracer(noisy.scene, noisy.settings);
  GrowingPicture picture(noisy.settings, largest_radiance(noisy.scene));
  picture.trace(*tracer, std::vector<std::uint32_t>(picture.pixels.size(), samples));
  return {replicates_of(picture.state()),
          trace_features(*tracer, *steady_tracer(*tracer, noisy.scene, noisy.settings), noisy.scene,
                         noisy.settings, samples, threads)};
}

}  // namespace

TEST_CASE("a smooth picture loses nearly all of its noise, and edges stay") {
  const MadeUp flat(64, 48, 0.2, 1, smooth);
  CHECK(flat.error_of(flat.clean()) < 0.1 * flat.raw_error());
  const MadeUp board(64, 48, 0.05, 2, steps);
  CHECK(board.error_of(board.clean()) < 0.4 * board.raw_error());
}

TEST_CASE("a picture of unrelated pixels does not change") {
  for (const double noise : {0.3, 0.03, 0.001}) {
    const MadeUp picture(96, 64, noise, 3, grainy);
    CHECK(picture.error_of(picture.clean()) < 1.01 * picture.raw_error());
  }
}

TEST_CASE("a picture without noise does not change") {
  const MadeUp picture(33, 17, 0, 4, grainy);
  const Denoised clean = picture.clean();
  CHECK(picture.error_of(clean) < 1e-12);
  CHECK(clean.rmse < 1e-6);
}

TEST_CASE("the stated error of a denoised picture is right on average, and its interval holds") {
  double stated = 0;
  double real = 0;
  double scatter = 0;
  int held = 0;
  constexpr int pictures = 150;
  for (std::uint64_t seed = 1; seed <= pictures; ++seed) {
    const MadeUp picture(32, 32, 0.15, seed, seed % 2 == 0 ? steps : grainy);
    const Denoised clean = picture.clean();
    const double square = picture.error_of(clean);
    const double off = clean.rmse * clean.rmse - square;
    stated += off;
    scatter += off * off;
    real += square;
    held += clean.low * clean.low <= square && square <= clean.high * clean.high ? 1 : 0;
  }
  CHECK(std::abs(stated) < 3 * std::sqrt(scatter));
  CHECK(std::sqrt(scatter) < 0.02 * real);  // else the line above says nothing
  CHECK(held > 0.9 * pictures);
}

TEST_CASE("a denoised picture has the same bits for every instruction set and number of threads") {
  const Traced one = traced(8, 1);
  const Traced many = traced(8, 3);
  const Denoised reference = denoise::denoise(one.replicates, one.features, 1, Isa::scalar);
  CHECK(denoise::denoise(many.replicates, many.features, 3, Isa::scalar).rgb == reference.rgb);
  for (const Isa isa : instruction_sets()) {
    const Denoised picture = denoise::denoise(one.replicates, one.features, 2, isa);
    CHECK(picture.rgb == reference.rgb);
    CHECK(picture.rmse == reference.rmse);
  }
}

TEST_CASE("a denoised picture is the same at any scale of radiance that a float has") {
  const MadeUp usual(40, 24, 0.1, 5, steps);
  const Denoised reference = usual.clean();
  for (const int exponent : {-100, -60, 60, 100}) {
    const double scale = std::ldexp(1.0, exponent);
    const Denoised picture = MadeUp(40, 24, 0.1, 5, steps, scale).clean();
    bool same = true;
    for (std::size_t i = 0; i < picture.rgb.size(); ++i) {
      same = same && picture.rgb[i] == static_cast<float>(std::ldexp(reference.rgb[i], exponent));
    }
    CHECK(same);
    CHECK(picture.rmse / scale == doctest::Approx(reference.rmse));
  }
}

TEST_CASE("pictures smaller than the filter's window, black ones too, are denoised") {
  for (const std::uint32_t side : {1U, 2U, 9U}) {
    const MadeUp picture(side, 1, 0.1, side, smooth);
    for (const float value : picture.clean().rgb) CHECK(std::isfinite(value));
  }
  const MadeUp black(5, 7, 0, 1, [](auto, auto) { return 0.0; });
  for (const float value : black.clean().rgb) CHECK(value == 0);
}

TEST_CASE("a filtered pixel of one half does not depend on that pixel of the other half") {
  MadeUp picture(48, 32, 0.15, 6, steps);
  const std::vector<float> before = picture.clean().rgb;
  constexpr std::size_t pixel = 3 * (16 * 48 + 20);
  const float shift = 64;  // of the odd half alone, so large that it shows wherever it has a say
  for (std::size_t c = 0; c < 3; ++c) picture.replicates.mean[1][pixel + c] += shift;
  const std::vector<float> after = picture.clean().rgb;
  // The even half's part is what it was: the pixel moves by half of what the odd half's part does,
  // and that stays raw, because none of its neighbours is like it.
  for (std::size_t c = 0; c < 3; ++c) {
    CHECK(after[pixel + c] - before[pixel + c] == doctest::Approx(shift / 2).epsilon(0.02));
  }
}

TEST_CASE("replicates of a traced picture are the means of its even and odd samples") {
  const NoisyScene noisy = noisy_scenes(12, 9)[1];
  const auto tracer = make_path_tracer(noisy.scene, noisy.settings);
  GrowingPicture picture(noisy.settings, largest_radiance(noisy.scene));
  picture.trace(*tracer, std::vector<std::uint32_t>(picture.pixels.size(), 6));
  const Replicates replicates = replicates_of(picture.state());
  const std::vector<double> means = picture.means();
  for (std::size_t i = 0; i < means.size(); ++i) {
    const double both = (static_cast<double>(replicates.mean[0][i]) + replicates.mean[1][i]) / 2;
    CHECK(both == doctest::Approx(means[i]).epsilon(1e-6));
  }
  GrowingPicture one(noisy.settings, largest_radiance(noisy.scene));
  one.trace(*tracer, std::vector<std::uint32_t>(one.pixels.size(), 1));
  const Replicates single = replicates_of(one.state());
  CHECK(single.mean[0] == single.mean[1]);
  CHECK(single.noise == std::vector<float>(one.pixels.size(), 0.0F));
}

TEST_CASE("steady features are near those of the picture's own samples, and differ from them") {
  const Traced picture = traced(16, 2);
  double own = 0;
  double off = 0;
  for (std::size_t f = 0; f < feature_count; ++f) {
    for (std::size_t y = 0; y < 30; ++y) {
      for (std::size_t x = 0; x < 40; ++x) {
        const double steady = picture.features.steady[f].row(y)[x];
        const double even = picture.features.own[0][f].row(y)[x];
        own += steady * steady;
        off += (steady - even) * (steady - even);
      }
    }
  }
  CHECK(off > 0);
  CHECK(off < 0.05 * own);
}

TEST_CASE("tracing features and denoising can be stopped") {
  const NoisyScene noisy = noisy_scenes(40, 30)[0];
  const auto tracer = make_path_tracer(noisy.scene, noisy.settings);
  const auto stop = [] { throw std::runtime_error("enough"); };
  CHECK_THROWS_WITH(trace_features(*tracer, *steady_tracer(*tracer, noisy.scene, noisy.settings),
                                   noisy.scene, noisy.settings, 8, 1, stop),
                    "enough");
  const MadeUp picture(16, 16, 0.1, 1, smooth);
  CHECK_THROWS_WITH(denoise::denoise(picture.replicates, picture.features, 1, Isa::automatic, stop),
                    "enough");
}

}  // namespace parray::test
