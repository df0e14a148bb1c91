#include "common/adaptive/pixel_noise.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "tests/support/dice.h"
#include "tests/support/noise_trials.h"

namespace parray {
namespace {

using test::Dice;
using test::GrowingPicture;

/// Pixels of 2 to 20 samples of 0 or 1, few of which are 1.
GrowingPicture speckled(std::uint32_t width, std::uint32_t height, std::uint64_t seed) {
  RenderSettings settings;
  settings.width = width;
  settings.height = height;
  GrowingPicture picture(settings, 1);
  Dice dice(seed);
  std::vector<std::uint32_t> counts(picture.counts.size());
  for (std::uint32_t& count : counts) {
    count = 2 + 2 * dice.below32(10);
  }
  picture.make_up(counts, [&](auto, auto) {
    const double value = dice.unit() < 0.05 ? 1 : 0;
    return Vec3d{value, 0, value};
  });
  return picture;
}

/// Mean variance, channel 0, of the pixels at most `reach` away from (x, y), without that one.
double mean_around(const GrowingPicture& picture, std::size_t x, std::size_t y, std::size_t reach) {
  const RadianceScale scale(1);
  const std::size_t height = picture.counts.size() / picture.width;
  double sum = 0;
  double pixels = 0;
  for (std::size_t b = y - std::min(y, reach); b <= std::min(y + reach, height - 1); ++b) {
    for (std::size_t a = x - std::min(x, reach);
         a <= std::min<std::size_t>(x + reach, picture.width - 1); ++a) {
      if (a != x || b != y) {
        const std::size_t i = b * picture.width + a;
        sum += noise_of(picture.pixels[i], picture.counts[i], scale).variance[0];
        pixels += 1;
      }
    }
  }
  return sum / pixels;
}

std::vector<NoiseNearby> all_of(const GrowingPicture& picture, NeighbourhoodSize horizon,
                                std::size_t stride) {
  std::vector<NoiseNearby> all;
  visit_noise(picture.state(), stride, horizon,
              [&](auto, const NoiseNearby& noise) { all.push_back(noise); });
  return all;
}

TEST_CASE("noise: the mean around a pixel lies between those of the 8, of 80 and of 1088 others") {
  for (const auto& [width, height] : {std::pair{50U, 41U}, std::pair{7U, 60U}, std::pair{3U, 2U}}) {
    const GrowingPicture picture = speckled(width, height, width);
    const auto near = all_of(picture, NeighbourhoodSize::neighbours, 1);
    const auto far = all_of(picture, NeighbourhoodSize::windows, 1);
    for (std::size_t i = 0; i < near.size(); ++i) {
      const std::size_t x = i % width;
      const std::size_t y = i / width;
      const double wide = mean_around(picture, x, y, 16);
      const double middle = mean_around(picture, x, y, 4);
      const auto [least, most] = std::minmax({near[i].around[0].mean, middle, wide});
      REQUIRE(far[i].around[0].mean >= doctest::Approx(least));
      REQUIRE(far[i].around[0].mean <= doctest::Approx(most));
      if (x > 0 && y > 0 && x + 1 < width && y + 1 < height) {
        REQUIRE(near[i].around[0].mean == doctest::Approx(mean_around(picture, x, y, 1)));
      }
      REQUIRE(far[i].around[1].mean == 0);
    }
  }
}

TEST_CASE("noise: in a window there is nothing of the pixel's own, to the last bit") {
  GrowingPicture picture = speckled(40, 40, 1);
  const auto before = all_of(picture, NeighbourhoodSize::windows, 1);
  const std::size_t own = 17 * 40 + 23;
  picture.pixels[own] = {};
  TraceCounts ignored;
  add_sample({0.3, 0.7, 0.1}, RadianceScale(1), 1, picture.pixels[own], ignored);
  const auto after = all_of(picture, NeighbourhoodSize::windows, 1);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    CHECK(after[own].around[channel].mean == before[own].around[channel].mean);
    CHECK(after[own].around[channel].seen == before[own].around[channel].seen);
  }
  CHECK(after[own + 1].around[0].mean != before[own + 1].around[0].mean);
}

TEST_CASE("noise: rows that are skipped change nothing of the others") {
  const GrowingPicture picture = speckled(30, 90, 2);
  for (const NeighbourhoodSize horizon :
       {NeighbourhoodSize::neighbours, NeighbourhoodSize::windows}) {
    const auto all = all_of(picture, horizon, 1);
    for (const std::size_t stride : {2U, 7U, 40U}) {
      const auto some = all_of(picture, horizon, stride);
      for (std::size_t i = 0; i < some.size(); ++i) {
        const NoiseNearby& there = all[i / 30 * stride * 30 + i % 30];
        REQUIRE(some[i].own.variance == there.own.variance);
        REQUIRE(some[i].around[0].mean == there.around[0].mean);
        REQUIRE(some[i].around[2].ridge == there.around[2].ridge);
      }
    }
  }
}

}  // namespace
}  // namespace parray
