#include "common/adaptive/pixel_noise.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "common/scene/settings.h"
#include "tests/support/dice.h"
#include "tests/support/noise_trials.h"
#include "tests/support/rooms.h"

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
  for (std::uint32_t& count : counts) count = 2 + 2 * dice.below32(10);
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

/// Of one pixel, by channel.
struct Noise {
  std::array<double, 3> variance{};  ///< its own
  std::array<double, 3> mean{};
  std::array<double, 3> ridge{};
  std::array<double, 3> seen{};
};

std::vector<Noise> all_of(const GrowingPicture& picture, NeighbourhoodSize horizon,
                          std::size_t stride) {
  std::vector<Noise> all;
  visit_noise(picture.state(), stride, horizon, [&](auto, auto, const NoiseNearby& row) {
    for (std::size_t i = 0; i < row.own.variance.size(); ++i) {
      const std::size_t channel = i % 3;
      Noise& noise = channel == 0 ? all.emplace_back() : all.back();
      noise.variance[channel] = row.own.variance[i];
      noise.mean[channel] = row.around.mean[i];
      noise.ridge[channel] = row.around.ridge[i];
      noise.seen[channel] = row.around.seen.empty() ? 0 : row.around.seen[i];
    }
  });
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
      const auto [least, most] = std::minmax({near[i].mean[0], middle, wide});
      REQUIRE(far[i].mean[0] >= doctest::Approx(least));
      REQUIRE(far[i].mean[0] <= doctest::Approx(most));
      if (x > 0 && y > 0 && x + 1 < width && y + 1 < height) {
        REQUIRE(near[i].mean[0] == doctest::Approx(mean_around(picture, x, y, 1)));
      }
      REQUIRE(far[i].mean[1] == 0);
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
    CHECK(after[own].mean[channel] == before[own].mean[channel]);
    CHECK(after[own].seen[channel] == before[own].seen[channel]);
  }
  CHECK(after[own + 1].mean[0] != before[own + 1].mean[0]);
}

TEST_CASE("noise: rows that are skipped change nothing of the others") {
  const GrowingPicture picture = speckled(30, 90, 2);
  for (const NeighbourhoodSize horizon :
       {NeighbourhoodSize::neighbours, NeighbourhoodSize::windows}) {
    const auto all = all_of(picture, horizon, 1);
    for (const std::size_t stride : {2U, 7U, 40U}) {
      const auto some = all_of(picture, horizon, stride);
      for (std::size_t i = 0; i < some.size(); ++i) {
        const Noise& there = all[i / 30 * stride * 30 + i % 30];
        REQUIRE(some[i].variance == there.variance);
        REQUIRE(some[i].mean[0] == there.mean[0]);
        REQUIRE(some[i].ridge[2] == there.ridge[2]);
      }
    }
  }
}

}  // namespace
}  // namespace parray
