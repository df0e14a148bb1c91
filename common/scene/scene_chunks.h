#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "common/rooms.h"

/// Cuts the bytes of a scene (scene_bytes.h) into chunks for their way to workers.
namespace parray::scene {

/// Largest size of a scene that travels, in bytes: that of a scene with the most shapes and
/// materials, rounded up.
inline constexpr std::uint64_t max_scene_bytes = std::uint64_t{1} << 33;
/// Bounds of ChunkCut::chunk_bytes in messages.
inline constexpr std::uint32_t least_chunk_bytes = 1U << 8;
inline constexpr std::uint32_t most_chunk_bytes = 1U << 20;
/// Size of a coordinator's chunks. It is small enough that workers that pass chunks on, one to the
/// next, soon all have some, and that a slow connection shows that it is alive. It is large enough
/// that the number of chunks costs nothing.
inline constexpr std::uint32_t usual_chunk_bytes = 1U << 18;

/// The cut of a scene's bytes into chunks. All chunks except the last one have the same size.
struct ChunkCut {
  std::uint64_t bytes = 0;  ///< bytes of the scene
  std::uint32_t chunk_bytes = usual_chunk_bytes;

  [[nodiscard]] std::uint32_t count() const {
    return static_cast<std::uint32_t>((bytes + chunk_bytes - 1) / chunk_bytes);
  }
  [[nodiscard]] std::uint64_t begin(std::uint32_t chunk) const {
    return std::uint64_t{chunk} * chunk_bytes;
  }
  /// Returns the bytes of `chunk` < count().
  [[nodiscard]] std::size_t size(std::uint32_t chunk) const {
    return static_cast<std::size_t>(std::min<std::uint64_t>(chunk_bytes, bytes - begin(chunk)));
  }
  friend bool operator==(const ChunkCut&, const ChunkCut&) = default;
};

/// Packs a chunk into at most 15/16 of its bytes. Groups bytes that are a multiple of
/// scene_bytes_of_sphere apart, because corresponding bytes of spheres are similar, and compresses
/// the groups with zstd. Returns an empty string if the chunk does not shrink that far; the chunk
/// then travels unpacked.
std::string pack_chunk(std::string_view chunk);

/// Reverses pack_chunk() and fills `chunk`. Throws DecodeError if `packed` is damaged or its
/// content does not have exactly the size of `chunk`.
void unpack_chunk(std::string_view packed, std::span<char> chunk);

}  // namespace parray::scene
