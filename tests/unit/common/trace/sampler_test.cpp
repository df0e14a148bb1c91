// The samplers as the tracer sees them: numbers by seed, pixel, sample, bounce and purpose.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "common/image/image.h"
#include "common/math/lanes_scalar.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/settings.h"
#include "common/trace/integrator/random.h"
#include "common/trace/tracer.h"
#include "tests/support/owen_tree.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/statistics.h"

namespace parray::test {
namespace {

/// The numbers of a sample that the Sobol sampler spreads: film x and y, lens u and v, then u and v
/// of the first scatterings.
constexpr std::size_t spread_numbers = 4 + 2 * SobolSets::bounces;
using Numbers = std::array<double, spread_numbers>;

Numbers numbers_of(const SampleRandom& random) {
  Numbers result{};
  const auto camera = random.at<double>(0, Purpose::camera);
  result[0] = camera.a;
  result[1] = camera.b;
  result[2] = camera.c;
  result[3] = camera.d;
  for (std::uint32_t bounce = 0; bounce < SobolSets::bounces; ++bounce) {
    const auto turn = random.at<double>(bounce, Purpose::scatter);
    result[4 + 2 * bounce] = turn.a;
    result[5 + 2 * bounce] = turn.b;
  }
  return result;
}

/// Point `index` of a replicate (0 or 1) of a pixel.
Numbers point(std::uint64_t seed, std::uint32_t pixel, std::uint32_t replicate,
              std::uint32_t index) {
  return numbers_of(SampleRandom(seed, pixel, 2 * index + replicate, Sampler::sobol));
}

using Integrand = std::function<double(const Numbers&)>;

/// What pixels hold: an edge, a blurred one, a smooth one, one that all numbers matter to.
const std::array<Integrand, 4> integrands{
    [](const Numbers& u) { return u[0] * u[0] + u[1] * u[1] < 0.7 ? 1.0 : 0.0; },
    [](const Numbers& u) { return u[0] + 0.3 * u[2] + 0.2 * u[3] < 0.6 + 0.4 * u[4] ? 1.0 : 0.0; },
    [](const Numbers& u) { return u[0] * u[1] + u[2] * u[4] * u[5]; },
    [](const Numbers& u) {
      double product = 1;
      for (const double number : u) product *= 0.5 + number;
      return product;
    }};

/// Of each integrand.
using Means = std::array<double, integrands.size()>;

template <typename Point>
Means means_of(std::uint32_t points, Point point) {
  Means means{};
  for (std::uint32_t i = 0; i < points; ++i) {
    const Numbers u = point(i);
    for (std::size_t k = 0; k < integrands.size(); ++k) means[k] += integrands[k](u) / points;
  }
  return means;
}

Means replicate_means(std::uint64_t seed, std::uint32_t pixel, std::uint32_t replicate,
                      std::uint32_t points) {
  return means_of(points, [&](std::uint32_t i) { return point(seed, pixel, replicate, i); });
}

/// The same with a tree of coins for each number.
Means textbook_means(std::uint64_t seed, std::uint32_t points) {
  std::vector<OwenTree> trees;
  for (std::size_t k = 0; k < spread_numbers; ++k) trees.emplace_back(spread_numbers * seed + k);
  return means_of(points, [&](std::uint32_t i) {
    Numbers u{};
    for (std::size_t set = 0; set < spread_numbers / 2; ++set) {
      const PointOrder& order = set == 0 ? SobolSets::film
                                : set == 1
                                    ? SobolSets::lens
                                    : SobolSets::scatter(static_cast<std::uint32_t>(set - 2));
      const std::uint32_t at = order.of(i);
      u[2 * set] = number_of(trees[2 * set].scrambled(at)) * 0x1p-24;
      u[2 * set + 1] = number_of(trees[2 * set + 1].scrambled(sobol_second(at))) * 0x1p-24;
    }
    return u;
  });
}

/// Mean, variance and the variance's own standard error of values that come one by one.
class Moments {
 public:
  void add(double value) { values_.push_back(value); }
  [[nodiscard]] double mean() const {
    double sum = 0;
    for (const double value : values_) sum += value;
    return sum / count();
  }
  [[nodiscard]] double variance() const { return central(2) * count() / (count() - 1); }
  [[nodiscard]] double variance_error() const {
    return std::sqrt((central(4) - central(2) * central(2)) / count());
  }
  [[nodiscard]] double count() const { return static_cast<double>(values_.size()); }

 private:
  [[nodiscard]] double central(int power) const {
    const double center = mean();
    double sum = 0;
    for (const double value : values_) sum += std::pow(value - center, power);
    return sum / count();
  }

  std::vector<double> values_;
};

/// Correlation of pairs as a standard normal number.
double correlation_z(const std::vector<double>& a, const std::vector<double>& b) {
  const auto n = static_cast<double>(a.size());
  double mean_a = 0;
  double mean_b = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    mean_a += a[i] / n;
    mean_b += b[i] / n;
  }
  double ab = 0;
  double aa = 0;
  double bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - mean_a) * (b[i] - mean_b);
    aa += (a[i] - mean_a) * (a[i] - mean_a);
    bb += (b[i] - mean_b) * (b[i] - mean_b);
  }
  return ab / std::sqrt(aa * bb) * std::sqrt(n);
}

}  // namespace

TEST_CASE("each replicate's first 2^k points hit each elementary interval of each pair once") {
  for (const std::uint32_t replicate : {0U, 1U}) {
    for (std::uint32_t pixel = 0; pixel < 3; ++pixel) {
      for (int k = 0; k <= 8; ++k) {
        for (std::size_t pair = 0; pair < spread_numbers; pair += 2) {
          for (int x = 0; x <= k; ++x) {
            std::vector<int> hits(std::size_t{1} << k);
            for (std::uint32_t i = 0; i < 1U << k; ++i) {
              const Numbers u = point(7, pixel, replicate, i);
              const auto column = static_cast<std::size_t>(u[pair] * (1 << x));
              const auto row = static_cast<std::size_t>(u[pair + 1] * (1 << (k - x)));
              ++hits[column << (k - x) | row];
            }
            CHECK(std::count(hits.begin(), hits.end(), 1) == 1 << k);
          }
        }
      }
    }
  }
}

TEST_CASE("every number of a sample alone is uniform over pixels and over seeds") {
  constexpr std::size_t bins = 64;
  for (const std::uint32_t sample : {0U, 1U, 6U, 1001U, 0xFFFFFFU}) {
    for (const bool over_seeds : {false, true}) {
      std::array<std::vector<double>, spread_numbers> counts;
      counts.fill(std::vector<double>(bins));
      for (std::uint32_t i = 0; i < 20'000; ++i) {
        const Numbers u = numbers_of(
            SampleRandom(over_seeds ? i : 5, over_seeds ? 5 : i, sample, Sampler::sobol));
        for (std::size_t k = 0; k < spread_numbers; ++k) counts[k][bin_of(u[k], bins)] += 1;
      }
      for (const auto& of_number : counts) CHECK(std::abs(chi_square_z(of_number)) < z_limit);
    }
  }
}

TEST_CASE("replicates, pixels and seeds are independent of each other") {
  std::array<std::array<std::vector<double>, 4>, integrands.size()> means;
  for (std::uint32_t pixel = 0; pixel < 4000; ++pixel) {
    const std::array<Means, 4> of{
        replicate_means(1, pixel, 0, 16), replicate_means(1, pixel, 1, 16),
        replicate_means(1, pixel + 1, 0, 16), replicate_means(2, pixel, 0, 16)};
    for (std::size_t k = 0; k < integrands.size(); ++k) {
      for (std::size_t i = 0; i < of.size(); ++i) means[k][i].push_back(of[i][k]);
    }
  }
  for (const auto& [here, other_replicate, next_pixel, next_seed] : means) {
    CHECK(std::abs(correlation_z(here, other_replicate)) < z_limit);
    CHECK(std::abs(correlation_z(here, next_pixel)) < z_limit);
    CHECK(std::abs(correlation_z(here, next_seed)) < z_limit);
  }
}

TEST_CASE("numbers of different purposes and bounces are independent over seeds") {
  std::array<std::vector<double>, spread_numbers> values;
  for (std::uint64_t seed = 0; seed < 20'000; ++seed) {
    const Numbers u = point(seed, 3, 1, 5);
    for (std::size_t k = 0; k < spread_numbers; ++k) values[k].push_back(u[k]);
  }
  for (std::size_t i = 0; i < spread_numbers; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      CHECK(std::abs(correlation_z(values[i], values[j])) < z_limit);
    }
  }
}

// What errors are estimated from: the variance of a pixel's mean over seeds is that of the
// textbook's scrambling, whatever the integrand, for full and for broken numbers of points.
TEST_CASE("a replicate's mean varies over seeds as by nested uniform scrambling") {
  for (const std::uint32_t points : {8U, 21U, 32U}) {
    CAPTURE(points);
    std::array<Moments, integrands.size()> found;
    std::array<Moments, integrands.size()> expected;
    for (std::uint32_t trial = 0; trial < 12'000; ++trial) {
      const Means ours = replicate_means(trial, 12345, trial % 2, points);
      const Means textbook = textbook_means(trial, points);
      for (std::size_t k = 0; k < integrands.size(); ++k) {
        found[k].add(ours[k]);
        expected[k].add(textbook[k]);
      }
    }
    for (std::size_t k = 0; k < integrands.size(); ++k) {
      CAPTURE(k);
      const double error = std::hypot(found[k].variance_error(), expected[k].variance_error());
      CHECK(std::abs(found[k].variance() - expected[k].variance()) < z_limit * error);
      CHECK(error < 0.04 * expected[k].variance());  // or the check would say little
      const double of_means =
          std::sqrt((found[k].variance() + expected[k].variance()) / found[k].count());
      CHECK(std::abs(found[k].mean() - expected[k].mean()) < z_limit * of_means);
    }
  }
}

TEST_CASE("any number of points is better than as many independent ones") {
  for (const std::uint32_t points : {3U, 7U, 12U, 16U, 23U, 48U, 100U}) {
    CAPTURE(points);
    std::array<Moments, integrands.size()> sobol;
    std::array<Moments, integrands.size()> single;
    for (std::uint32_t pixel = 0; pixel < 1000; ++pixel) {
      const Means means = replicate_means(11, pixel, 0, points);
      const Numbers u = numbers_of(SampleRandom(11, pixel, 0));
      for (std::size_t k = 0; k < integrands.size(); ++k) {
        sobol[k].add(means[k]);
        single[k].add(integrands[k](u));
      }
    }
    for (std::size_t k = 0; k < integrands.size(); ++k) {
      CAPTURE(k);
      CHECK(sobol[k].variance() < 0.95 * single[k].variance() / points);
    }
  }
}

TEST_CASE("the Sobol sampler leaves fuzz and later bounces to independent numbers") {
  for (std::uint32_t sample = 0; sample < 50; ++sample) {
    const SampleRandom sobol(3, 17, sample, Sampler::sobol);
    const SampleRandom independent(3, 17, sample);
    const auto same = [&](std::uint32_t bounce, Purpose purpose) {
      return sobol.at<double>(bounce, purpose).a == independent.at<double>(bounce, purpose).a;
    };
    CHECK(same(0, Purpose::fuzz));
    CHECK(same(SobolSets::bounces, Purpose::scatter));
    CHECK_FALSE(same(SobolSets::bounces - 1, Purpose::scatter));
    CHECK_FALSE(same(0, Purpose::camera));
  }
}

TEST_CASE("the Sobol sampler's numbers are equal in every precision and in lanes") {
  using Uint = math::scalar::DoubleLanes::Uint;
  for (std::uint32_t first = 0; first < 400; first += 4) {
    Uint pixel;
    Uint sample;
    for (std::uint32_t i = 0; i < 4; ++i) {
      pixel.v[i] = 0x10000001 * (first + i);
      sample.v[i] = (first + i) * (first + i);
    }
    const RandomAddress<Uint> lanes(~5ULL, pixel, sample, Sampler::sobol);
    for (const Purpose purpose : {Purpose::camera, Purpose::scatter}) {
      const std::uint32_t bounce = purpose == Purpose::scatter ? first % 5 : 0;
      const auto u = lanes.at<math::scalar::DoubleLanes>(bounce, purpose);
      double a[4];
      double b[4];
      double c[4];
      double d[4];
      u.a.store(a);
      u.b.store(b);
      u.c.store(c);
      u.d.store(d);
      for (std::uint32_t i = 0; i < 4; ++i) {
        const SampleRandom alone(~5ULL, pixel.v[i], sample.v[i], Sampler::sobol);
        const auto wide = alone.at<double>(bounce, purpose);
        const auto narrow = alone.at<float>(bounce, purpose);
        CHECK((a[i] == wide.a && b[i] == wide.b && c[i] == wide.c && d[i] == wide.d));
        CHECK(
            (narrow.a == wide.a && narrow.b == wide.b && narrow.c == wide.c && narrow.d == wide.d));
      }
    }
  }
}

// By another program, from the definitions.
TEST_CASE("the Sobol sampler has known answers") {
  const auto camera = SampleRandom(1, 2, 1003, Sampler::sobol).at<double>(0, Purpose::camera);
  CHECK(camera.a * 0x1p24 == 5'581'936);
  CHECK(camera.b * 0x1p24 == 3'879'350);
  CHECK(camera.c * 0x1p24 == 6'639'858);
  CHECK(camera.d * 0x1p24 == 5'061'366);
  const auto turn = SampleRandom(1, 2, 77, Sampler::sobol).at<double>(2, Purpose::scatter);
  CHECK(turn.a * 0x1p24 == 15'233'852);
  CHECK(turn.b * 0x1p24 == 15'612'472);
}

// The same expectation by both samplers: differences of the means of blocks against their errors
// over seeds. A wrong joint distribution would show here, where it matters.
TEST_CASE("both samplers have the same mean picture") {
  const Scene scene = small_scene();
  RenderSettings settings;
  settings.width = 24;
  settings.height = 16;
  settings.precision = Precision::f32;
  settings.accelerator = AcceleratorKind::linear;
  constexpr std::uint32_t seeds = 64;
  constexpr std::size_t blocks = 24;  // of 4 x 4 pixels
  std::array<std::array<Moments, blocks>, 2> means;
  const RadianceScale scale(largest_radiance(scene));
  for (const Sampler sampler : {Sampler::independent, Sampler::sobol}) {
    settings.sampler = sampler;
    for (std::uint32_t seed = 0; seed < seeds; ++seed) {
      settings.seed = 2 * seed + (sampler == Sampler::sobol ? 1 : 0);
      const auto tracer = make_path_tracer(scene, settings);
      std::array<double, blocks> of_block{};
      for (std::uint32_t y = 0; y < settings.height; ++y) {
        std::vector<PixelSums> row(settings.width);
        TraceCounts counts;
        tracer->trace({y, 0, settings.width}, {0, 50}, row, counts);
        for (std::uint32_t x = 0; x < settings.width; ++x) {
          for (const std::uint64_t sum : row[x].sum) {
            of_block[y / 4 * 6 + x / 4] += scale.mean(sum, 50) / 48;
          }
        }
      }
      for (std::size_t b = 0; b < blocks; ++b) {
        means[static_cast<std::size_t>(sampler)][b].add(of_block[b]);
      }
    }
  }
  double gain = 0;
  for (std::size_t b = 0; b < blocks; ++b) {
    const Moments& independent = means[0][b];
    const Moments& sobol = means[1][b];
    const double error = std::sqrt((independent.variance() + sobol.variance()) / seeds);
    CHECK(std::abs(independent.mean() - sobol.mean()) <= z_limit * error);
    gain += independent.variance() / std::max(sobol.variance(), 1e-12) / blocks;
  }
  CHECK(gain > 1.5);
}

}  // namespace parray::test
