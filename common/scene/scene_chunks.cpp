#include "common/scene/scene_chunks.h"

#include <zstd.h>

#include "common/base/bytes.h"
#include "common/scene/scene_bytes.h"

namespace parray::scene {
namespace {

/// Bytes of a sphere in scene_bytes.cpp. Bytes this far apart are similar, at whatever place in a
/// record a chunk begins.
constexpr std::size_t stride = scene_bytes_of_sphere;

/// Reorders bytes: 0, stride, 2 stride .. first, then 1, stride + 1 ..; an incomplete record stays
/// at the end.
std::string apart(std::string_view chunk) {
  std::string columns(chunk);
  const std::size_t records = chunk.size() / stride;
  for (std::size_t column = 0; column < stride; ++column) {
    for (std::size_t record = 0; record < records; ++record) {
      columns[column * records + record] = chunk[record * stride + column];
    }
  }
  return columns;
}

/// Reverses apart().
void together(std::string_view columns, std::span<char> chunk) {
  const std::size_t records = chunk.size() / stride;
  for (std::size_t column = 0; column < stride; ++column) {
    for (std::size_t record = 0; record < records; ++record) {
      chunk[record * stride + column] = columns[column * records + record];
    }
  }
  const std::size_t rest = records * stride;
  std::copy(columns.begin() + static_cast<std::ptrdiff_t>(rest), columns.end(),
            chunk.begin() + static_cast<std::ptrdiff_t>(rest));
}

}  // namespace

std::string pack_chunk(std::string_view chunk) {
  constexpr int fastest = 1;
  const std::string columns = apart(chunk);
  std::string packed(chunk.size() - chunk.size() / 16, '\0');
  const std::size_t size =
      ZSTD_compress(packed.data(), packed.size(), columns.data(), columns.size(), fastest);
  // An error means that the chunk does not become smaller; the empty result says so.
  packed.resize(ZSTD_isError(size) != 0U ? 0 : size);
  return packed;
}

void unpack_chunk(std::string_view packed, std::span<char> chunk) {
  std::string columns(chunk.size(), '\0');
  const std::size_t size =
      ZSTD_decompress(columns.data(), columns.size(), packed.data(), packed.size());
  if (ZSTD_isError(size) != 0U || size != chunk.size()) {
    throw DecodeError("scene: a packed chunk is damaged or does not have its expected size");
  }
  together(columns, chunk);
}

}  // namespace parray::scene
