#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include "common/base/error.h"
#include "common/scene/limits.h"

namespace parray::picture {

/// Throws InputError "FILE: reason" if a picture has no pixels, or too many pixels or channels.
/// `channels` is the number of all channels, including R, G and B. Each takes four bytes per pixel.
/// `path` is the file's name for the message.
inline void check_image_limits(const std::string& path, std::uint64_t width, std::uint64_t height,
                               std::size_t channels) {
  constexpr std::size_t most_channels = 256;
  // A small file may claim any size. ParRay's own largest picture has 64 bytes per pixel.
  constexpr std::uint64_t most_bytes = limits::max_pixels * 64;
  const auto refuse = [&](const std::string& reason) { throw InputError(path + ": " + reason); };
  if (width == 0 || height == 0) refuse("the picture has no pixels: name another file");
  if (channels > most_channels) refuse("the file has more than 256 channels: remove some");
  if (std::max(width, height) > limits::max_image_side || width * height > limits::max_pixels) {
    refuse(std::to_string(width) + " x " + std::to_string(height) +
           " pixels are too many: use at most " + std::to_string(limits::max_image_side) +
           " per side and " + std::to_string(limits::max_pixels) + " in total");
  }
  if (width * height * channels * 4 > most_bytes) {
    refuse(std::to_string(channels) + " channels have more than " + std::to_string(most_bytes) +
           " bytes: remove some");
  }
}

}  // namespace parray::picture
