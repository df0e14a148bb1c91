#include "cli/check/verify/verified_picture.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <span>
#include <utility>

#include "cli/output/extra_channels.h"
#include "cli/output/picture/srgb.h"
#include "cli/output/picture/transparency.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/sha256.h"
#include "common/scene/limits.h"
#include "common/scene/settings_fwd.h"

namespace parray::verify {
namespace {

/// Replaces a denoised picture by the picture before denoising, which follows from its samples.
/// Throws InputError if the file does not contain it.
void take_raw(VerifiedPicture& picture) {
  if (!picture.file.high_dynamic_range) {
    throw InputError(picture.name +
                     ": a denoised picture of 8 bits does not contain the picture before "
                     "denoising: verify the EXR picture");
  }
  if (!picture.transparent() &&
      image_sha256(picture.file.image) != picture.recipe.denoised_sha256) {
    picture.damage = "denoised:image_sha256 does not match the pixels";
  }
  auto raw = raw_image(picture.file);
  if (!raw) {
    throw InputError(picture.name +
                     ": the picture is denoised, but its channels raw.R, raw.G, raw.B are missing: "
                     "verify the original file");
  }
  picture.file.image = *std::move(raw);
  picture.alpha.clear();  // the picture before denoising has its background
}

/// Takes the alpha of a transparent picture, and compares the hash of an EXR picture. Throws
/// InputError if channel A is missing.
void take_alpha(VerifiedPicture& picture) {
  const std::span<const float> alpha = alpha_of(picture.file.channels);
  picture.alpha.assign(alpha.begin(), alpha.end());
  if (!picture.file.high_dynamic_range) {
    // The reader leaves out the alpha of a PNG file if it is 1 everywhere.
    if (alpha.empty()) picture.alpha.assign(picture.pixels(), 1);
    return;
  }
  if (alpha.empty()) {
    throw InputError(picture.name +
                     ": the picture is transparent, but its channel A is missing: verify the "
                     "original file");
  }
  if (transparent_sha256(picture.file.image, alpha) != picture.recipe.transparent_sha256) {
    picture.damage = picture.hash() + " does not match the pixels";
  }
}

/// Returns channel `samples`. Null: the file has none.
const std::vector<std::uint32_t>* samples_in(const VerifiedPicture& picture) {
  const Channel* const channel = channel_of(picture, samples_channel);
  return channel == nullptr ? nullptr : std::get_if<std::vector<std::uint32_t>>(&channel->values);
}

bool same_transparent(const VerifiedPicture& picture, const RetracedPixel& pixel) {
  const std::array<float, 3> stored = picture.stored(pixel);
  const float alpha = picture.alpha[std::size_t{pixel.y} * picture.file.image.width + pixel.x];
  if (picture.file.high_dynamic_range) return stored == pixel.mean && alpha == pixel.alpha;
  return transparent_bytes(stored, {&alpha, 1}) == transparent_bytes(pixel.mean, {&pixel.alpha, 1});
}

}  // namespace

const Channel* channel_of(const VerifiedPicture& picture, std::string_view name) {
  const auto found = std::ranges::find(picture.file.channels, name, &Channel::name);
  return found == picture.file.channels.end() ? nullptr : &*found;
}

VerifiedPicture read_verified_picture(const std::string& file, bool traced) {
  VerifiedPicture picture{printable(file, 4096), read_image(file), {}};
  picture.recipe = recipe_in(picture.file.metadata, picture.name);
  if (!picture.file.high_dynamic_range && picture.recipe.pixels_sha256.empty()) {
    throw InputError(picture.name +
                     ": the recipe in the file has no pixels_sha256, so another program wrote the "
                     "file: verify the original file");
  }
  if (!picture.recipe.finished.empty() && traced) {
    throw InputError(picture.name + ": " + printable(picture.recipe.finished) +
                     " was drawn on it after tracing: verify the EXR picture, or leave the scene "
                     "out");
  }
  // Postprocessing may have put a transparent picture on a background.
  const bool on_background = picture.recipe.finished.starts_with(background_step);
  if (!picture.recipe.transparent_sha256.empty() && !on_background) take_alpha(picture);
  if (!picture.recipe.denoised_sha256.empty()) take_raw(picture);
  return picture;
}

std::string misfit_of(const VerifiedPicture& picture) {
  const RenderSettings& settings = picture.recipe.settings;
  const Image& image = picture.file.image;
  if (image.width != width_of(settings) || image.height != height_of(settings)) {
    return "the file has " + std::to_string(image.width) + " x " + std::to_string(image.height) +
           " pixels, but its recipe states " + std::to_string(width_of(settings)) + " x " +
           std::to_string(height_of(settings));
  }
  std::uint64_t samples = picture.pixels() * samples_per_pixel_of(settings);
  if (!picture.recipe.equal_samples) {
    const auto* const counts = samples_in(picture);
    if (counts == nullptr) return "";
    samples = std::accumulate(counts->begin(), counts->end(), std::uint64_t{0});
  }
  if (samples == picture.recipe.samples) return "";
  return "the pixels have " + std::to_string(samples) + " samples, but the recipe states " +
         std::to_string(picture.recipe.samples);
}

std::string damage_of(const VerifiedPicture& picture) {
  if (!picture.damage.empty()) return picture.damage;
  const Image& image = picture.file.image;
  if (picture.file.high_dynamic_range) {
    if (picture.transparent()) return "";  // take_alpha() has compared the hash
    if (image_sha256(image) == picture.recipe.image_sha256) return "";
  } else {
    const auto bytes =
        picture.transparent() ? transparent_bytes(image.rgb, picture.alpha) : srgb_bytes(image.rgb);
    if (sha256_hex(std::as_bytes(std::span(bytes))) == picture.recipe.pixels_sha256) return "";
  }
  return picture.hash() + " does not match the pixels";
}

std::vector<std::uint32_t> sample_counts(const VerifiedPicture& picture) {
  if (picture.recipe.equal_samples) return {};
  const auto* const counts = samples_in(picture);
  if (counts == nullptr) {
    throw InputError(picture.name + ": its pixels have different numbers of samples, and " +
                     (picture.file.high_dynamic_range
                          ? "channel samples with the numbers is missing"
                          : "a file of 8 bits does not contain the numbers") +
                     ": use parray render --like " + picture.name + " to render all of it again");
  }
  const std::uint32_t most = *std::ranges::max_element(*counts);
  if (most > limits::max_samples_per_pixel) {
    throw InputError(picture.name + ": channel samples has " + std::to_string(most) +
                     "; a pixel has at most " + std::to_string(limits::max_samples_per_pixel));
  }
  return *counts;
}

bool same_colour(const VerifiedPicture& picture, const RetracedPixel& pixel) {
  if (picture.transparent()) return same_transparent(picture, pixel);
  const std::array<float, 3> stored = picture.stored(pixel);
  for (std::size_t c = 0; c < 3; ++c) {
    const bool equal =
        picture.file.high_dynamic_range
            ? std::bit_cast<std::uint32_t>(stored[c]) == std::bit_cast<std::uint32_t>(pixel.mean[c])
            : srgb_byte(stored[c]) == srgb_byte(pixel.mean[c]);
    if (!equal) return false;
  }
  return true;
}

}  // namespace parray::verify
