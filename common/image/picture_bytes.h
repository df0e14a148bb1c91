#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/image/image.h"
#include "common/image/replicates.h"

namespace parray::image {

/// What is known of each pixel besides its radiance.
struct PictureStatistics {
  std::vector<std::uint32_t> samples;  ///< that its mean is of
  /// Of its 95 % interval: 3 values a pixel; infinite where the picture has no error to state.
  std::vector<float> half_width;
  Replicates replicates{};  ///< if the job was to keep them
};

/// How much of a picture is kept or sent; each has all of the one before.
enum class PictureDetail : std::uint8_t { image, statistics, replicates };

/// A picture as it is kept and sent: float32 RGB, top row first; then, as far as its statistics go,
/// samples and half-widths, 4 and 12 bytes a pixel; then the replicates, even and odd half and
/// noise, 12, 12 and 4 bytes a pixel. Little-endian, no padding.
std::string picture_to_bytes(const Image& image, const PictureStatistics& statistics);

/// The same bytes in pieces, as they lie in memory: nothing is copied.
std::vector<std::string_view> picture_pieces(const Image& image,
                                             const PictureStatistics& statistics);

/// Bytes of such a picture.
std::uint64_t picture_size(std::uint64_t width, std::uint64_t height, PictureDetail detail);

struct PictureParts {
  Image image;
  PictureStatistics statistics;  ///< empty if the bytes have none
};
/// Throws DecodeError when the bytes are no picture of this size.
PictureParts picture_from_bytes(std::uint32_t width, std::uint32_t height, std::string_view bytes);

}  // namespace parray::image
