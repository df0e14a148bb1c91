#include "cli/output/picture/thumbnail.h"

#include <doctest/doctest.h>

#include "tests/support/rooms.h"

namespace parray {
namespace {

/// A picture of one row whose channels are equal.
Image row_of(const std::vector<float>& values) {
  Image image{static_cast<std::uint32_t>(values.size()), 1, {}};
  for (const float value : values) image.rgb.insert(image.rgb.end(), 3, value);
  return image;
}

TEST_CASE("a thumbnail's pixels are the means of what they cover, also of parts of pixels") {
  const Image small = thumbnail(row_of({1, 2, 3, 4, 50}), 2);
  REQUIRE(small.width == 2);
  REQUIRE(small.height == 1);
  CHECK(small.rgb.at(0) == doctest::Approx((1 + 2 + 3 / 2.0) / 2.5));
  CHECK(small.rgb.at(3) == doctest::Approx((3 / 2.0 + 4 + 50) / 2.5));
}

TEST_CASE("a thumbnail keeps proportions and the mean of the picture") {
  Image image{70, 41, {}};
  double sum = 0;
  for (std::size_t i = 0; i < std::size_t{70} * 41 * 3; ++i) {
    image.rgb.push_back(static_cast<float>(i * 7919 % 1000));
    sum += image.rgb.back();
  }
  const Image small = thumbnail(image, 16);
  CHECK(small.width == 16);
  CHECK(small.height == 9);
  REQUIRE(small.rgb.size() == std::size_t{16} * 9 * 3);
  double mean = 0;
  for (const float value : small.rgb) mean += value / static_cast<double>(small.rgb.size());
  CHECK(mean == doctest::Approx(sum / static_cast<double>(image.rgb.size())));
}

TEST_CASE("a thumbnail of a picture that is not wider is the picture") {
  CHECK(thumbnail(row_of({1, 2}), 2).rgb == row_of({1, 2}).rgb);
  CHECK(thumbnail(row_of({1, 2}), 16).width == 2);
  CHECK(thumbnail(row_of(std::vector<float>(2000, 1)), 16).height == 1);
}

}  // namespace
}  // namespace parray
