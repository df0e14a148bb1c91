#include "common/image/picture_bytes.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "common/base/bytes.h"

namespace parray::image {
namespace {

template <typename T>
std::string_view bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

template <typename T>
void take(std::string_view& bytes, std::size_t count, std::vector<T>& values) {
  values.resize(count);
  std::memcpy(values.data(), bytes.data(), count * sizeof(T));
  bytes.remove_prefix(count * sizeof(T));
}

}  // namespace

std::vector<std::string_view> picture_pieces(const Image& image,
                                             const PictureStatistics& statistics) {
  const Replicates& halves = statistics.replicates;
  return {bytes_of(image.rgb),      bytes_of(statistics.samples), bytes_of(statistics.half_width),
          bytes_of(halves.mean[0]), bytes_of(halves.mean[1]),     bytes_of(halves.noise)};
}

std::string picture_to_bytes(const Image& image, const PictureStatistics& statistics) {
  const auto pieces = picture_pieces(image, statistics);
  std::size_t size = 0;
  for (const std::string_view piece : pieces) size += piece.size();
  std::string bytes;
  bytes.reserve(size);
  for (const std::string_view piece : pieces) bytes.append(piece);
  return bytes;
}

std::uint64_t picture_size(std::uint64_t width, std::uint64_t height, PictureDetail detail) {
  constexpr std::array<std::uint64_t, 3> values = {3, 7, 14};
  return width * height * values.at(static_cast<std::size_t>(detail)) * sizeof(float);
}

PictureParts picture_from_bytes(std::uint32_t width, std::uint32_t height, std::string_view bytes) {
  constexpr std::array details{PictureDetail::image, PictureDetail::statistics,
                               PictureDetail::replicates};
  const auto size_of = [&](PictureDetail detail) { return picture_size(width, height, detail); };
  const auto* const detail = std::ranges::find(details, bytes.size(), size_of);
  if (detail == details.end()) throw DecodeError("the bytes of a picture do not fit its size");
  const std::size_t pixels = std::size_t{width} * height;
  PictureParts parts{{width, height, {}}, {}};
  take(bytes, 3 * pixels, parts.image.rgb);
  if (*detail >= PictureDetail::statistics) {
    take(bytes, pixels, parts.statistics.samples);
    take(bytes, 3 * pixels, parts.statistics.half_width);
  }
  if (*detail == PictureDetail::replicates) {
    for (std::vector<float>& mean : parts.statistics.replicates.mean) take(bytes, 3 * pixels, mean);
    take(bytes, pixels, parts.statistics.replicates.noise);
  }
  return parts;
}

}  // namespace parray::image
