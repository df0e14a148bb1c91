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
#include "common/trace/integrator/random.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::Dice;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

/// Samples of a run of pixels, from numbers that depend on pixel and sample alone.
struct Run {
  std::uint32_t y = 0;
  std::uint32_t x = 0;
  std::vector<SampleRange> ranges;  ///< of each pixel
};

void add(Framebuffer& framebuffer, const Run& run) {
  const RadianceScale scale(1);
  std::vector<PixelSums> sums(run.ranges.size());
  TraceCounts counts;
  for (std::uint32_t i = 0; i < run.ranges.size(); ++i) {
    for (std::uint32_t s = run.ranges[i].begin; s < run.ranges[i].end; ++s) {
      const SampleRandom random(1, run.y * framebuffer.width() + run.x + i, s);
      const auto u = random.at<double>(0, Purpose::scatter);
      sums[i].add({scale.to_fixed(u.a * u.d), scale.to_fixed(u.b / 3), scale.to_fixed(u.c)}, s);
      ++counts.samples;
      counts.rays += static_cast<std::uint64_t>(u.a * 8);
    }
  }
  framebuffer.add(run.y, run.x, sums, RunSamples(run.ranges));
  framebuffer.add(counts);
}

/// Cuts a run at random places, across pixels and across samples, until the pieces are done.
void cut(Dice& dice, const Run& run, std::vector<Run>& pieces) {
  const auto pixels = static_cast<std::uint32_t>(run.ranges.size());
  if (!dice.one_in(3)) {  // or it would hardly ever end
    pieces.push_back(run);
    return;
  }
  Run first = run;
  Run second = run;
  if (pixels > 1 && dice.one_in(2)) {
    const std::uint32_t at = 1 + dice.below32(pixels - 1);
    first.ranges.resize(at);
    second.ranges.erase(second.ranges.begin(), second.ranges.begin() + at);
    second.x += at;
  } else {
    for (std::uint32_t i = 0; i < pixels; ++i) {
      const std::uint32_t at = run.ranges[i].begin + dice.below32(run.ranges[i].count() + 1);
      first.ranges[i].end = second.ranges[i].begin = at;
    }
  }
  cut(dice, first, pieces);
  cut(dice, second, pieces);
}

}  // namespace

TEST_CASE("any split into runs of pixels and samples, added in any order, gives the same sums") {
  Dice dice(1);
  for (int round = 0; round < 60; ++round) {
    const std::uint32_t width = 1 + dice.below32(9);
    const std::uint32_t height = 1 + dice.below32(13);
    Framebuffer at_once(width, height);
    Framebuffer merged(width, height);
    std::vector<Run> pieces;
    for (std::uint32_t y = 0; y < height; ++y) {
      Run row{y, 0, std::vector<SampleRange>(width)};
      for (SampleRange& pixel : row.ranges) pixel.end = dice.below32(17);
      add(at_once, row);
      cut(dice, row, pieces);
    }
    for (std::size_t i = pieces.size(); i > 1; --i) std::swap(pieces[i - 1], pieces[dice.below(i)]);
    for (const Run& piece : pieces) add(merged, piece);
    REQUIRE(std::ranges::equal(merged.pixels(), at_once.pixels()));
    REQUIRE(merged.counts() == at_once.counts());
    REQUIRE(std::ranges::equal(merged.samples(), at_once.samples()));
    REQUIRE(merged.whole() == at_once.whole());
    CHECK(image_sha256(resolve_image(merged, 1)) == image_sha256(resolve_image(at_once, 1)));
  }
}

TEST_CASE("a run lands on its pixels, and counts their samples") {
  Framebuffer framebuffer(4, 3);
  std::vector<PixelSums> sums(2);
  sums[1].sum = {7, 8, 9};
  const std::vector<SampleRange> ranges{{0, 0}, {3, 5}};
  framebuffer.add(1, 2, sums, RunSamples(ranges));
  for (std::size_t pixel = 0; pixel < 12; ++pixel) {
    CHECK(framebuffer.samples()[pixel] == (pixel == 7 ? 2U : 0U));
    CHECK(framebuffer.pixels()[pixel].sum[0] == (pixel == 7 ? 7U : 0U));
  }
  CHECK(framebuffer.counts() == TraceCounts{});
}

TEST_CASE("what does not fit the image is refused and changes nothing") {
  Framebuffer framebuffer(2, 5);
  const auto add_run = [&](std::uint32_t y, std::uint32_t x, std::size_t pixels) {
    framebuffer.add(y, x, std::vector<PixelSums>(pixels), RunSamples(SampleRange{0, 1}));
  };
  CHECK_THROWS_AS(add_run(0, 0, 3), std::logic_error);
  CHECK_THROWS_AS(add_run(0, 1, 2), std::logic_error);
  CHECK_THROWS_AS(add_run(0, 3, 0), std::logic_error);
  CHECK_THROWS_AS(add_run(5, 0, 1), std::logic_error);
  CHECK_THROWS_AS(framebuffer.exclude({5, 0, 0, 1}), std::logic_error);
  CHECK_THROWS_AS(framebuffer.exclude({0, 2, 0, 1}), std::logic_error);
  CHECK(std::ranges::equal(framebuffer.samples(), std::vector<std::uint32_t>(10)));
  CHECK(framebuffer.excluded().empty());
  CHECK_NOTHROW(add_run(4, 0, 2));
}

TEST_CASE("an image is whole once every pixel has a sample, and not when one is set back") {
  Framebuffer framebuffer(3, 2);
  add(framebuffer, {0, 0, {{0, 2}, {0, 2}, {0, 2}}});
  add(framebuffer, {1, 0, {{0, 2}, {0, 0}, {0, 2}}});
  CHECK_FALSE(framebuffer.whole());
  add(framebuffer, {1, 1, {{0, 1}}});
  add(framebuffer, {1, 1, {{1, 4}}});
  CHECK(framebuffer.whole());
  framebuffer.clear(1, 1, 2, {});
  CHECK_FALSE(framebuffer.whole());
  framebuffer.clear(1, 1, 2, {});
  add(framebuffer, {1, 1, {{0, 1}}});
  CHECK(framebuffer.whole());
}

TEST_CASE("pixels that are set back are as if nothing had come, and others as they were") {
  Dice dice(5);
  for (int round = 0; round < 50; ++round) {
    Framebuffer changed(6, 4);
    Framebuffer expected(6, 4);
    const std::uint32_t begin = dice.below32(6);
    const std::uint32_t end = begin + 1 + dice.below32(6 - begin);
    TraceCounts gone;
    for (std::uint32_t y = 0; y < 4; ++y) {
      for (std::uint32_t x = 0; x < 6; ++x) {
        const Run pixel{y, x, {{0, dice.below32(5)}}};
        const TraceCounts before = changed.counts();
        add(changed, pixel);
        changed.exclude({y, x, 3, 1});
        if (y == 2 && x >= begin && x < end) {
          TraceCounts its = changed.counts();
          its -= before;
          gone += its;
        } else {
          add(expected, pixel);
          expected.exclude({y, x, 3, 1});
        }
      }
    }
    changed.clear(2, begin, end, gone);
    REQUIRE(std::ranges::equal(changed.pixels(), expected.pixels()));
    REQUIRE(std::ranges::equal(changed.samples(), expected.samples()));
    REQUIRE(changed.counts() == expected.counts());
    REQUIRE(changed.excluded().size() == expected.excluded().size());
    REQUIRE_FALSE(changed.excluded().contains({2, begin}));
  }
}

TEST_CASE("excluded samples of one pixel add up, from the first of them on") {
  Framebuffer framebuffer(2, 1);
  framebuffer.exclude({0, 1, 40, 2});
  framebuffer.exclude({0, 1, 7, 1});
  REQUIRE(framebuffer.excluded().size() == 1);
  CHECK(framebuffer.excluded().at({0, 1}).first == 7);
  CHECK(framebuffer.excluded().at({0, 1}).count == 3);
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
  for (int i = 0; i < 1000; ++i) largest.push_back(dice.ten_to(-12, 6));
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
  Framebuffer framebuffer(3, 2);
  std::vector<PixelSums> row(3);
  for (PixelSums& pixel : row) {
    for (std::uint32_t s = 0; s < 7; ++s) {
      pixel.add({scale.to_fixed(1), scale.to_fixed(1), scale.to_fixed(1)}, s);
    }
  }
  for (const std::uint32_t y : {0U, 1U}) {
    framebuffer.add(y, 0, row, RunSamples(SampleRange{0, 7}));
  }
  const Image image = resolve_image(framebuffer, 1);
  CHECK(image.rgb == std::vector<float>(18, 1.0F));
}

TEST_CASE("pixels without samples are black, others their mean") {
  Framebuffer framebuffer(1, 2);
  CHECK(resolve_image(framebuffer, 1).rgb == std::vector<float>(6, 0.0F));
  const RadianceScale scale(2);
  PixelSums sums;
  sums.add({scale.to_fixed(2), scale.to_fixed(1), 0}, 1);
  sums.add({scale.to_fixed(1), scale.to_fixed(0.25), 0}, 2);
  framebuffer.add(1, 0, {&sums, 1}, RunSamples(SampleRange{1, 3}));
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
