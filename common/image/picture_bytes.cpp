#include "common/image/picture_bytes.h"

#include <cstring>
#include <limits>

#include "common/base/bytes.h"

namespace parray {
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
  return {bytes_of(image.rgb), bytes_of(statistics.samples), bytes_of(statistics.half_width)};
}

std::string picture_to_bytes(const Image& image, const PictureStatistics& statistics) {
  std::string bytes;
  const std::uint64_t size = picture_size(image.width, image.height, !statistics.samples.empty());
  bytes.reserve(size);
  for (const std::string_view piece : picture_pieces(image, statistics)) {
    bytes.append(piece);
  }
  while (bytes.size() < size) {  // a picture without an error to state
    constexpr float unknown = std::numeric_limits<float>::infinity();
    bytes.append(reinterpret_cast<const char*>(&unknown), sizeof unknown);
  }
  return bytes;
}

std::uint64_t picture_size(std::uint64_t width, std::uint64_t height, bool statistics) {
  return width * height * (statistics ? 7 : 3) * sizeof(float);
}

PictureParts picture_from_bytes(std::uint32_t width, std::uint32_t height, std::string_view bytes) {
  const bool statistics = bytes.size() == picture_size(width, height, true);
  if (!statistics && bytes.size() != picture_size(width, height, false)) {
    throw DecodeError("picture does not fit its size");
  }
  const std::size_t pixels = std::size_t{width} * height;
  PictureParts parts{{width, height, {}}, {}};
  take(bytes, 3 * pixels, parts.image.rgb);
  if (statistics) {
    take(bytes, pixels, parts.statistics.samples);
    take(bytes, 3 * pixels, parts.statistics.half_width);
  }
  return parts;
}

}  // namespace parray
