#pragma once

#include <cstdint>

#include "cli/input/formats/ply_header.h"
#include "cli/input/particles/binary_input.h"

/// Values of binary PLY data.
namespace parray::input {

template <typename T>
double ply_value(const char* bytes, bool swapped) {
  return static_cast<double>(binary_value<T>(bytes, swapped));
}

/// What `use` returns for a value of the type that `type` stands for.
template <typename Use>
auto with_ply_type(PlyType type, const Use& use) {
  switch (type) {
    case PlyType::int8:
      return use(std::int8_t{});
    case PlyType::uint8:
      return use(std::uint8_t{});
    case PlyType::int16:
      return use(std::int16_t{});
    case PlyType::uint16:
      return use(std::uint16_t{});
    case PlyType::int32:
      return use(std::int32_t{});
    case PlyType::uint32:
      return use(std::uint32_t{});
    case PlyType::float32:
      return use(float{});
    default:
      return use(double{});
  }
}

}  // namespace parray::input
