#include "cli/check/compare/difference_image.h"

#include <algorithm>
#include <cmath>

namespace parray::compare {

DifferenceImage::DifferenceImage(const Image& reference)
    : reference_(reference),
      sum_{reference.width, reference.height, std::vector<float>(reference.rgb.size())} {}

void DifferenceImage::add(const Image& image) {
  for (std::size_t i = 0; i < sum_.rgb.size(); ++i) {
    const float r = reference_.rgb[i];
    const float f = image.rgb[i];
    if (r == f || (std::isnan(r) && std::isnan(f))) continue;
    const float difference = std::abs(r - f);
    sum_.rgb[i] += std::isnan(difference) ? 1 : difference;
  }
}

float DifferenceImage::largest() const { return *std::ranges::max_element(sum_.rgb); }

Image DifferenceImage::drawn() const {
  Image picture = sum_;
  for (float& value : picture.rgb) value = std::max(0.0F, 1 - value);
  return picture;
}

}  // namespace parray::compare
