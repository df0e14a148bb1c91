#include "cli/input/select/neighbour_grid.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cli/input/color/number_bounds.h"

namespace parray::input {
namespace {

constexpr int cell_bits = 21;
constexpr std::int64_t max_cells = std::int64_t{1} << (cell_bits - 1);  ///< along an axis

std::uint64_t key_of(std::int64_t x, std::int64_t y, std::int64_t z) {
  const auto bits = [](std::int64_t cell) { return static_cast<std::uint64_t>(cell); };
  return (bits(z) << (2 * cell_bits)) | (bits(y) << cell_bits) | bits(x);
}

}  // namespace

NeighbourGrid::NeighbourGrid(const std::vector<Vec3d>& points, double distance)
    : square_(distance * distance) {
  if (points.empty()) return;
  const PositionBounds bounds = bounds_of(points);
  low_ = bounds.low;
  high_ = bounds.high;
  const Vec3d extent = high_ - low_;
  const double widest = std::max({extent.x, extent.y, extent.z});
  constexpr double slack = 1 + 1e-6;  // close points stay in neighbouring cells despite rounding
  edge_ = std::max(distance, widest / static_cast<double>(max_cells - 1)) * slack;
  entries_.reserve(points.size());
  for (const Vec3d& p : points) {
    entries_.push_back({key_of(cell(p.x, low_.x), cell(p.y, low_.y), cell(p.z, low_.z)), p});
  }
  std::ranges::sort(entries_, {}, &Entry::key);
}

std::int64_t NeighbourGrid::cell(double coordinate, double low) const {
  return static_cast<std::int64_t>(std::floor((coordinate - low) / edge_));
}

bool NeighbourGrid::near(const Vec3d& position) const {
  if (entries_.empty()) return false;
  const auto outside = [this](double value, double low, double high) {
    return value < low - edge_ || value > high + edge_;
  };
  if (outside(position.x, low_.x, high_.x) || outside(position.y, low_.y, high_.y) ||
      outside(position.z, low_.z, high_.z)) {
    return false;
  }
  const std::int64_t x = cell(position.x, low_.x);
  const std::int64_t y = cell(position.y, low_.y);
  const std::int64_t z = cell(position.z, low_.z);
  constexpr std::array<std::int64_t, 3> steps{0, -1, 1};  // the row of `position` first
  for (const std::int64_t dz : steps) {
    for (const std::int64_t dy : steps) {
      if (near_in_row(position, x, y + dy, z + dz)) return true;
    }
  }
  return false;
}

bool NeighbourGrid::near_in_row(const Vec3d& position, std::int64_t x, std::int64_t y,
                                std::int64_t z) const {
  if (x < -1 || y < 0 || z < 0) return false;
  const Key last = key_of(x + 1, y, z);
  for (auto entry = std::ranges::lower_bound(
           entries_, key_of(std::max<std::int64_t>(x - 1, 0), y, z), {}, &Entry::key);
       entry != entries_.end() && entry->key <= last; ++entry) {
    const Vec3d offset = entry->point - position;
    if (dot(offset, offset) <= square_) return true;
  }
  return false;
}

}  // namespace parray::input
