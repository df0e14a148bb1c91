#include "cli/check/compare/metrics.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "tests/support/rooms.h"

namespace parray {
namespace {

constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();
constexpr float infinity = std::numeric_limits<float>::infinity();

/// A picture of one row.
Image row_of(const std::vector<float>& rgb) {
  return {static_cast<std::uint32_t>(rgb.size() / 3), 1, rgb};
}

Image grey(std::uint32_t width, std::uint32_t height, float value) {
  return {width, height, std::vector<float>(std::size_t{width} * height * 3, value)};
}

}  // namespace

TEST_CASE("every metric of two pixels has the value computed by hand") {
  // Differences: 0.5, 0, -0.25; 0, 0, 1.
  const ErrorMetrics m =
      error_metrics(row_of({0.5F, 1, 0.25F, 0, 2, 0}), row_of({1, 1, 0, 0, 2, 1}));
  CHECK(m.mse == doctest::Approx((0.25 + 0.0625 + 1) / 6).epsilon(1e-12));
  CHECK(m.rmse == doctest::Approx(std::sqrt(1.3125 / 6)).epsilon(1e-12));
  CHECK(m.psnr == doctest::Approx(6.6005194).epsilon(1e-7));  // -10 log10(0.21875)
  CHECK(m.relative_mse ==
        doctest::Approx((0.25 / 0.26 + 0.0625 / 0.0725 + 1 / 0.01) / 6).epsilon(1e-12));
  CHECK(m.smape == doctest::Approx((0.5 / 1.51 + 0.25 / 0.26 + 1 / 1.01) / 6).epsilon(1e-12));
  CHECK(m.mean_absolute == doctest::Approx(1.75 / 6).epsilon(1e-12));
  CHECK(m.bias == doctest::Approx(1.25 / 6).epsilon(1e-12));
  CHECK(m.absolute_999 == 1);
  CHECK(m.largest_absolute == 1);
  CHECK(m.worst_x == 1);
  CHECK(m.worst_y == 0);
  CHECK(m.compared == 2);
  CHECK(m.excluded == 0);
}

TEST_CASE("a picture that is too dark has a negative bias, and the reference alone scales relMSE") {
  const Image dark = grey(4, 4, 0.5F);
  const Image bright = grey(4, 4, 1);
  CHECK(error_metrics(bright, dark).bias == -0.5);
  CHECK(error_metrics(dark, bright).bias == 0.5);
  CHECK(error_metrics(bright, dark).relative_mse == doctest::Approx(0.25 / 1.01));
  CHECK(error_metrics(dark, bright).relative_mse == doctest::Approx(0.25 / 0.26));
}

TEST_CASE("the 99.9th percentile of 3000 values is the 2997th, of 999 values the last") {
  // |F - R| = 1, 2, 3, ... in no order, with either sign.
  const auto errors_of = [](std::uint32_t pixels) {
    const Image reference = grey(pixels, 1, 0);
    Image image = reference;
    for (std::uint32_t i = 0; i < pixels * 3; ++i) {
      image.rgb[i * 7 % (pixels * 3)] = static_cast<float>(i + 1) * (i % 2 == 0 ? 1.0F : -1.0F);
    }
    return error_metrics(reference, image);
  };
  CHECK(errors_of(333).absolute_999 == 999);  // rank ceil(998.001)
  const ErrorMetrics m = errors_of(1000);
  CHECK(m.absolute_999 == 2997);
  CHECK(m.largest_absolute == 3000);
  CHECK(m.worst_x == 2999 * 7 % 3000 / 3);
}

TEST_CASE("the worst pixel has the right row and column; of several equal ones it is the first") {
  const Image reference = grey(5, 4, 0.5F);
  Image image = reference;
  image.rgb[(2 * 5 + 3) * 3 + 1] = 0.25F;
  image.rgb[(3 * 5 + 1) * 3 + 2] = 0.75F;
  const ErrorMetrics m = error_metrics(reference, image);
  CHECK(m.worst_x == 3);
  CHECK(m.worst_y == 2);
}

TEST_CASE("equal pictures have no error and an infinite PSNR") {
  const ErrorMetrics m = error_metrics(grey(3, 2, 0.7F), grey(3, 2, 0.7F));
  CHECK(m.mse == 0);
  CHECK(m.psnr == std::numeric_limits<double>::infinity());
  CHECK(m.relative_mse == 0);
  CHECK(m.smape == 0);
  CHECK(m.largest_absolute == 0);
  CHECK(m.worst_x == 0);
}

TEST_CASE("squares of the largest floats do not overflow") {
  constexpr float largest = std::numeric_limits<float>::max();
  const ErrorMetrics m = error_metrics(grey(2, 2, -largest), grey(2, 2, largest));
  CHECK(m.largest_absolute == 2 * static_cast<double>(largest));
  CHECK(m.rmse == doctest::Approx(2 * static_cast<double>(largest)));
  CHECK(m.smape == doctest::Approx(1));
}

TEST_CASE("pixels that are not finite are counted for each picture and change no metric") {
  const Image reference = row_of({0, 0, 0, nan_value, 1, 1, 1, 1, 1, 1, 1, 1});
  const Image image = row_of({0, 0, 0.5F, 9, 9, 9, 1, infinity, 1, 1, -infinity, nan_value});
  const ErrorMetrics m = error_metrics(reference, image);
  CHECK(m.nonfinite_in_reference == 1);
  CHECK(m.nonfinite_in_image == 2);
  CHECK(m.excluded == 3);
  CHECK(m.compared == 1);
  CHECK(m.mse == doctest::Approx(0.25 / 3));
  CHECK(m.largest_absolute == 0.5);
  CHECK(m.worst_x == 0);
}

TEST_CASE("if no pixel is finite in both pictures, there is no error") {
  const ErrorMetrics m = error_metrics(grey(2, 1, nan_value), grey(2, 1, 1));
  CHECK_FALSE(m.any());
  CHECK(m.excluded == 2);
  for (const double value : {m.mse, m.rmse, m.psnr, m.relative_mse, m.smape, m.mean_absolute,
                             m.bias, m.absolute_999, m.largest_absolute}) {
    CHECK(std::isnan(value));
  }
}

TEST_CASE("pictures are the same if size and bits are equal") {
  CHECK(same_bits(grey(2, 3, 0.1F), grey(2, 3, 0.1F)));
  CHECK(same_bits(grey(2, 3, nan_value), grey(2, 3, nan_value)));
  CHECK_FALSE(same_bits(grey(2, 3, 0.1F), grey(3, 2, 0.1F)));
  CHECK_FALSE(same_bits(grey(2, 3, 0.0F), grey(2, 3, -0.0F)));
  Image other = grey(2, 3, 0.1F);
  other.rgb.back() = std::nextafter(0.1F, 1.0F);
  CHECK_FALSE(same_bits(grey(2, 3, 0.1F), other));
}

TEST_CASE("a verification picture is white minus the sum of all differences, for each channel") {
  const Image reference = row_of({0.5F, 0.5F, 0.5F, 3, 0, 0});
  DifferenceImage verification(reference);
  CHECK(verification.largest() == 0);
  CHECK(verification.drawn().rgb == std::vector<float>(6, 1));
  verification.add(row_of({0.25F, 0.5F, 0.625F, 1, 0, 0}));
  verification.add(row_of({0.75F, 0.5F, 0.5F, 3, 0, 0}));
  CHECK(verification.largest() == 2);
  CHECK(verification.drawn().rgb == std::vector<float>{0.5F, 1, 0.875F, 0, 1, 1});
}

TEST_CASE("in a verification picture a value that is not finite differs from all other values") {
  const Image reference = row_of({nan_value, infinity, 0, nan_value, infinity, 0});
  DifferenceImage verification(reference);
  verification.add(row_of({nan_value, infinity, 0, 0, -infinity, nan_value}));
  CHECK(verification.drawn().rgb == std::vector<float>{1, 1, 1, 0, 0, 0});
}

}  // namespace parray
