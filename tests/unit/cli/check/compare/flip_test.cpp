#include "cli/check/compare/flip.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "tests/support/rooms.h"

namespace parray {
namespace {

/// Width x height pixels of value(x, y, channel).
template <typename Value>
Image drawn(std::uint32_t width, std::uint32_t height, const Value& value) {
  Image image{width, height, {}};
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      for (std::uint32_t c = 0; c < 3; ++c) image.rgb.push_back(static_cast<float>(value(x, y, c)));
    }
  }
  return image;
}

/// One of 0, 1, ..., 255, without order.
std::uint32_t scrambled(std::uint32_t x, std::uint32_t y, std::uint32_t c) {
  std::uint32_t h = x * 73856093U ^ y * 19349663U ^ (c + 1) * 83492791U;
  h ^= h >> 13;
  h *= 0x5bd1e995U;
  return (h ^ h >> 15) & 255U;
}

Image coloured_checks(std::uint32_t shift) {
  return drawn(96, 64, [shift](std::uint32_t x, std::uint32_t y, std::uint32_t c) {
    return ((x + shift) / 11 + y / 9) % 2 == 0 ? 0.875 - 0.25 * c : 0.125 + 0.1875 * c;
  });
}

Image ramp() {
  return drawn(96, 64, [](std::uint32_t x, std::uint32_t y, std::uint32_t c) {
    return (c == 0 ? x / 95.0 : c == 1 ? y / 63.0 : (x + y) / 158.0);
  });
}

/// Over 12 stops from left to right.
Image bright_ramp() {
  return drawn(96, 64, [](std::uint32_t x, std::uint32_t y, std::uint32_t c) {
    return std::ldexp(1 + (y + 7 * c) % 16 / 16.0, static_cast<int>(x / 8) - 4);
  });
}

/// `image` times 0.75 to 1.25.
Image noisy(Image image) {
  for (std::size_t i = 0; i < image.rgb.size(); ++i) {
    const auto pixel = static_cast<std::uint32_t>(i / 3);
    image.rgb[i] *= 0.75F + static_cast<float>(scrambled(pixel % image.width, pixel / image.width,
                                                         static_cast<std::uint32_t>(i % 3))) /
                                510.0F;
  }
  return image;
}

Image noise(std::uint32_t seed) {
  return drawn(40, 30, [seed](std::uint32_t x, std::uint32_t y, std::uint32_t c) {
    return scrambled(x + seed, y, c) / 255.0;
  });
}

Image plain(float r, float g, float b) {
  return drawn(24, 24, [&](std::uint32_t, std::uint32_t, std::uint32_t c) {
    return c == 0 ? r : c == 1 ? g : b;
  });
}

float largest(const FlipMap& map) { return *std::max_element(map.begin(), map.end()); }

}  // namespace

TEST_CASE("FLIP agrees with its authors' program on edges, noise and colours") {
  // Means and single pixels that FLIP 1.7 (in double precision) gives for these pictures.
  const auto check = [](const Image& reference, const Image& image, double mean, double pixel) {
    const FlipMap map = flip(reference, image);
    CHECK(mean_of(map) == doctest::Approx(mean).epsilon(2e-5));
    CHECK(map[20 * reference.width + 30] == doctest::Approx(pixel).epsilon(1e-4));
  };
  check(coloured_checks(0), coloured_checks(2), 0.2611376, 0.4571947);
  check(ramp(), noisy(ramp()), 0.1244408, 0.0518122);
  check(noise(0), noise(50), 0.4351718, 0.3767643);
  check(bright_ramp(), noisy(bright_ramp()), 0.0393074, 0.0672597);
}

TEST_CASE("HDR-FLIP agrees with its authors' program, exposures included") {
  const auto check = [](const Image& reference, const Image& image, double mean, double start,
                        double stop, int exposures) {
    const HdrFlip result = hdr_flip(reference, image);
    CHECK(mean_of(result.map) == doctest::Approx(mean).epsilon(2e-5));
    CHECK(result.start_exposure == doctest::Approx(start).epsilon(1e-5));
    CHECK(result.stop_exposure == doctest::Approx(stop).epsilon(1e-5));
    CHECK(result.exposures == exposures);
  };
  check(coloured_checks(0), coloured_checks(2), 0.1739714, 1.682540, 1.682540, 2);
  check(ramp(), noisy(ramp()), 0.0761724, 1.083297, 2.083173, 2);
  check(bright_ramp(), noisy(bright_ramp()), 0.0852792, -6.767803, -1.119811, 6);
}

TEST_CASE("equal pictures have FLIP 0 at any exposure") {
  for (const Image& image : {coloured_checks(0), noise(3), bright_ramp(), plain(0, 0, 0)}) {
    CHECK(largest(flip(image, image)) == 0);
    CHECK(largest(hdr_flip(image, image).map) == 0);
  }
}

TEST_CASE("FLIP is in [0, 1]; green and blue differ by almost 1") {
  CHECK(mean_of(flip(plain(0, 1, 0), plain(0, 0, 1))) == doctest::Approx(1).epsilon(1e-6));
  const Image sharp = drawn(40, 30, [](std::uint32_t x, std::uint32_t y, std::uint32_t c) {
    return c == 1 + (x ^ y) % 2;
  });
  for (const Image& image : {plain(0, 0, 0), plain(1, 1, 1), plain(100, 0, 5)}) {
    for (const FlipMap& map : {flip(plain(0, 1, 0), image), hdr_flip(plain(0, 1, 0), image).map}) {
      CHECK(*std::min_element(map.begin(), map.end()) >= 0);
      CHECK(largest(map) <= 1);
    }
  }
  const FlipMap map = flip(sharp, noise(1));
  CHECK(*std::min_element(map.begin(), map.end()) >= 0);
  CHECK(largest(map) <= 1);
}

TEST_CASE("FLIP is symmetric; HDR-FLIP takes its exposures from the reference") {
  CHECK(flip(noise(0), noise(9)) == flip(noise(9), noise(0)));
  CHECK(flip(coloured_checks(0), noisy(ramp())) == flip(noisy(ramp()), coloured_checks(0)));
  CHECK(hdr_flip(ramp(), bright_ramp()).exposures != hdr_flip(bright_ramp(), ramp()).exposures);
}

TEST_CASE("FLIP clamps values, HDR-FLIP detects differences above white") {
  CHECK(largest(flip(plain(1, 1, 1), plain(7, 7, 7))) == 0);
  CHECK(mean_of(hdr_flip(plain(1, 1, 1), plain(7, 7, 7)).map) > 0.05);
  CHECK(largest(flip(plain(-1, 0, 0), plain(0, 0, -3))) == 0);
}

TEST_CASE("FLIP of a difference reaches ten pixels, the size of the filters") {
  const Image reference =
      drawn(60, 60, [](std::uint32_t, std::uint32_t, std::uint32_t) { return 0.25; });
  Image image = reference;
  constexpr std::size_t middle = 30 * 60 + 30;
  image.rgb[middle * 3] = 1;
  const FlipMap map = flip(reference, image);
  CHECK(map[middle] > 0.1F);
  CHECK(map[middle + 4] > 0);  // rows have 60 pixels
  CHECK(map[middle + 4] == doctest::Approx(map[middle + 240]).epsilon(1e-4));
  CHECK(map[middle + 11] < 1e-4F);
  CHECK(map[middle - 660] < 1e-4F);
}

TEST_CASE(
    "a pixel that is not finite is left out of FLIP's mean and counts as black for its "
    "neighbours") {
  Image reference = plain(0.5F, 0.5F, 0.5F);
  Image image = reference;
  constexpr std::size_t middle = 12 * 24 + 12;
  image.rgb[middle * 3 + 1] = std::numeric_limits<float>::quiet_NaN();
  reference.rgb[0] = std::numeric_limits<float>::infinity();
  for (const FlipMap& map : {flip(reference, image), hdr_flip(reference, image).map}) {
    CHECK(std::isnan(map[middle]));
    CHECK(std::isnan(map[0]));
    CHECK(map[middle + 1] == 0);  // both pictures are black in the middle
    CHECK(mean_of(map) == 0);
  }
  const Image none = plain(std::numeric_limits<float>::quiet_NaN(), 0, 0);
  CHECK(std::isnan(mean_of(flip(none, none))));
  CHECK(std::isnan(mean_of(hdr_flip(none, none).map)));
}

TEST_CASE("HDR-FLIP has finite exposures for black, for the largest floats and for one pixel") {
  constexpr float most = std::numeric_limits<float>::max();
  const Image spot =
      drawn(9, 1, [](std::uint32_t x, std::uint32_t, std::uint32_t) { return x == 0 ? most : 0; });
  const Image dark = drawn(9, 1, [](std::uint32_t, std::uint32_t, std::uint32_t) { return 0; });
  for (const auto& [reference, image] :
       {std::pair{dark, spot}, {spot, dark}, {Image{1, 1, {1, 2, 3}}, Image{1, 1, {3, 2, 1}}}}) {
    const HdrFlip result = hdr_flip(reference, image);
    CHECK(std::isfinite(result.start_exposure));
    CHECK(result.stop_exposure >= result.start_exposure);
    CHECK(result.exposures >= 2);
    CHECK(result.exposures <= 152);
    CHECK(mean_of(result.map) > 0);
    CHECK(largest(result.map) <= 1);
  }
}

}  // namespace parray
