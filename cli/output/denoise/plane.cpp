#include "cli/output/denoise/plane.h"

#include <algorithm>

namespace parray::denoise {

void Plane::repeat_border() {
  for (std::size_t y = 0; y < height_; ++y) {
    float* const first = row(y);
    std::fill(first - margin, first, first[0]);
    std::fill(first + width_, first - margin + stride_, first[width_ - 1]);
  }
  const auto row_size = static_cast<std::ptrdiff_t>(stride_);
  const auto top = values_.begin() + static_cast<std::ptrdiff_t>(margin) * row_size;
  const auto bottom = top + (static_cast<std::ptrdiff_t>(height_) - 1) * row_size;
  for (auto to = values_.begin(); to != top; to += row_size) {
    std::copy(top, top + row_size, to);
  }
  for (auto to = bottom + row_size; to != values_.end(); to += row_size) {
    std::copy(bottom, bottom + row_size, to);
  }
}

}  // namespace parray::denoise
