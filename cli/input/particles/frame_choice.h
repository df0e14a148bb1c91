#pragma once

#include <cstdint>
#include <string_view>

#include "common/rooms.h"

namespace parray::input {

/// Stands for a file's last frame.
inline constexpr std::string_view last_frame_word = "last";

/// One frame of a file that has several.
struct FrameChoice {
  std::uint64_t number = 0;  ///< from 0
  bool last = false;         ///< the file's last, whatever its number

  friend bool operator==(const FrameChoice&, const FrameChoice&) = default;
};

}  // namespace parray::input
