#include "common/trace/integrator/start_shapes.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace parray::trace {
namespace {

/// Largest number of tiles of a picture, and of entries in all tiles per sphere. More would cost
/// memory. With fewer, a tile has more spheres to test.
constexpr std::uint64_t most_tiles = 1U << 16;
constexpr std::uint64_t entries_a_sphere = 8;

std::uint32_t tiles_along(std::uint32_t pixels, std::uint32_t bits) {
  return ((pixels - 1) >> bits) + 1;
}

/// Returns the tiles that overlap a box.
PixelBox tiles_of(const PixelBox& box, std::uint32_t bits) {
  return {box.left >> bits, box.right >> bits, box.top >> bits, box.bottom >> bits};
}

std::uint64_t area(const PixelBox& box) {
  return std::uint64_t{box.right - box.left + 1} * (box.bottom - box.top + 1);
}

/// Returns the whole pixels of an interval, cut to the first `count`. Returns nothing if the
/// interval lies beside them.
std::optional<std::pair<std::uint32_t, std::uint32_t>> pixels_in(double begin, double end,
                                                                 std::uint32_t count) {
  const double last = count - 1;
  if (!(end >= 0) || !(begin <= last + 1)) return {};
  return std::pair{static_cast<std::uint32_t>(std::clamp(std::floor(begin), 0.0, last)),
                   static_cast<std::uint32_t>(std::clamp(std::floor(end), 0.0, last))};
}

}  // namespace

RayStarts::RayStarts(const Camera& camera, std::uint32_t width, std::uint32_t height)
    : axes_(camera),
      eye_(camera.look_from),
      lens_(camera.aperture / 2),
      parallel_(camera.projection == Projection::orthographic),
      pixels_per_length_(parallel_ ? height / camera.view_height : 0),
      width_(width),
      height_(height) {
  reach_ = lens_ + (parallel_ ? (width_ + height_) / pixels_per_length_ / 2 : 0);
  far_ = length(eye_) + reach_;
}

std::optional<PixelBox> RayStarts::box(const Vec3d& to_center, double radius) const {
  if (!parallel_) return PixelBox{0, width_ - 1, 0, height_ - 1};
  const double off = dot(to_center, axes_.back);
  const double cut_squared = (radius - off) * (radius + off);
  if (!(cut_squared > 0)) return {};
  const double reach = (square_root(cut_squared) + lens_) * pixels_per_length_;
  const double x = dot(to_center, axes_.right) * pixels_per_length_ + 0.5 * width_;
  const double y = 0.5 * height_ - dot(to_center, axes_.up) * pixels_per_length_;
  const auto columns = pixels_in(x - reach, x + reach, width_);
  const auto rows = pixels_in(y - reach, y + reach, height_);
  if (!columns || !rows) return {};
  return PixelBox{columns->first, columns->second, rows->first, rows->second};
}

void StartShapes::sort_into_tiles(std::span<const Candidate> candidates, std::uint32_t width,
                                  std::uint32_t height) {
  const auto entries = [&](std::uint32_t bits) {
    std::uint64_t sum = 0;
    for (const Candidate& candidate : candidates) sum += area(tiles_of(candidate.box, bits));
    return sum;
  };
  const auto tiles = [&](std::uint32_t bits) {
    return std::uint64_t{tiles_along(width, bits)} * tiles_along(height, bits);
  };
  std::uint32_t bits = 0;
  while (tiles(bits) > 1 && (tiles(bits) > most_tiles || tiles(bits) > candidates.size() ||
                             entries(bits) > entries_a_sphere * candidates.size())) {
    ++bits;
  }
  tiles_ = {nullptr, nullptr, bits, tiles_along(width, bits)};

  const auto for_each_entry = [&](const auto& visit) {
    for (const Candidate& candidate : candidates) {
      const PixelBox box = tiles_of(candidate.box, bits);
      for (std::uint32_t row = box.top; row <= box.bottom; ++row) {
        for (std::uint32_t column = box.left; column <= box.right; ++column) {
          visit(row * tiles_.across + column, candidate.number);
        }
      }
    }
  };
  begins_.assign(tiles(bits) + 1, 0);
  for_each_entry([&](std::uint32_t tile, std::uint32_t) { ++begins_[tile + 1]; });
  for (std::size_t tile = 1; tile < begins_.size(); ++tile) begins_[tile] += begins_[tile - 1];
  numbers_.resize(begins_.back());
  std::vector<std::uint32_t> next(begins_);
  for_each_entry(
      [&](std::uint32_t tile, std::uint32_t number) { numbers_[next[tile]++] = number; });
}

StartTable StartShapes::table() const {
  if (empty()) return {};
  StartTable table = tiles_;
  table.numbers = numbers_.data();
  table.begins = begins_.data();
  return table;
}

}  // namespace parray::trace
