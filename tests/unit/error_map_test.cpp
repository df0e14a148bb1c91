// The map of a picture's error: how half-widths become colours, and the legend that says which.
#include "cli/output/error_map.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cli/output/bitmap_font.h"
#include "cli/output/text.h"

namespace parray {
namespace {

using Lab = std::array<double, 3>;

/// CIE L*a*b* under D65 of linear sRGB.
Lab lab_of(const std::array<float, 3>& rgb) {
  const auto root = [](double t) {
    return t > std::pow(6.0 / 29, 3) ? std::cbrt(t) : t * std::pow(29.0 / 6, 2) / 3 + 4.0 / 29;
  };
  const auto [r, g, b] = rgb;
  const double x = root((0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.95047);
  const double y = root(0.2126 * r + 0.7152 * g + 0.0722 * b);
  const double z = root((0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.08883);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

double distance(const Lab& a, const Lab& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

std::array<float, 3> colour_at(const Image& image, std::size_t x, std::size_t y) {
  const std::size_t at = 3 * (y * image.width + x);
  return {image.rgb.at(at), image.rgb.at(at + 1), image.rgb.at(at + 2)};
}

using Dots = std::set<std::pair<std::size_t, std::size_t>>;

Dots dots_of(const std::string& text) {
  Dots dots;
  each_dot(text, [&](std::size_t x, std::size_t y) { dots.emplace(x, y); });
  return dots;
}

/// Grey, lighter than the background, and no colour of the map.
bool is_ink(const std::array<float, 3>& colour) {
  return colour[0] == colour[1] && colour[1] == colour[2] && colour[0] > 0.5F;
}

/// Whether the text stands there, and nothing else in the box around it.
bool says(const Image& image, const std::string& text, std::size_t left, std::size_t top) {
  Dots found;
  for (std::size_t y = 0; y < glyph_height; ++y) {
    for (std::size_t x = 0; x < text_width(text); ++x) {
      if (is_ink(colour_at(image, left + x, top + y))) found.emplace(x, y);
    }
  }
  return found == dots_of(text);
}

}  // namespace

TEST_CASE("the map's colours rise evenly in lightness, look evenly apart and can be shown") {
  constexpr int steps = 200;
  std::vector<double> apart;
  for (int i = 0; i <= steps; ++i) {
    const double share = static_cast<double>(i) / steps;
    const auto colour = error_colour(share);
    for (const float value : colour) {
      CHECK(value >= 0);
      CHECK(value <= 1);
    }
    const Lab lab = lab_of(colour);
    CHECK(lab[0] == doctest::Approx(16 + 74 * share).epsilon(0.01));  // seen by any eye
    CHECK(distance(lab, lab_of(unknown_colour)) > 30);
    if (i > 0) {
      apart.push_back(distance(lab, lab_of(error_colour(share - 1.0 / steps))));
    }
  }
  const auto [least, most] = std::minmax_element(apart.begin(), apart.end());
  CHECK(*most < 1.1 * *least);
}

TEST_CASE("a scale ends in round numbers, holds nearly all half-widths and is a decade at least") {
  std::vector<float> values(1000, 0.03F);
  values[0] = 1e-9F;  // one in a thousand does not spoil the picture
  values[1] = 0.11F;
  ErrorScale scale = error_scale(values);
  CHECK(scale.low == doctest::Approx(0.02));
  CHECK(scale.high == doctest::Approx(0.2));
  for (const float value : {1e-30F, 0.1F, 0.2F, 0.5F, 1.0F, 3.0F, 9.99F, 1e30F}) {
    scale = error_scale({value, -1, 0, value});
    CHECK(scale.high >= value * (1 - 1e-5));
    CHECK(scale.high <= value * 2.6);
    CHECK(scale.low <= scale.high / 10 * (1 + 1e-9));
    CHECK(scale.low >= scale.high / 51);
    for (const double end : {scale.low, scale.high}) {
      const std::string text = formatted("%.0e", end);
      CHECK(std::string("125").find(text.front()) != std::string::npos);
      CHECK(std::stod(text) == doctest::Approx(end));
    }
  }
  CHECK(error_scale({0.5F}).high == doctest::Approx(0.5));  // round already
  for (const auto& none : {std::vector<float>{}, {-1.0F}, {0.0F, 0.0F}}) {
    CHECK(error_scale(none).low == 1e-3);
    CHECK(error_scale(none).high == 1);
  }
}

TEST_CASE("half-widths stand on the scale by their logarithm") {
  const ErrorScale scale{0.001, 0.1};
  CHECK(scale.share_of(0) == 0);
  CHECK(scale.share_of(0.0001) == 0);
  CHECK(scale.share_of(0.01) == doctest::Approx(0.5));
  CHECK(scale.share_of(0.1) == doctest::Approx(1));
  CHECK(scale.share_of(7) == 1);
  CHECK(scale.at(scale.share_of(0.02)) == doctest::Approx(0.02));
}

TEST_CASE("a pixel has its worst channel's half-width, or none with fewer than two samples") {
  constexpr float nothing = std::numeric_limits<float>::infinity();
  const PictureStatistics statistics{
      {2, 1, 9, 0}, {0.1F, 0.3F, 0.2F, 0.1F, 0.1F, 0.1F, 0, 0, 0, nothing, nothing, nothing}};
  CHECK(half_widths_of(statistics, 4) == std::vector<float>{0.3F, -1, 0, -1});
  CHECK(half_widths_of({{5, 5}, std::vector<float>(6, nothing)}, 2) == std::vector<float>{-1, -1});
  CHECK(half_widths_of({{1, 1}, {}}, 2) == std::vector<float>{-1, -1});
}

TEST_CASE("a map shows each pixel's colour where the pixel is, and unknown ones in their own") {
  const ErrorScale scale{0.001, 0.1};
  const std::vector<float> values = {0.0005F, 0.01F, 0.2F, -1, 0, 5};
  const Image map = error_map(values, 3, scale);
  CHECK(map.rgb.size() == std::size_t{3} * map.width * map.height);
  CHECK(lab_of(colour_at(map, 1, 0))[0] == doctest::Approx(53).epsilon(0.001));
  CHECK(colour_at(map, 0, 0) == colour_at(map, 1, 1));
  CHECK(colour_at(map, 2, 0) == colour_at(map, 2, 1));
  CHECK(colour_at(map, 0, 1) == unknown_colour);
}

TEST_CASE("a legend says what the ends and the middle of its colours stand for") {
  const ErrorScale scale{0.0002, 0.5};
  const Image map = error_map(std::vector<float>(300 * 2, 0.1F), 300, scale);
  REQUIRE(map.width == 300);
  constexpr std::size_t left = 4;
  constexpr std::size_t right = 296;
  const std::size_t title = 2 + 4;
  CHECK(says(map, "95% half-width", left, title));
  CHECK(says(map, "unknown", right - text_width("unknown"), title));
  CHECK(colour_at(map, right - text_width("unknown") - 5, title + 3) == unknown_colour);
  const std::size_t bar = title + glyph_height + 3;
  CHECK(colour_at(map, left, bar) == error_colour(0));
  CHECK(colour_at(map, right - 1, bar) == error_colour(1));
  CHECK(lab_of(colour_at(map, 150, bar + 4))[0] == doctest::Approx(53).epsilon(0.01));
  const std::size_t values = bar + 9 + 3;
  CHECK(says(map, "0.0002", left, values));
  CHECK(says(map, "0.01", left + (right - left - text_width("0.01")) / 2, values));
  CHECK(says(map, "0.5", right - text_width("0.5"), values));
  CHECK_FALSE(says(map, "0.0005", left, values));
}

TEST_CASE("a legend fits whatever the picture's width, and grows with it") {
  std::uint32_t last = 0;
  for (const std::uint32_t width : {1U, 20U, 150U, 479U, 1920U, 7680U}) {
    const Image map = error_map(std::vector<float>(width, 0.1F), width, {1e-12, 1e12});
    CHECK(map.width >= width);
    CHECK(map.height >= last);
    CHECK(map.height < 600);
    last = map.height;
  }
}

TEST_CASE("the font has all that numbers are made of, and no two letters alike") {
  std::set<Dots> seen;
  for (const char letter : std::string("0123456789.-+%adefhiklnotuw")) {
    CHECK(seen.insert(dots_of(std::string(1, letter))).second);
  }
  for (const double value : {1e-300, 5e-5, 0.014, 1.0, 20.0, 1e2, 2e8, 1e300}) {
    CHECK_FALSE(dots_of(formatted("%.2g", value)).empty());
  }
  CHECK_THROWS_AS(dots_of("?"), std::logic_error);
}

}  // namespace parray
