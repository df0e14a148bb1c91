#include "common/image/framebuffer.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

#include "common/image/image.h"
#include "common/schedule/row_order.h"
#include "common/trace/random.h"
#include "tests/support/dice.h"

namespace parray {
namespace {

using test::Dice;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

RenderSettings sized(std::uint32_t width, std::uint32_t height, std::uint32_t spp,
                     RowOrder order = RowOrder::interleaved) {
  RenderSettings settings;
  settings.width = width;
  settings.height = height;
  settings.samples_per_pixel = spp;
  settings.row_order = order;
  return settings;
}

/// What tracing a rectangle would give, from numbers that depend on pixel and sample alone.
RowBlock made_up_block(const RenderSettings& settings, const WorkRect& rect) {
  const auto row_at = make_row_order(settings.row_order, settings.height);
  const RadianceScale scale(1);
  RowBlock block{rect, settings.width, {}, {}};
  for (std::uint32_t position = rect.row_begin; position < rect.row_end; ++position) {
    for (std::uint32_t x = 0; x < settings.width; ++x) {
      PixelSums sums;
      for (std::uint32_t s = rect.sample_begin; s < rect.sample_end; ++s) {
        const SampleRandom random(1, row_at[position] * settings.width + x, s);
        const auto u = random.at<double>(0, Purpose::scatter);
        sums.add({scale.to_fixed(u.a * u.d), scale.to_fixed(u.b / 3), scale.to_fixed(u.c)}, s);
        ++block.counts.samples;
        block.counts.rays += static_cast<std::uint64_t>(u.a * 8);
      }
      block.pixels.push_back(sums);
    }
  }
  return block;
}

WorkRect whole(const RenderSettings& settings) {
  return {0, settings.height, 0, settings.samples_per_pixel};
}

/// Cuts a rectangle at random places until the pieces are done.
void cut(Dice& dice, const WorkRect& rect, std::vector<WorkRect>& pieces) {
  const bool rows = rect.rows() > 1 && (rect.samples() == 1 || dice.one_in(2));
  if ((rect.rows() == 1 && rect.samples() == 1) || dice.one_in(4)) {
    pieces.push_back(rect);
    return;
  }
  WorkRect first = rect;
  WorkRect second = rect;
  if (rows) {
    first.row_end = second.row_begin = rect.row_begin + 1 + dice.below32(rect.rows() - 1);
  } else {
    first.sample_end = second.sample_begin =
        rect.sample_begin + 1 + dice.below32(rect.samples() - 1);
  }
  cut(dice, first, pieces);
  cut(dice, second, pieces);
}

}  // namespace

TEST_CASE("any split into rectangles, merged in any order, gives the same sums") {
  Dice dice(1);
  for (int round = 0; round < 60; ++round) {
    const RowOrder order = dice.one_in(2) ? RowOrder::interleaved : RowOrder::sequential;
    const auto settings =
        sized(1 + dice.below32(9), 1 + dice.below32(13), 1 + dice.below32(17), order);
    Framebuffer at_once(settings);
    at_once.merge(made_up_block(settings, whole(settings)));
    std::vector<WorkRect> pieces;
    cut(dice, whole(settings), pieces);
    for (std::size_t i = pieces.size(); i > 1; --i) {
      std::swap(pieces[i - 1], pieces[dice.below(i)]);
    }
    Framebuffer merged(settings);
    for (const WorkRect& piece : pieces) {
      merged.merge(made_up_block(settings, piece));
    }
    REQUIRE(merged.pixels() == at_once.pixels());
    REQUIRE(merged.counts() == at_once.counts());
    REQUIRE(merged.samples() ==
            std::vector<std::uint32_t>(merged.pixels().size(), settings.samples_per_pixel));
    CHECK(image_sha256(resolve_image(merged, 1)) == image_sha256(resolve_image(at_once, 1)));
  }
}

TEST_CASE("the order of rows does not change the picture") {
  std::array<std::string, 2> hashes;
  for (const RowOrder order : {RowOrder::sequential, RowOrder::interleaved}) {
    const auto settings = sized(7, 11, 3, order);
    Framebuffer framebuffer(settings);
    framebuffer.merge(made_up_block(settings, whole(settings)));
    hashes[order == RowOrder::interleaved ? 1 : 0] = image_sha256(resolve_image(framebuffer, 1));
  }
  CHECK(hashes[0] == hashes[1]);
}

TEST_CASE("a block's rows land where the row order says, and count their samples") {
  const auto settings = sized(2, 5, 8);
  const auto row_at = make_row_order(RowOrder::interleaved, 5);
  Framebuffer framebuffer(settings);
  RowBlock block{{3, 4, 2, 5}, 2, {6, 9, 0}, std::vector<PixelSums>(2)};
  block.pixels[1].sum = {7, 8, 9};
  framebuffer.merge(block);
  for (std::uint32_t row = 0; row < 5; ++row) {
    const PixelSums* pixels = framebuffer.pixels().data() + std::size_t{row} * 2;
    CHECK(framebuffer.samples()[std::size_t{row} * 2] == (row == row_at[3] ? 3U : 0U));
    CHECK(pixels[0].sum[0] == 0);
    CHECK(pixels[1].sum[0] == (row == row_at[3] ? 7U : 0U));
  }
  CHECK(framebuffer.counts() == TraceCounts{6, 9, 0, 0});
}

TEST_CASE("a block that does not fit the image is refused and changes nothing") {
  const auto settings = sized(2, 5, 8);
  Framebuffer framebuffer(settings);
  const auto block = [](WorkRect rect, std::uint32_t width, std::size_t pixels) {
    return RowBlock{rect, width, {}, std::vector<PixelSums>(pixels)};
  };
  CHECK_THROWS_AS(framebuffer.merge(block({0, 1, 0, 8}, 3, 3)), std::logic_error);
  CHECK_THROWS_AS(framebuffer.merge(block({4, 6, 0, 8}, 2, 4)), std::logic_error);
  CHECK_THROWS_AS(framebuffer.merge(block({0, 2, 0, 8}, 2, 3)), std::logic_error);
  CHECK_THROWS_AS(framebuffer.merge(block({3, 2, 0, 8}, 2, 0)), std::logic_error);
  CHECK_THROWS_AS(framebuffer.merge(block({0, 0xFFFFFFFF, 0, 8}, 2, 10)), std::logic_error);
  CHECK(framebuffer.pixels() == std::vector<PixelSums>(10));
  CHECK(framebuffer.counts() == TraceCounts{});
  CHECK_NOTHROW(framebuffer.merge(block({4, 5, 0, 8}, 2, 2)));
}

TEST_CASE("fixed point adds exactly where a float stops counting") {
  const RadianceScale scale(1);
  constexpr std::uint32_t count = 1U << 25;
  const std::uint64_t half = scale.to_fixed(0.5);
  const std::uint64_t tiny = scale.to_fixed(0x1p-30);
  std::uint64_t half_sum = 0;
  std::uint64_t tiny_sum = 0;
  float float_sum = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    half_sum += half;
    tiny_sum += tiny;
    float_sum += 0.5F;
  }
  CHECK(scale.mean(half_sum, count) == 0.5);
  CHECK(scale.mean(tiny_sum, count) == 0x1p-30);
  CHECK(float_sum / static_cast<float>(count) < 0.3F);
}

TEST_CASE("the largest radiance maps into (2^31, 2^32], by a power of two") {
  Dice dice(2);
  std::vector<double> largest{1e-50, 0x1p-20, 0.5, 1, 1 + 0x1p-52, 2, 3, 1e6};
  for (int i = 0; i < 1000; ++i) {
    largest.push_back(dice.ten_to(-12, 6));
  }
  for (const double value : largest) {
    CAPTURE(value);
    const RadianceScale scale(value);
    const std::uint64_t fixed = scale.to_fixed(value);
    CHECK(fixed >= std::uint64_t{1} << 31);  // equal by rounding only
    CHECK(fixed <= std::uint64_t{1} << 32);
    CHECK(scale.to_fixed(value * 1.5) <= std::uint64_t{1} << 32);
    CHECK(std::abs(scale.mean(fixed, 1) - value) <= value * 0x1p-31);
    // A power of two: half of the value has exactly half of the number, rounding apart.
    CHECK(std::abs(static_cast<double>(scale.to_fixed(value / 2)) -
                   static_cast<double>(fixed) / 2) <= 0.5);
  }
}

TEST_CASE("a sky that is dark, or darker than a float32 can say, has the scale of 1") {
  for (const double largest : {0.0, 5e-324, 1e-300, 1e-80}) {
    const RadianceScale scale(largest);
    CHECK(scale.to_fixed(1) == std::uint64_t{1} << 32);
    CHECK(scale.to_fixed(0) == 0);
    CHECK(scale.mean(scale.to_fixed(largest), 1) == 0);
  }
}

TEST_CASE("fixed point rounds to nearest and clamps what rounding or a fault puts outside") {
  const RadianceScale scale(1);
  CHECK(scale.to_fixed(0x1p-32) == 1);
  CHECK(scale.to_fixed(0x1.8p-32) == 2);
  CHECK(scale.to_fixed(0x1.7ffffp-32) == 1);
  CHECK(scale.to_fixed(0x1p-34) == 0);
  CHECK(scale.to_fixed(1 + 0x1p-23) == std::uint64_t{1} << 32);
  CHECK(scale.to_fixed(1e300) == std::uint64_t{1} << 32);
  CHECK(scale.to_fixed(inf) == std::uint64_t{1} << 32);
  CHECK(scale.to_fixed(-0.0) == 0);
  CHECK(scale.to_fixed(-1) == 0);
  CHECK(scale.to_fixed(-inf) == 0);
  CHECK(scale.to_fixed(nan) == 0);
}

TEST_CASE("fixed point keeps order and errs by half a unit at most") {
  Dice dice(3);
  const RadianceScale scale(3.5);
  double before = 0;
  for (int i = 0; i < 100'000; ++i) {
    const double value = dice.between(0, 3.5);
    CHECK_UNARY(std::abs(scale.mean(scale.to_fixed(value), 1) - value) <= 0x1p-31);
    CHECK_UNARY((value >= before) == (scale.to_fixed(value) >= scale.to_fixed(before)));
    before = value;
  }
}

TEST_CASE("a pass gives each pixel samples of its own, and a block counts what pixels have of it") {
  const auto settings = sized(2, 2, 8, RowOrder::sequential);
  Framebuffer framebuffer(settings);
  framebuffer.begin_pass({4, 4, 4, 4});
  CHECK(framebuffer.pass_rect() == WorkRect{0, 2, 0, 4});
  CHECK(framebuffer.samples_of({0, 2, 0, 4}).empty());  // all alike
  framebuffer.merge({{0, 2, 0, 4}, 2, {16, 16, 0, 0}, std::vector<PixelSums>(4)});
  framebuffer.begin_pass({4, 10, 6, 20});
  CHECK(framebuffer.pass_rect() == WorkRect{0, 2, 4, 20});
  CHECK(framebuffer.samples_of({0, 2, 5, 12}) ==
        std::vector<SampleRange>{{5, 5}, {5, 10}, {5, 6}, {5, 12}});
  CHECK(framebuffer.sample_count({0, 2, 5, 12}) == 13);
  framebuffer.merge({{0, 2, 5, 12}, 2, {13, 13, 0, 0}, std::vector<PixelSums>(4)});
  CHECK(framebuffer.samples() == std::vector<std::uint32_t>{4, 9, 5, 11});
  CHECK_THROWS_AS(framebuffer.begin_pass({4, 9, 5, 10}), std::logic_error);
  CHECK_THROWS_AS(framebuffer.begin_pass({99, 99}), std::logic_error);
}

TEST_CASE("sums of squares give the variance of a sample") {
  for (const double largest : {1.0, 3.0, 0.01}) {
    const RadianceScale scale(largest);
    PixelSums sums;
    double mean_square = 0;
    constexpr std::uint32_t count = 1000;
    for (std::uint32_t i = 0; i < count; ++i) {
      const double value = largest * i / count;
      sums.add({scale.to_fixed(value), scale.to_fixed(largest), 0}, i);
      mean_square += value * value / count;
    }
    CHECK(scale.mean_square(sums.sum_of_squares[0], count) ==
          doctest::Approx(mean_square).epsilon(1e-8));
    CHECK(scale.mean_square(sums.sum_of_squares[1], count) ==
          doctest::Approx(largest * largest).epsilon(1e-8));
    CHECK(scale.mean_square(sums.sum_of_squares[2], count) == 0);
  }
  CHECK(RadianceScale::square_of(std::uint64_t{1} << 32) == std::uint64_t{1} << 32);
  CHECK(RadianceScale::square_of((std::uint64_t{1} << 32) - 1) == 0xFFFFFFFE);
}

TEST_CASE("the most samples that a pixel may have fit its sums") {
  // limits::max_samples_per_pixel is 2^24; the sums are made for 2^31 of the largest value.
  const std::uint64_t largest = RadianceScale(1).to_fixed(1);
  const std::uint64_t most = std::uint64_t{1} << 31;
  CHECK(largest <= std::numeric_limits<std::uint64_t>::max() / most);
  CHECK(RadianceScale(1).mean(largest * most, most) == 1);
}

TEST_CASE("a white furnace is exactly 1.0f for every number of samples") {
  const RadianceScale scale(1);
  for (std::uint32_t count = 1; count <= 3000; ++count) {
    CHECK_UNARY(scale.mean(count * scale.to_fixed(1), count) == 1.0);
  }
  const auto settings = sized(3, 2, 7);
  Framebuffer framebuffer(settings);
  RowBlock block{whole(settings), 3, {42, 42, 0, 0}, std::vector<PixelSums>(6)};
  for (PixelSums& pixel : block.pixels) {
    for (std::uint32_t s = 0; s < 7; ++s) {
      pixel.add({scale.to_fixed(1), scale.to_fixed(1), scale.to_fixed(1)}, s);
    }
  }
  framebuffer.merge(block);
  const Image image = resolve_image(framebuffer, 1);
  CHECK(image.rgb == std::vector<float>(18, 1.0F));
}

TEST_CASE("rows without samples are black, rows with some are their mean") {
  const auto settings = sized(1, 2, 4, RowOrder::sequential);
  Framebuffer framebuffer(settings);
  CHECK(resolve_image(framebuffer, 1).rgb == std::vector<float>(6, 0.0F));
  RowBlock block{{1, 2, 1, 3}, 1, {2, 2, 0, 0}, std::vector<PixelSums>(1)};
  const RadianceScale scale(2);
  block.pixels[0].add({scale.to_fixed(2), scale.to_fixed(1), 0}, 1);
  block.pixels[0].add({scale.to_fixed(1), scale.to_fixed(0.25), 0}, 2);
  framebuffer.merge(block);
  const Image image = resolve_image(framebuffer, 2);
  CHECK(image.width == 1);
  CHECK(image.height == 2);
  CHECK(image.rgb == std::vector<float>{0, 0, 0, 1.5F, 0.625F, 0});
}

TEST_CASE("an image's hash is SHA-256 of its little-endian floats") {
  const Image image{2, 2, {0, 0.5F, 1, 0.25F, 2, -0.0F, 1e-30F, 3.14159274F, 1e6F, 1, 1, 1}};
  // python3: hashlib.sha256(struct.pack('<12f', ...)).hexdigest()
  CHECK(image_sha256(image) == "3f68ab9d26423233fdbb47676fee58606783d8a31f6bd7d4ce5bc9c39ba49f5f");
  Image negative_zero = image;
  negative_zero.rgb[0] = -0.0F;
  CHECK(image_sha256(negative_zero) != image_sha256(image));
}

}  // namespace parray
