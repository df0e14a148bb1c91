#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/rooms.h"

namespace parray::output {

/// A range of frame numbers: first, first + step and so on, up to last.
struct FrameRange {
  std::uint32_t first = 0;
  std::uint32_t last = 0;  ///< >= first
  std::uint32_t step = 1;  ///< > 0

  [[nodiscard]] std::uint32_t count() const { return (last - first) / step + 1; }
  /// Returns the number of the frame at `place`, 0 to count() - 1.
  [[nodiscard]] std::uint32_t number(std::uint32_t place) const { return first + place * step; }
};

/// Parses the option --frames of `submit`: "3", "3-120" or "3-120:5" (first, last, step), with at
/// most limits::max_frames frames. Throws InputError for other texts.
FrameRange frame_range_from(std::string_view text);

/// Frames of a trajectory: a range, or all.
struct ChosenFrames {
  std::optional<FrameRange> range{};  ///< not given: all frames of the file
};

/// Parses the option --frames of `film` and of the HTTP interface: "all", "7", "0:100" or "0:100:5"
/// (first, last, step). Throws InputError for other texts.
ChosenFrames chosen_frames_from(const std::string& text);

/// Returns whether a file name has a place for the frame number: one "#" or several.
bool has_frame_number(const std::string& name);

/// Replaces each run of "#" by the number, with at least one digit per "#": "a-0007.exr".
std::string with_frame_number(const std::string& name, std::uint32_t frame);

}  // namespace parray::output
