#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/input/particles/particle_input.h"

namespace parray::input {

enum class PlyFormat : std::uint8_t { ascii, little_endian, big_endian };

enum class PlyType : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

/// Bytes of a value in a binary file.
std::size_t size_of(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type{};                    ///< of the value, or of each of a list's values
  std::optional<PlyType> list_size;  ///< a list: type of the number of values before it
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;  ///< not empty where count > 0
};

struct PlyHeader {
  PlyFormat format{};
  std::vector<PlyElement> elements;
};

/// Reads the header of a PLY file, "ply" to "end_header" (Turk, "The PLY Polygon File Format",
/// 1994). Throws InputError for what that does not define, for an element "vertex" of more than
/// limits::max_spheres, and for elements that lack properties.
PlyHeader read_ply_header(ParticleInput& input);

}  // namespace parray::input
