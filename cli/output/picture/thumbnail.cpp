#include "cli/output/picture/thumbnail.h"

#include <algorithm>
#include <cmath>

namespace parray::picture {
namespace {

/// A share of one old pixel or row in a new one.
struct Share {
  std::uint32_t from = 0;
  double weight = 0;  ///< the shares of one new pixel have the sum 1
};

/// Returns the shares of each of `to` equal parts of `from` pixels.
std::vector<std::vector<Share>> shares(std::uint64_t from, std::uint64_t to) {
  std::vector<std::vector<Share>> all(to);
  for (std::uint64_t part = 0; part < to; ++part) {
    // In units of 1/to of an old pixel, so that all borders are whole numbers.
    const std::uint64_t begin = part * from;
    const std::uint64_t end = begin + from;
    for (std::uint64_t old = begin / to; old * to < end; ++old) {
      const std::uint64_t covered = std::min(end, (old + 1) * to) - std::max(begin, old * to);
      all[part].push_back({static_cast<std::uint32_t>(old),
                           static_cast<double>(covered) / static_cast<double>(from)});
    }
  }
  return all;
}

}  // namespace

Image thumbnail(const Image& image, std::uint32_t width) {
  if (width >= image.width) return image;
  const double height = std::round(static_cast<double>(image.height) * width / image.width);
  Image made{width, static_cast<std::uint32_t>(std::max(1.0, height)), {}};
  made.rgb.reserve(std::size_t{3} * made.width * made.height);
  const auto columns = shares(image.width, made.width);
  std::vector<double> row(std::size_t{3} * image.width);
  for (const auto& rows : shares(image.height, made.height)) {
    std::ranges::fill(row, 0);
    for (const Share& share : rows) {
      const float* const old = image.rgb.data() + share.from * row.size();
      for (std::size_t i = 0; i < row.size(); ++i) row[i] += share.weight * old[i];
    }
    for (const auto& pixels : columns) {
      for (std::size_t channel = 0; channel < 3; ++channel) {
        double sum = 0;
        for (const Share& share : pixels)
          sum += share.weight * row[std::size_t{3} * share.from + channel];
        made.rgb.push_back(static_cast<float>(sum));
      }
    }
  }
  return made;
}

}  // namespace parray::picture
