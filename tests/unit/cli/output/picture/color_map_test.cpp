#include "cli/output/picture/color_map.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "cli/input/color/particle_colors.h"
#include "cli/output/picture/srgb.h"
#include "tests/support/rooms.h"

/// Colour maps rise evenly; colours of categories are told apart by people with any colour vision.
namespace parray {
namespace {

using Matrix = std::array<Vec3d, 3>;

Vec3d times(const Matrix& m, const Vec3d& v) { return {dot(m[0], v), dot(m[1], v), dot(m[2], v)}; }

/// Ottosson, "A perceptual color space for image processing", 2020.
Vec3d oklab(const Vec3d& linear) {
  constexpr Matrix to_cones{{{0.4122214708, 0.5363325363, 0.0514459929},
                             {0.2119034982, 0.6806995451, 0.1073969566},
                             {0.0883024619, 0.2817188376, 0.6299787005}}};
  constexpr Matrix to_lab{{{0.2104542553, 0.7936177850, -0.0040720468},
                           {1.9779984951, -2.4285922050, 0.4505937099},
                           {0.0259040371, 0.7827717662, -0.8086757660}}};
  const Vec3d cones = times(to_cones, linear);
  return times(to_lab, {std::cbrt(cones.x), std::cbrt(cones.y), std::cbrt(cones.z)});
}

double distance(const Vec3d& a, const Vec3d& b) { return length(oklab(a) - oklab(b)); }

/// Machado, Oliveira and Fernandes, 2009, severity 1: of linear RGB.
const std::array<Matrix, 4>& observers() {
  static constexpr std::array<Matrix, 4> all{{
      {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
      {{{0.152286, 1.052583, -0.204868},
        {0.114503, 0.786281, 0.099216},
        {-0.003882, -0.048116, 1.051998}}},  // protanope
      {{{0.367322, 0.860646, -0.227968},
        {0.280085, 0.672501, 0.047413},
        {-0.011820, 0.042940, 0.968881}}},  // deuteranope
      {{{1.255528, -0.076749, -0.178779},
        {-0.078411, 0.930809, 0.147602},
        {0.004733, 0.691367, 0.303900}}},  // tritanope
  }};
  return all;
}

Vec3d seen_by(const Matrix& observer, const Vec3d& color) {
  const Vec3d seen = times(observer, color);
  return {std::clamp(seen.x, 0.0, 1.0), std::clamp(seen.y, 0.0, 1.0), std::clamp(seen.z, 0.0, 1.0)};
}

double least_distance(const Vec3d& a, const Vec3d& b) {
  double least = 10;
  for (const Matrix& observer : observers()) {
    least = std::min(least, distance(seen_by(observer, a), seen_by(observer, b)));
  }
  return least;
}

std::vector<Vec3d> steps_of(ColorMap map, std::size_t count) {
  std::vector<Vec3d> colors;
  for (std::size_t i = 0; i <= count; ++i) {
    colors.push_back(color_at(map, static_cast<double>(i) / static_cast<double>(count)));
  }
  return colors;
}

std::string hex(const Vec3d& color) {
  std::string text;
  for (const double component : {color.x, color.y, color.z}) {
    const std::uint8_t byte = srgb_byte(static_cast<float>(component));
    text += "0123456789abcdef"[byte / 16];
    text += "0123456789abcdef"[byte % 16];
  }
  return text;
}

}  // namespace

TEST_CASE("every colour map is found by name, stays in gamut and has even steps") {
  CHECK(color_map_words.size() == 8);
  CHECK_FALSE(color_map_named("jet"));
  for (const std::string_view name : color_map_words) {
    CAPTURE(name);
    const auto map = color_map_named(name);
    REQUIRE(map);
    CHECK(name_of(*map) == name);
    double least = 10;
    double most = 0;
    const std::vector<Vec3d> colors = steps_of(*map, 32);
    for (std::size_t i = 0; i < colors.size(); ++i) {
      for (const double component : {colors[i].x, colors[i].y, colors[i].z}) {
        CHECK(component >= -1e-3);
        CHECK(component <= 1 + 1e-3);
      }
      if (i == 0) continue;
      least = std::min(least, distance(colors[i - 1], colors[i]));
      most = std::max(most, distance(colors[i - 1], colors[i]));
    }
    CHECK(most / least < 2.6);
    CHECK(distance(color_of_unknown(*map), colors[0]) > 0.1);
  }
}

TEST_CASE("lightness rises along a map, and falls again after the middle of a diverging map") {
  for (const std::string_view name : color_map_words) {
    CAPTURE(name);
    const ColorMap map = *color_map_named(name);
    const std::vector<Vec3d> colors = steps_of(map, 200);
    for (std::size_t i = 1; i < colors.size(); ++i) {
      CAPTURE(i);
      const bool falls = is_diverging(map) && i > 100;
      CHECK((oklab(colors[i]).x > oklab(colors[i - 1]).x) == !falls);
    }
  }
  const std::vector<Vec3d> ends = steps_of(ColorMap::blue_red, 2);
  CHECK(std::abs(oklab(ends[0]).x - oklab(ends[2]).x) < 0.01);  // neither end is the stronger
  CHECK(length(oklab(ends[1]) - Vec3d{0.96, 0, 0}) < 0.001);
}

TEST_CASE("published colour maps have their published colours") {
  CHECK(hex(color_at(ColorMap::viridis, 0)) == "440154");
  CHECK(hex(color_at(ColorMap::viridis, 1)) == "fde725");
  CHECK(hex(color_at(ColorMap::magma, 1)) == "fcfdbf");
  CHECK(hex(color_at(ColorMap::inferno, 0)) == "000004");
  CHECK(hex(color_at(ColorMap::plasma, 0)) == "0d0887");
  CHECK(hex(color_at(ColorMap::cividis, 1)) == "fee838");
  CHECK(hex(color_at(ColorMap::viridis, 51.0 / 255)) == "414487");  // an entry in the middle
}

TEST_CASE("the first twelve colours of categories differ for every colour vision") {
  for (std::size_t i = 0; i < 12; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      CAPTURE(i);
      CAPTURE(j);
      CHECK(least_distance(category_color(i), category_color(j)) > 0.075);
    }
  }
}

TEST_CASE("all colours of categories differ, and then repeat") {
  for (std::size_t i = 0; i < category_color_count; ++i) {
    CHECK(category_color(i) == category_color(i + category_color_count));
    for (std::size_t j = 0; j < i; ++j) {
      CHECK(least_distance(category_color(i), category_color(j)) > 0.06);
    }
  }
}

}  // namespace parray
