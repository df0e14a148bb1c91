// Pictures without their background: alpha, premultiplied colours, files.
#include "cli/output/picture/transparency.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "cli/input/scene_file/scene_file.h"
#include "cli/output/channel_tracing.h"
#include "cli/output/picture/image_file.h"
#include "cli/output/picture/srgb.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "tests/support/dice.h"
#include "tests/support/precisions.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/tracers.h"

namespace parray::test {
namespace {

/// Matt, metal and glass, bubbles and a lens, before an even sky of that colour.
Scene before(const Vec3d& sky) {
  Scene scene = small_scene();
  scene.spheres.erase(scene.spheres.begin());  // the ground
  scene.camera.look_from = {13, 3, 5};
  scene.sky = {sky, sky};
  return scene;
}

RenderSettings settings_of(Precision precision, Sampler sampler) {
  RenderSettings settings;
  settings.width = 33;
  settings.height = 21;
  settings.samples_per_pixel = 12;
  settings.precision = precision;
  settings.sampler = sampler;
  settings.accelerator = AcceleratorKind::bvh;
  return settings;
}

struct Traced {
  Image opaque;
  Image image;  ///< premultiplied
  std::vector<float> alpha;
  std::vector<std::uint32_t> samples;
};

/// A picture whose pixels have so many samples.
Traced traced(const Scene& scene, const RenderSettings& settings,
              std::vector<std::uint32_t> samples) {
  const auto tracer = make_path_tracer(scene, settings);
  Framebuffer framebuffer(settings.width, settings.height);
  std::vector<SampleRange> ranges;
  for (const std::uint32_t count : samples) ranges.push_back({0, count});
  trace_into(framebuffer, *tracer, ranges);
  Traced result;
  result.opaque = result.image = resolve_image(framebuffer, largest_radiance(scene));
  const auto sky = trace_sky_samples(*tracer, settings, samples, 2);
  result.alpha = remove_sky(result.image, sky, samples, RadianceScale(largest_radiance(scene)));
  result.samples = std::move(samples);
  return result;
}

/// How many of a pixel's camera rays meet something, asked one by one of the scalar definition.
std::uint32_t met(const PathTracer& scalar, std::uint32_t x, std::uint32_t y,
                  std::uint32_t samples) {
  std::uint32_t count = 0;
  for (std::uint32_t s = 0; s < samples; ++s) {
    FirstHit hit;
    scalar.first_hits({y, x, x + 1}, {s, s + 1}, {&hit, 1});
    count += hit.shape == no_shape ? 0 : 1;
  }
  return count;
}

std::vector<std::uint32_t> even(const RenderSettings& settings) {
  return std::vector(std::size_t{settings.width} * settings.height, settings.samples_per_pixel);
}

std::vector<std::uint32_t> uneven(const RenderSettings& settings) {
  Dice dice(8);
  std::vector<std::uint32_t> samples = even(settings);
  for (std::uint32_t& count : samples) count = 1 + dice.below32(40);
  return samples;
}

/// Alpha is the count, and what is left with the sky behind it is the picture.
void check(const Scene& scene, const RenderSettings& settings, const Traced& picture) {
  const auto scalar = make_scalar_tracer(scene, settings);
  const Vec3d& sky = scene.sky.zenith;
  const std::array<double, 3> behind{sky.x, sky.y, sky.z};
  std::size_t clear = 0;
  std::size_t partly = 0;
  for (std::size_t pixel = 0; pixel < picture.alpha.size(); ++pixel) {
    const auto x = static_cast<std::uint32_t>(pixel % settings.width);
    const auto y = static_cast<std::uint32_t>(pixel / settings.width);
    const std::uint32_t count = met(*scalar, x, y, picture.samples[pixel]);
    const float alpha = picture.alpha[pixel];
    CHECK(alpha == static_cast<float>(static_cast<double>(count) / picture.samples[pixel]));
    clear += count == 0 ? 1 : 0;
    partly += count > 0 && count < picture.samples[pixel] ? 1 : 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const float value = picture.image.rgb[3 * pixel + c];
      CHECK(value >= 0);
      if (count == 0) CHECK(value == 0);
      if (count == picture.samples[pixel]) CHECK(value == picture.opaque.rgb[3 * pixel + c]);
      CHECK(std::abs(value + (1.0 - alpha) * behind[c] - picture.opaque.rgb[3 * pixel + c]) < 1e-6);
    }
  }
  CHECK(clear > 30);
  CHECK(partly > 30);
}

}  // namespace

TEST_CASE(
    "alpha is the share of camera rays that hit a sphere, and the sky completes the picture") {
  for (const Precision precision : precisions) {
    for (const Sampler sampler : {Sampler::independent, Sampler::sobol}) {
      CAPTURE(name_of(precision));
      CAPTURE(name_of(sampler));
      const RenderSettings settings = settings_of(precision, sampler);
      const Scene scene = before({0.25, 0.5, 0.9});
      check(scene, settings, traced(scene, settings, even(settings)));
      check(scene, settings, traced(scene, settings, uneven(settings)));
      Scene lens = scene;
      lens.camera.aperture = 2;
      check(lens, settings, traced(lens, settings, uneven(settings)));
    }
  }
}

TEST_CASE("a black sky and a sky gradient are removed completely") {
  const RenderSettings settings = settings_of(Precision::f32, Sampler::sobol);
  const Scene black = before({0, 0, 0});
  check(black, settings, traced(black, settings, even(settings)));
  Scene gradient = before({1, 1, 1});
  gradient.sky = {{0.1, 0.2, 0.3}, {3, 2, 1}};
  const Traced picture = traced(gradient, settings, even(settings));
  for (std::size_t pixel = 0; pixel < picture.alpha.size(); ++pixel) {
    const float* const rgb = &picture.image.rgb[3 * pixel];
    const bool none = rgb[0] == 0 && rgb[1] == 0 && rgb[2] == 0;
    if (picture.alpha[pixel] == 0) CHECK(none);
  }
}

TEST_CASE("the background is the same for any number of threads") {
  const Scene scene = before({1, 1, 1});
  const RenderSettings settings = settings_of(Precision::f32, Sampler::sobol);
  const auto tracer = make_path_tracer(scene, settings);
  const auto one = trace_sky_samples(*tracer, settings, even(settings), 1);
  CHECK_UNARY(one == trace_sky_samples(*tracer, settings, even(settings), 3));
  CHECK(std::ranges::any_of(one, [](const SkySamples& sky) { return sky.count > 0; }));
}

TEST_CASE("a pixel without a sample uses the background of the pixel that it shows") {
  const Scene scene = before({0.5, 0.5, 0.5});
  const RenderSettings settings = settings_of(Precision::f32, Sampler::sobol);
  std::vector<std::uint32_t> samples = even(settings);
  for (std::size_t pixel = 0; pixel < samples.size(); ++pixel) {
    const std::size_t x = pixel % settings.width;
    const std::size_t y = pixel / settings.width;
    if (x % 2 != 0 || y % 2 != 0) samples[pixel] = 0;
  }
  const Traced picture = traced(scene, settings, samples);
  for (std::size_t pixel = 0; pixel < samples.size(); ++pixel) {
    const std::size_t x = pixel % settings.width;
    const std::size_t y = pixel / settings.width;
    const std::size_t corner = (y - y % 2) * settings.width + x - x % 2;
    CHECK(picture.alpha[pixel] == picture.alpha[corner]);
  }
}

TEST_CASE("rounding leaves no negative colour and no sky in pixels that show only sky") {
  const RadianceScale scale(1);
  const SkySamples sky{3,
                       {scale.to_fixed(0.3) * 3, scale.to_fixed(0.6) * 3, scale.to_fixed(1) * 3}};
  const std::array<float, 3> mean{0.225F, 0.45F, 0.75F};
  const TransparentPixel part = without_sky(mean, sky, 4, scale);
  CHECK(part.alpha == 0.25F);
  for (const float value : part.colour) {
    CHECK(value >= 0);
    CHECK(value < 1e-7);
  }
  const TransparentPixel none = without_sky({0.3F, 0.6F, 1}, sky, 3, scale);
  CHECK(none.alpha == 0);
  CHECK(none.colour == std::array<float, 3>{0, 0, 0});
}

TEST_CASE("a PNG file has unassociated colours, and reads back as the same codes") {
  const TemporaryDirectory directory;
  Dice dice(2);
  Image image{31, 17, {}};
  std::vector<float> alpha;
  for (std::size_t i = 0; i < std::size_t{31} * 17; ++i) {
    const double share = i % 5 == 0 ? (i % 2 == 0 ? 0 : 1) : dice.unit();
    alpha.push_back(static_cast<float>(share));
    for (int c = 0; c < 3; ++c) {
      image.rgb.push_back(static_cast<float>(share * dice.between(0, 1.2)));
    }
  }
  alpha[3] = 1e-4F;  // its code is 0
  const auto bytes = transparent_bytes(image.rgb, alpha);
  CHECK(std::vector(bytes.begin() + 12, bytes.begin() + 16) == std::vector<std::uint8_t>(4, 0));
  const auto file = directory.path() / "a.png";
  write_image(file, image, {}, {{alpha_channel, alpha}});
  const ImageFile read = read_image(file);
  const auto again = alpha_of(read.channels);
  REQUIRE(again.size() == alpha.size());
  CHECK_UNARY(transparent_bytes(read.image.rgb, again) == bytes);
  for (std::size_t i = 0; i < alpha.size(); ++i) {
    CHECK(std::abs(again[i] - alpha[i]) <= 0.5F / 255 + 1e-6F);
    CHECK(bytes[4 * i + 3] == std::lround(255 * alpha[i]));
    const auto code = srgb_byte(alpha[i] > 0 ? image.rgb[3 * i] / alpha[i] : 0);
    CHECK(bytes[4 * i] == (bytes[4 * i + 3] == 0 ? 0 : code));
  }
}

TEST_CASE("an EXR file has premultiplied colours and channel A, to the bit") {
  const TemporaryDirectory directory;
  const Image image{2, 1, {0.25F, 0.5F, 0.125F, 0, 0, 0}};
  const std::vector<float> alpha{0.75F, 0};
  const auto file = directory.path() / "a.exr";
  write_image(file, image, {}, {{alpha_channel, alpha}});
  const ImageFile read = read_image(file);
  CHECK(read.image.rgb == image.rgb);
  CHECK_UNARY(std::ranges::equal(alpha_of(read.channels), alpha));
  CHECK(transparent_sha256(read.image, alpha_of(read.channels)) ==
        transparent_sha256(image, alpha));
  CHECK(transparent_sha256(image, std::vector<float>{0.75F, 1}) !=
        transparent_sha256(image, alpha));
}

TEST_CASE("a PNG file with full alpha reads as one with its background") {
  const TemporaryDirectory directory;
  const Image image{2, 1, {0.25F, 0.5F, 0.125F, 1, 0, 0}};
  const auto file = directory.path() / "a.png";
  write_image(file, image, {}, {{alpha_channel, std::vector<float>{1, 1}}});
  const ImageFile read = read_image(file);
  CHECK(read.channels.empty());
  CHECK_UNARY(srgb_bytes(read.image.rgb) == srgb_bytes(image.rgb));
}

}  // namespace parray::test
