#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/rooms.h"

namespace parray::denoise {

/// One number for each pixel of a picture, and for a margin around it, so that windows around whole
/// tiles of pixels may be read, the last ones too. The margin repeats the picture's border once
/// repeat_border() has run.
class Plane {
 public:
  static constexpr std::size_t margin = 8;
  static constexpr std::size_t tile = 32;

  Plane(std::uint32_t width, std::uint32_t height)
      : width_(width),
        height_(height),
        stride_(whole_tiles(width) + 2 * margin),
        values_(stride_ * (whole_tiles(height) + 2 * margin)) {}

  [[nodiscard]] std::uint32_t width() const { return width_; }
  [[nodiscard]] std::uint32_t height() const { return height_; }
  /// From a row to the next.
  [[nodiscard]] std::size_t stride() const { return stride_; }
  [[nodiscard]] float* row(std::size_t y) { return values_.data() + start(y); }
  [[nodiscard]] const float* row(std::size_t y) const { return values_.data() + start(y); }

  void repeat_border();

 private:
  static std::size_t whole_tiles(std::size_t side) { return (side + tile - 1) / tile * tile; }
  [[nodiscard]] std::size_t start(std::size_t y) const { return (y + margin) * stride_ + margin; }

  std::uint32_t width_;
  std::uint32_t height_;
  std::size_t stride_;
  std::vector<float> values_;
};

}  // namespace parray::denoise
