#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/image/image.h"

namespace parray {

/// What is known of each pixel besides its radiance.
struct PictureStatistics {
  std::vector<std::uint32_t> samples;  ///< that its mean is of
  /// Of its 95 % interval: 3 values a pixel; empty where the picture has no error to state, which
  /// picture_to_bytes() makes infinite ones.
  std::vector<float> half_width;
};

/// A picture as it is kept and sent: float32 RGB, top row first, then, if they are wanted, the
/// statistics: 4 bytes a pixel and 12 bytes a pixel. Little-endian, no padding.
std::string picture_to_bytes(const Image& image, const PictureStatistics& statistics);

/// The same bytes in pieces, as they lie in memory: nothing is copied.
std::vector<std::string_view> picture_pieces(const Image& image,
                                             const PictureStatistics& statistics);

/// Bytes of such a picture.
std::uint64_t picture_size(std::uint64_t width, std::uint64_t height, bool statistics);

struct PictureParts {
  Image image;
  PictureStatistics statistics;  ///< empty if the bytes have none
};
/// Throws DecodeError when the bytes are no picture of this size.
PictureParts picture_from_bytes(std::uint32_t width, std::uint32_t height, std::string_view bytes);

}  // namespace parray
