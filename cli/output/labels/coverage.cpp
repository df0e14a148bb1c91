#include "cli/output/labels/coverage.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace parray::labels {
namespace {

/// Returns the share of [i, i + 1] that lies in [begin, end].
double overlap(int i, double begin, double end) {
  return std::max(std::min(i + 1.0, end) - std::max<double>(i, begin), 0.0);
}

int whole_below(double value) { return static_cast<int>(std::floor(value)); }
int whole_above(double value) { return static_cast<int>(std::ceil(value)); }

}  // namespace

Coverage::Coverage(const Box& box)
    : left_(whole_below(box.x)),
      top_(whole_below(box.y)),
      width_(std::max(whole_above(box.x + box.width) - left_, 0)),
      height_(std::max(whole_above(box.y + box.height) - top_, 0)),
      values_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_)) {}

void Coverage::add(int x, int y, float share) {
  if (!inside(x, y)) return;
  float& value = values_[index(x, y)];
  value = std::min(value + share, 1.0F);
}

void Coverage::add(const Box& rectangle) {
  const double right = rectangle.x + rectangle.width;
  const double bottom = rectangle.y + rectangle.height;
  const int end_x = std::min(whole_above(right), left_ + width_);
  const int end_y = std::min(whole_above(bottom), top_ + height_);
  for (int y = std::max(whole_below(rectangle.y), top_); y < end_y; ++y) {
    for (int x = std::max(whole_below(rectangle.x), left_); x < end_x; ++x) {
      add(x, y,
          static_cast<float>(overlap(x, rectangle.x, right) * overlap(y, rectangle.y, bottom)));
    }
  }
}

double line_share(double distance, double width) {
  return std::clamp(width / 2 + 0.5 - distance, 0.0, std::min(width, 1.0));
}

void Coverage::add_line(const Point& from, const Point& to, double width) {
  const double dx = to.x - from.x;
  const double dy = to.y - from.y;
  const double length = std::hypot(dx, dy);
  if (!(length > 0)) return;
  const double reach = width / 2 + 1;
  const int end_x = std::min(whole_above(std::max(from.x, to.x) + reach), left_ + width_);
  const int end_y = std::min(whole_above(std::max(from.y, to.y) + reach), top_ + height_);
  for (int y = std::max(whole_below(std::min(from.y, to.y) - reach), top_); y < end_y; ++y) {
    for (int x = std::max(whole_below(std::min(from.x, to.x) - reach), left_); x < end_x; ++x) {
      const double px = x + 0.5 - from.x;
      const double py = y + 0.5 - from.y;
      const double along = (px * dx + py * dy) / length;
      const double across = std::abs(px * dy - py * dx) / length;
      const double inside_ends = std::clamp(std::min(along, length - along) + 0.5, 0.0, 1.0);
      const auto share = static_cast<float>(line_share(across, width) * inside_ends);
      if (share > at(x, y)) add(x, y, share - at(x, y));  // lines that meet form one shape
    }
  }
}

Coverage Coverage::grown(double radius) const {
  struct Step {
    int x, y;
    float share;
  };
  std::vector<Step> disc;
  const int reach = whole_above(radius);
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      const double edge = std::clamp(radius + 1 - std::hypot(x, y), 0.0, 1.0);
      if (edge > 0) disc.push_back({x, y, static_cast<float>(edge)});
    }
  }
  Coverage grown(*this);
  for (int y = top_; y < top_ + height_; ++y) {
    for (int x = left_; x < left_ + width_; ++x) {
      const float share = at(x, y);
      // Points near the inside of a shape are nearer to its edge.
      const float around = std::min({at(x - 1, y), at(x + 1, y), at(x, y - 1), at(x, y + 1)});
      if (share <= 0 || (share >= 1 && around >= 1)) continue;
      for (const Step& step : disc) {
        if (!inside(x + step.x, y + step.y)) continue;
        float& value = grown.values_[index(x + step.x, y + step.y)];
        value = std::max(value, share * step.share);
      }
    }
  }
  return grown;
}

double Coverage::area() const { return std::accumulate(values_.begin(), values_.end(), 0.0); }

}  // namespace parray::labels
