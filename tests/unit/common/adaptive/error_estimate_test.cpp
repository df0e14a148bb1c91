#include "common/adaptive/error_estimate.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "common/scene/settings.h"
#include "tests/support/dice.h"
#include "tests/support/noise_trials.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::Dice;
using test::grey;
using test::GrowingPicture;

GrowingPicture blank(std::uint32_t width, std::uint32_t height, double largest = 1) {
  RenderSettings settings;
  settings.width = width;
  settings.height = height;
  return {settings, largest};
}

std::vector<std::uint32_t> all(const GrowingPicture& picture, std::uint32_t samples) {
  return std::vector<std::uint32_t>(picture.pixels.size(), samples);
}

double rmse_from(const GrowingPicture& picture, double truth) {
  double square = 0;
  const std::vector<double> means = picture.means();
  for (const double mean : means) {
    square += (mean - truth) * (mean - truth) / static_cast<double>(means.size());
  }
  return std::sqrt(square);
}

/// The share of intervals around means that hold `truth_of(pixel)`.
template <typename TruthOf, typename Asked>
double holding(const GrowingPicture& picture, const TruthOf& truth_of, const Asked& asked) {
  const ErrorEstimate error = estimate_error(picture.state());
  const std::vector<double> means = picture.means();
  double hold = 0;
  double intervals = 0;
  for (std::size_t i = 0; i < means.size(); ++i) {
    if (asked(i / 3)) {
      hold += std::abs(means[i] - truth_of(i / 3)) <= error.half_width[i] ? 1 : 0;
      intervals += 1;
    }
  }
  return hold / intervals;
}

/// Within a share of what is expected; doctest's Approx takes 1 for small.
bool near(double value, double expected, double share) {
  return std::abs(value - expected) <= share * expected;
}

bool any(std::size_t /*pixel*/) { return true; }

TEST_CASE("error: unknown while a pixel has less than two samples") {
  Dice dice(1);
  GrowingPicture picture = blank(4, 3);
  std::vector<std::uint32_t> counts = all(picture, 8);
  counts[5] = 1;
  picture.make_up(counts, [&](auto...) { return grey(dice.unit()); });
  ErrorEstimate error = estimate_error(picture.state());
  CHECK(error.rmse == -1);
  CHECK(error.low == -1);
  CHECK(error.high == -1);
  CHECK(error.half_width_p99 == -1);
  CHECK(error.half_width.empty());
  counts[5] = 2;
  picture.make_up(counts, [&](auto...) { return grey(dice.unit()); });
  error = estimate_error(picture.state());
  CHECK(error.rmse > 0);
  CHECK(error.half_width.size() == 36);
  CHECK(estimate_error(FramebufferView{}).rmse == -1);
}

TEST_CASE("error: of the rendered part is that of a picture of this part alone") {
  Dice dice(3);
  GrowingPicture part = blank(8, 6);
  part.make_up(all(part, 8), [&](auto...) { return grey(dice.unit()); });
  GrowingPicture picture = blank(8, 24);
  for (std::size_t i = 0; i < part.pixels.size(); ++i) {
    picture.pixels[i] = part.pixels[i];
    picture.counts[i] = part.counts[i];
  }
  const PartialError found = estimate_rmse_so_far(picture.state());
  const ErrorEstimate expected = estimate_rmse(part.state());
  CHECK(found.share == 0.25);
  CHECK(found.error.rmse == expected.rmse);
  CHECK(found.error.low == expected.low);
  CHECK(found.error.high == expected.high);
  CHECK(estimate_rmse_so_far(part.state()).share == 1);
  CHECK(estimate_rmse_so_far(part.state()).error.high == expected.high);
  GrowingPicture rows = blank(8, 16);  // of which every second row is rendered, and read
  for (std::size_t i = 0; i < rows.pixels.size(); ++i) {
    if (i / 8 % 2 == 0) {
      rows.pixels[i] = part.pixels[i % part.pixels.size()];
      rows.counts[i] = 8;
    }
  }
  CHECK(estimate_rmse_so_far(rows.state(), 2).share == 0.5);
  const PartialError nothing = estimate_rmse_so_far(blank(8, 6).state());
  CHECK(nothing.share == 0);
  CHECK_FALSE(nothing.error.known());
  CHECK(estimate_rmse_so_far(FramebufferView{}).share == 0);
}

TEST_CASE("error: pictures of any size have finite positive estimates") {
  Dice dice(2);
  for (const auto& [width, height] : {std::pair{1U, 1U}, {1U, 7U}, {7U, 1U}, {2U, 2U}, {3U, 5U}}) {
    GrowingPicture picture = blank(width, height);
    picture.make_up(all(picture, 3), [&](auto...) { return grey(dice.unit()); });
    const ErrorEstimate error = estimate_error(picture.state());
    CHECK(error.rmse > 0);
    CHECK(error.low > 0);
    CHECK(error.low < error.rmse);
    CHECK(error.high > error.rmse);
    CHECK(std::isfinite(error.high));
    for (const float half_width : error.half_width) {
      CHECK(half_width > 0);
      CHECK(std::isfinite(half_width));
    }
  }
}

TEST_CASE("error: of samples all alike is 0, but what three unseen samples could make it") {
  GrowingPicture picture = blank(40, 30);
  picture.make_up(all(picture, 50), [](auto...) { return grey(1.0 / 3); });
  const ErrorEstimate error = estimate_error(picture.state());
  CHECK(error.rmse == 0);
  CHECK(error.low == 0);
  const double unseen = std::sqrt(3.0 / (40 * 30 * 50) / 50);
  CHECK(near(error.high, unseen, 1e-6));
  CHECK(near(std::sqrt(unseen_square(1, picture.state().counts)), unseen, 1e-6));
  CHECK(error.half_width_p99 < 1.96 * unseen);
  CHECK(error.half_width_p99 > 1.96 * unseen / std::sqrt(2));
}

TEST_CASE("error: scales with the radiance, bit by bit") {
  const auto estimate = [](double factor) {
    Dice dice(3);
    GrowingPicture picture = blank(24, 16, factor);
    picture.make_up(all(picture, 10), [&](std::size_t pixel, auto) {
      return grey(factor * dice.unit() * static_cast<double>(pixel % 7) / 7);
    });
    return estimate_error(picture.state());
  };
  const ErrorEstimate one = estimate(1);
  const ErrorEstimate four = estimate(4);
  CHECK(four.rmse == 4 * one.rmse);
  CHECK(four.high == 4 * one.high);
  CHECK(four.half_width_p50 == 4 * one.half_width_p50);
  for (std::size_t i = 0; i < one.half_width.size(); ++i) {
    CHECK(four.half_width[i] == 4 * one.half_width[i]);
  }
}

TEST_CASE("error: of independent samples is their deviation over the root of their number") {
  Dice dice(4);
  for (const std::uint32_t samples : {2U, 3U, 5U, 8U, 33U, 64U}) {
    GrowingPicture picture = blank(128, 128);
    picture.make_up(all(picture, samples), [&](auto...) { return grey(dice.unit()); });
    const ErrorEstimate error = estimate_error(picture.state());
    const double expected = std::sqrt(1.0 / 12 / samples);
    CHECK(near(error.rmse, expected, 0.03));
    CHECK(near(error.half_width_p50, 1.96 * expected, 0.05));
    const double hold = holding(
        picture, [](auto) { return 0.5; }, any);
    CHECK(near(hold, 0.95, samples < 8 ? 0.035 : 0.015));
  }
}

TEST_CASE("error: a sampler that does better than independent samples is credited for it") {
  Dice dice(5);
  constexpr std::uint32_t samples = 64;
  GrowingPicture picture = blank(96, 96);
  // Each replicate has one sample in each of as many strata.
  picture.make_up(all(picture, samples), [&](std::size_t, std::uint32_t sample) {
    return grey((sample / 2 + dice.unit()) / (samples / 2));
  });
  const ErrorEstimate error = estimate_error(picture.state());
  const double truth = rmse_from(picture, 0.5);
  CHECK(truth < 0.1 * std::sqrt(1.0 / 12 / samples));
  CHECK(near(error.rmse, truth, 0.05));
  const double hold = holding(
      picture, [](auto) { return 0.5; }, any);
  CHECK(near(hold, 0.95, 0.03));
}

TEST_CASE("error: pixels that have not seen their rare bright samples yet still state enough") {
  for (const double probability : {0.02, 0.005, 0.001, 0.0003}) {
    Dice dice(6);
    GrowingPicture picture = blank(128, 128);
    picture.make_up(all(picture, 64),
                    [&](auto...) { return grey(dice.unit() < probability ? 1 : 0); });
    CHECK(holding(
              picture, [&](auto) { return probability; }, any) > 0.9);
  }
}

TEST_CASE("error: single noisy pixels in calm surroundings state enough") {
  Dice dice(7);
  GrowingPicture picture = blank(128, 128);
  const auto noisy = [](std::size_t pixel) { return pixel % 5 == 0 && pixel / 128 % 3 == 0; };
  picture.make_up(all(picture, 64), [&](std::size_t pixel, auto) {
    return grey(noisy(pixel) ? (dice.unit() < 0.4 ? 1 : 0) : 0.4 + 0.01 * dice.unit());
  });
  CHECK(holding(
            picture, [](auto) { return 0.4; }, noisy) > 0.88);
}

TEST_CASE("error: the picture's interval holds 95 times of 100, with noise of all sizes") {
  Dice dice(8);
  constexpr int pictures = 400;
  int hold = 0;
  double width = 0;
  for (int i = 0; i < pictures; ++i) {
    GrowingPicture picture = blank(24, 24);
    picture.make_up(all(picture, 16), [&](std::size_t pixel, auto) {
      const double size = static_cast<double>(pixel % 24) / 24;
      return grey(0.5 + size * size * (dice.unit() - 0.5));
    });
    const ErrorEstimate error = estimate_rmse(picture.state());
    const double truth = rmse_from(picture, 0.5);
    hold += error.low <= truth && truth <= error.high ? 1 : 0;
    width += error.high / error.low / pictures;
  }
  CHECK(hold > 0.92 * pictures);
  CHECK(width < 1.5);
}

TEST_CASE("error: without half-widths is the same error") {
  Dice dice(9);
  GrowingPicture picture = blank(20, 10);
  picture.make_up(all(picture, 7), [&](auto...) { return grey(dice.unit()); });
  const ErrorEstimate whole = estimate_error(picture.state());
  const ErrorEstimate part = estimate_rmse(picture.state());
  CHECK(part.rmse == whole.rmse);
  CHECK(part.low == whole.low);
  CHECK(part.high == whole.high);
  CHECK(part.half_width.empty());
}

}  // namespace
}  // namespace parray
