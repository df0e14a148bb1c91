#pragma once

#include <cstdint>

namespace parray {

/// One frame of a file that has several.
struct FrameChoice {
  std::uint64_t number = 0;  ///< from 0
  bool last = false;         ///< the file's last, whatever its number

  friend bool operator==(const FrameChoice&, const FrameChoice&) = default;
};

}  // namespace parray
