#pragma once

#include <bit>
#include <string>
#include <vector>

#include "common/math/vec.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"

/// The same three particles for every format.
namespace parray::test {

inline std::vector<Vec3d> three_positions() {
  return {{1, -2, 3.5}, {0, 0.25, -1e3}, {-0.125, 7, 0}};
}

inline std::string ply_header(const std::string& format, const std::string& properties) {
  return "ply\nformat " + format + " 1.0\ncomment made by hand\nelement vertex 3\n" + properties +
         "end_header\n";
}

inline constexpr const char* xyz_properties =
    "property float x\nproperty double y\nproperty float z\n";

/// Returns the three positions as `xyz_properties` describes them.
inline std::string binary_positions(std::endian order) {
  std::string bytes;
  for (const Vec3d& p : three_positions()) {
    bytes += bytes_of(static_cast<float>(p.x), order) + bytes_of(p.y, order) +
             bytes_of(static_cast<float>(p.z), order);
  }
  return bytes;
}

}  // namespace parray::test
