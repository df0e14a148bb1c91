#pragma once

#include <xxhash.h>

#include <cstdint>
#include <string_view>

#include "common/rooms.h"

namespace parray::base {

/// Returns the XXH3-64 of the bytes.
inline std::uint64_t checksum_of(std::string_view bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

}  // namespace parray::base
