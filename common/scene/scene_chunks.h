#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "common/rooms.h"

/// How the bytes of a scene (scene_bytes.h) are cut for their way to workers.
namespace parray::scene {

/// Of a scene's bytes that travel: those of the most spheres and materials, and some room.
inline constexpr std::uint64_t max_scene_bytes = std::uint64_t{1} << 33;
inline constexpr std::uint32_t least_chunk_bytes = 1U << 8;
inline constexpr std::uint32_t most_chunk_bytes = 1U << 20;
/// What a coordinator cuts: small enough that a chain of many workers is soon full, and that a slow
/// connection shows that it is alive; large enough that their number costs nothing.
inline constexpr std::uint32_t usual_chunk_bytes = 1U << 18;

/// All chunks but the last are of the same size.
struct ChunkCut {
  std::uint64_t bytes = 0;  ///< of the scene
  std::uint32_t chunk_bytes = usual_chunk_bytes;

  [[nodiscard]] std::uint32_t count() const {
    return static_cast<std::uint32_t>((bytes + chunk_bytes - 1) / chunk_bytes);
  }
  [[nodiscard]] std::uint64_t begin(std::uint32_t chunk) const {
    return std::uint64_t{chunk} * chunk_bytes;
  }
  /// Of `chunk` < count().
  [[nodiscard]] std::size_t size(std::uint32_t chunk) const {
    return static_cast<std::size_t>(std::min<std::uint64_t>(chunk_bytes, bytes - begin(chunk)));
  }
  friend bool operator==(const ChunkCut&, const ChunkCut&) = default;
};

/// A chunk in less than 15/16 of its bytes, by zstd after equal bytes of all spheres were put side
/// by side; empty where it does not shrink so far: it travels as it is.
std::string pack_chunk(std::string_view chunk);

/// Inverse of pack_chunk(): fills `chunk`. Throws DecodeError where it is not exactly of that size.
void unpack_chunk(std::string_view packed, std::span<char> chunk);

}  // namespace parray::scene
