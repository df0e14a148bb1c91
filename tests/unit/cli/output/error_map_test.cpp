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

#include "cli/output/labels/canvas.h"
#include "cli/output/text.h"
#include "tests/support/rooms.h"

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

constexpr float background = 0.01F;
constexpr float ink = 0.8F;

/// Whether the text stands there, and nothing else in the box around it.
bool says(const Image& image, const Font& font, const std::string& text, const Point& origin) {
  const Box box{origin.x, origin.y - font.cap_height(), font.width(text), font.cap_height()};
  Coverage letters(box);
  font.draw(letters, origin, text);
  for (int y = letters.top(); y < letters.top() + letters.height(); ++y) {
    for (int x = letters.left(); x < letters.left() + letters.width(); ++x) {
      const float expected = background + letters.at(x, y) * (ink - background);
      const auto colour =
          colour_at(image, static_cast<std::size_t>(x), static_cast<std::size_t>(y));
      if (std::abs(colour[1] - expected) > 1e-4F) return false;
    }
  }
  return letters.area() > 0;
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
    if (i > 0) apart.push_back(distance(lab, lab_of(error_colour(share - 1.0 / steps))));
  }
  const auto [least, most] = std::minmax_element(apart.begin(), apart.end());
  CHECK(*most < 1.1 * *least);
}

TEST_CASE("a scale has round ends, contains nearly all half-widths and spans at least a decade") {
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

TEST_CASE("half-widths are on a logarithmic scale") {
  const ErrorScale scale{0.001, 0.1};
  CHECK(scale.share_of(0) == 0);
  CHECK(scale.share_of(0.0001) == 0);
  CHECK(scale.share_of(0.01) == doctest::Approx(0.5));
  CHECK(scale.share_of(0.1) == doctest::Approx(1));
  CHECK(scale.share_of(7) == 1);
  CHECK(scale.at(scale.share_of(0.02)) == doctest::Approx(0.02));
}

TEST_CASE("a pixel has the half-width of its worst channel, or none with fewer than two samples") {
  constexpr float nothing = std::numeric_limits<float>::infinity();
  const PictureStatistics statistics{
      {2, 1, 9, 0}, {0.1F, 0.3F, 0.2F, 0.1F, 0.1F, 0.1F, 0, 0, 0, nothing, nothing, nothing}};
  CHECK(half_widths_of(statistics, 4) == std::vector<float>{0.3F, -1, 0, -1});
  CHECK(half_widths_of({{5, 5}, std::vector<float>(6, nothing)}, 2) == std::vector<float>{-1, -1});
  CHECK(half_widths_of({{1, 1}, {}}, 2) == std::vector<float>{-1, -1});
}

TEST_CASE("a map shows each pixel's colour in its place, and unknown pixels in a separate colour") {
  const ErrorScale scale{0.001, 0.1};
  const std::vector<float> values = {0.0005F, 0.01F, 0.2F, -1, 0, 5};
  const Image map = error_map(values, 3, scale);
  CHECK(map.rgb.size() == std::size_t{3} * map.width * map.height);
  CHECK(lab_of(colour_at(map, 1, 0))[0] == doctest::Approx(53).epsilon(0.001));
  CHECK(colour_at(map, 0, 0) == colour_at(map, 1, 1));
  CHECK(colour_at(map, 2, 0) == colour_at(map, 2, 1));
  CHECK(colour_at(map, 0, 1) == unknown_colour);
}

TEST_CASE("a legend shows the values of the ends and the middle of its colours") {
  const ErrorScale scale{0.0002, 0.5};
  const Image map = error_map(std::vector<float>(600 * 2, 0.1F), 600, scale);
  REQUIRE(map.width == 600);
  const Font font(error_map_letters(600));
  const double em = font.size();
  const double left = 0.5 * em;
  const double right = 600 - left;
  const double title = 2 + 0.5 * em + font.cap_height();
  CHECK(says(map, font, "95 % half-width", {left, title}));
  const double word = right - font.width("unknown");
  CHECK(says(map, font, "unknown", {word, title}));
  const auto pixel = [&](double x, double y) {
    return colour_at(map, static_cast<std::size_t>(x), static_cast<std::size_t>(y));
  };
  CHECK(pixel(word - 0.4 * em - font.cap_height() / 2, title - font.cap_height() / 2) ==
        unknown_colour);
  const double bar = title + 0.4 * em;
  const auto lightness = [&](double x) { return lab_of(pixel(x, bar + em / 2))[0]; };
  CHECK(lightness(left + 1) == doctest::Approx(16).epsilon(0.02));
  CHECK(lightness(right - 2) == doctest::Approx(90).epsilon(0.01));
  CHECK(lightness(300) == doctest::Approx(53).epsilon(0.01));
  const double values = bar + em + 0.4 * em + font.cap_height();
  CHECK(says(map, font, "0.0002", {left, values}));
  CHECK(says(map, font, "0.01", {left + (right - left - font.width("0.01")) / 2, values}));
  CHECK(says(map, font, "0.5", {right - font.width("0.5"), values}));
  CHECK_FALSE(says(map, font, "0.0005", {left, values}));
}

TEST_CASE("a legend fits pictures of any width and grows with it") {
  std::uint32_t last = 0;
  for (const std::uint32_t width : {1U, 20U, 150U, 479U, 1920U, 7680U}) {
    const Image map = error_map(std::vector<float>(width, 0.1F), width, {1e-12, 1e12});
    CHECK(map.width >= width);
    CHECK(map.height >= last);
    CHECK(map.height < 600);
    last = map.height;
  }
}

}  // namespace parray
