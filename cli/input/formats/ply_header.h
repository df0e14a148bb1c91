#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/input/particles/particle_input.h"

namespace parray::input {

enum class PlyFormat : std::uint8_t { ascii, little_endian, big_endian };

enum class PlyType : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct PlyProperty {
  std::string name;
  PlyType type{};                    ///< type of the value, or of each value of a list
  std::optional<PlyType> list_size;  ///< for lists: type of the count before the values
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;  ///< not empty if count > 0
};

struct PlyHeader {
  PlyFormat format{};
  std::vector<PlyElement> elements;
};

/// Reads the header of a PLY file, from "ply" to "end_header" (Turk, "The PLY Polygon File Format",
/// 1994). The next byte of `input` is then the first byte of the data. Throws InputError for
/// invalid headers, for more than limits::max_shapes vertices, and for elements with a count above
/// 0 but without properties.
PlyHeader read_ply_header(ParticleInput& input);

}  // namespace parray::input
