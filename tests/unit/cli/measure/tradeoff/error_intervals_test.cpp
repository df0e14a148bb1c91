#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "cli/measure/tradeoff/analysis.h"
#include "common/scene/settings.h"
#include "tests/support/dice.h"
#include "tests/support/noise_trials.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::Dice;
using test::GrowingPicture;

constexpr std::uint32_t side = 48;

GrowingPicture picture_of(std::uint32_t samples, double largest, const auto& radiance_of) {
  RenderSettings settings;
  settings.width = settings.height = side;
  GrowingPicture picture(settings, largest);
  picture.make_up(std::vector<std::uint32_t>(picture.pixels.size(), samples), radiance_of);
  return picture;
}

/// How often intervals hold, by level: of pixels, and of pictures' RMSE.
struct Holding {
  std::array<double, 5> pixels{};
  std::array<double, 5> pictures{};
};

/// Of `trials` pictures of 32 samples per pixel; radiance_of(dice, pixel), whose mean is
/// truth_of(pixel).
Holding holding(int trials, double largest, const auto& radiance_of, const auto& truth_of) {
  Holding hold;
  for (int trial = 0; trial < trials; ++trial) {
    Dice dice(100 + static_cast<std::uint64_t>(trial));
    const GrowingPicture picture =
        picture_of(32, largest, [&](std::size_t pixel, auto) { return radiance_of(dice, pixel); });
    const ErrorEstimate error = estimate_error(picture.state());
    const ErrorIntervals intervals(picture.state(), error);
    const std::vector<double> means = picture.means();
    const auto count = static_cast<double>(means.size());
    double square = 0;
    for (std::size_t i = 0; i < means.size(); ++i) {
      const double off = std::abs(means[i] - truth_of(i / 3));
      square += off * off / count;
      for (std::size_t level = 0; level < 5; ++level) {
        const bool holds = off <= intervals.scale(level) * error.half_width[i];
        hold.pixels.at(level) += holds ? 1 / count / trials : 0;
      }
    }
    for (std::size_t level = 0; level < 5; ++level) {
      const auto [low, high] = intervals.rmse(level);
      const double rmse = std::sqrt(square);
      hold.pictures.at(level) += low <= rmse && rmse <= high ? 1.0 / trials : 0;
    }
  }
  return hold;
}

TEST_CASE("intervals: with nearly normal errors, intervals hold as often as stated") {
  const Holding hold = holding(
      200, 1,
      [](Dice& dice, auto) {
        return Vec3d{dice.unit(), dice.unit(), dice.unit()};
      },
      [](auto) { return 0.5; });
  for (std::size_t level = 0; level < 3; ++level) {
    CHECK(std::abs(hold.pixels.at(level) - interval_levels.at(level)) < 0.01);
    CHECK(std::abs(hold.pictures.at(level) - interval_levels.at(level)) < 0.09);
  }
}

TEST_CASE(
    "intervals: with rare noise that differs between pixels, intervals hold as often as stated") {
  // From pixel to pixel the rare light is 1 or 4 times as bright, and in half of all pixels none
  // is.
  const auto light_of = [](std::size_t pixel) {
    return pixel / side % 8 < 4 ? 0.0 : pixel % 8 < 4 ? 1.0 : 4.0;
  };
  const Holding hold = holding(
      60, 5,
      [&](Dice& dice, std::size_t pixel) {
        const double rare = dice.unit() < 0.2 ? light_of(pixel) : 0;
        const double value = 0.5 * dice.unit() + rare;
        return Vec3d{value, value, value};
      },
      [&](std::size_t pixel) { return 0.25 + 0.2 * light_of(pixel); });
  for (std::size_t level = 0; level < 3; ++level) {
    CHECK(std::abs(hold.pixels.at(level) - interval_levels.at(level)) < 0.03);
    CHECK(std::abs(hold.pictures.at(level) - interval_levels.at(level)) < 0.15);
  }
}

TEST_CASE(
    "intervals: the 95 % interval is the stated one, and higher levels have wider intervals") {
  Dice dice(7);
  const GrowingPicture picture = picture_of(16, 1, [&](auto...) {
    return Vec3d{dice.unit(), dice.unit(), dice.unit()};
  });
  const ErrorEstimate error = estimate_error(picture.state());
  const ErrorIntervals intervals(picture.state(), error);
  CHECK(intervals.scale(stated_level) == 1);
  CHECK(intervals.rmse(stated_level).low == doctest::Approx(error.low));
  CHECK(intervals.rmse(stated_level).high == doctest::Approx(error.high));
  for (std::size_t level = 1; level < interval_levels.size(); ++level) {
    CHECK(intervals.scale(level) > intervals.scale(level - 1));
    CHECK(intervals.rmse(level).low < intervals.rmse(level - 1).low);
    CHECK(intervals.rmse(level).high > intervals.rmse(level - 1).high);
  }
}

TEST_CASE("intervals: pixels without noise do not change the widths of other pixels' intervals") {
  const auto scale_of = [](bool with_sky) {
    Dice dice(8);
    const GrowingPicture picture = picture_of(32, 1, [&](std::size_t pixel, auto) {
      const double value = with_sky && pixel % 2 == 0 ? 0.25 : dice.unit();
      return Vec3d{value, value, value};
    });
    return ErrorIntervals(picture.state(), estimate_error(picture.state())).scale(0);
  };
  const double alone = scale_of(false);
  CHECK(alone == doctest::Approx(0.344).epsilon(0.03));  // a normal's
  CHECK(scale_of(true) > 0.5 * alone);
}

TEST_CASE("intervals: those of a picture without noise are finite") {
  const GrowingPicture picture = picture_of(8, 1, [](auto...) { return Vec3d{0.5, 0.5, 0.5}; });
  const ErrorIntervals intervals(picture.state(), estimate_error(picture.state()));
  CHECK(intervals.rmse(0).low == 0);
  CHECK(intervals.rmse(0).high == 0);
  CHECK(intervals.scale(0) == doctest::Approx(0.344).epsilon(0.01));
}

}  // namespace
}  // namespace parray
