#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "common/image/image.h"

namespace parray::image {

/// The two halves of a picture's samples, with even and with odd numbers. They are independent
/// pictures of the same scene that differ only in noise. Pixels are stored by image row.
struct Replicates {
  /// Linear radiance of the even half and of the odd half, 3 values (R, G, B) per pixel.
  std::array<std::vector<float>, 2> mean;
  /// Expected root mean square error of one half over the channels, in linear radiance, one value
  /// per pixel; 0 for all pixels: unknown. It comes from the samples of the surrounding pixels. The
  /// pixel's own samples enter only through one factor that is the same for the whole picture.
  std::vector<float> noise;

  [[nodiscard]] bool empty() const { return noise.empty(); }
};

/// Data of each pixel besides its radiance.
struct PictureStatistics {
  std::vector<std::uint32_t> samples;  ///< number of the pixel's samples, with excluded ones
  /// Half-widths of the 95 % confidence intervals in linear radiance: 3 values (R, G, B) per pixel;
  /// infinite if the picture's error is unknown.
  std::vector<float> half_width;
  Replicates replicates{};  ///< filled if the job keeps them
};

/// How much of a picture is stored or sent. Each level includes the previous one.
enum class PictureDetail : std::uint8_t { image, statistics, replicates };

/// Returns the stored and transmitted form of a picture: float32 RGB, top row first. Then follow,
/// if present, the numbers of samples and half-widths, 4 and 12 bytes per pixel. Then follow, if
/// present, the replicates: even half, odd half and noise, 12, 12 and 4 bytes per pixel.
/// Little-endian, no padding.
std::string picture_to_bytes(const Image& image, const PictureStatistics& statistics);

/// Returns the same bytes in pieces that refer to the memory of the arguments; copies nothing.
std::vector<std::string_view> picture_pieces(const Image& image,
                                             const PictureStatistics& statistics);

/// Returns the number of bytes of a picture with this detail.
std::uint64_t picture_size(std::uint64_t width, std::uint64_t height, PictureDetail detail);

struct PictureParts {
  Image image;
  PictureStatistics statistics;  ///< empty if the bytes have none
};
/// Reads the output of picture_to_bytes() for a picture of this size. Throws DecodeError if the
/// number of bytes fits no PictureDetail.
PictureParts picture_from_bytes(std::uint32_t width, std::uint32_t height, std::string_view bytes);

}  // namespace parray::image
