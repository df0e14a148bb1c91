#include "cli/output/labels/canvas.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace parray::labels {
namespace {

/// Returns the share of [i, i + 1] that lies in [begin, end].
double overlap(int i, double begin, double end) {
  return std::max(std::min(i + 1.0, end) - std::max<double>(i, begin), 0.0);
}

int whole_below(double value) { return static_cast<int>(std::floor(value)); }
int whole_above(double value) { return static_cast<int>(std::ceil(value)); }

constexpr double halo_strength = 0.75;

/// Returns the width in pixels of the halo around letters of `size` pixels per em.
double halo_width(double size) { return std::max(0.1 * size, 1.0); }

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

void Canvas::paint(int x, int y, const Vec3d& color, double share) {
  const auto width = static_cast<int>(image_.width);
  if (x < 0 || y < 0 || x >= width || y >= static_cast<int>(image_.height) || share <= 0) return;
  const std::size_t pixel =
      static_cast<std::size_t>(y) * image_.width + static_cast<std::size_t>(x);
  const auto over = [&](float& below, double value) {
    below = static_cast<float>(share * value + (1 - share) * static_cast<double>(below));
  };
  over(image_.rgb[3 * pixel], color.x);
  over(image_.rgb[3 * pixel + 1], color.y);
  over(image_.rgb[3 * pixel + 2], color.z);
  if (!alpha_.empty()) over(alpha_[pixel], 1);
}

void Canvas::paint(const Coverage& coverage, const Vec3d& color, double strength) {
  for (int y = coverage.top(); y < coverage.top() + coverage.height(); ++y) {
    for (int x = coverage.left(); x < coverage.left() + coverage.width(); ++x) {
      paint(x, y, color, strength * static_cast<double>(coverage.at(x, y)));
    }
  }
}

double Canvas::luminance(int x, int y) const {
  const std::size_t pixel =
      static_cast<std::size_t>(y) * image_.width + static_cast<std::size_t>(x);
  const auto shown = [&](std::size_t channel) {
    return std::clamp(static_cast<double>(image_.rgb[3 * pixel + channel]), 0.0, 1.0);
  };
  // Rec. ITU-R BT.709-6, 3.3.
  const double luminance = 0.2126 * shown(0) + 0.7152 * shown(1) + 0.0722 * shown(2);
  return luminance + (alpha_.empty() ? 0 : 1 - static_cast<double>(alpha_[pixel]));
}

bool Canvas::is_light(const Box& box) const {
  const auto end = [](double value, std::uint32_t most) {
    return static_cast<int>(std::min<double>(std::ceil(value), most));
  };
  double sum = 0;
  double count = 0;
  for (int y = std::max(static_cast<int>(box.y), 0); y < end(box.y + box.height, image_.height);
       ++y) {
    for (int x = std::max(static_cast<int>(box.x), 0); x < end(box.x + box.width, image_.width);
         ++x) {
      // The cube root matches the perception of brightness, so a few bright pixels do not outweigh
      // many dark ones.
      sum += std::cbrt(luminance(x, y));
      ++count;
    }
  }
  return count == 0 || sum / count > light_background;
}

Pen::Pen(const Font& font, double line, const Box& area)
    : font_(font), line_(line), area_(area), ink_(area.grown(2 * halo_width(font.size()) + 1)) {}

void Pen::colored(const Box& box, std::function<Vec3d(double)> color) {
  const Box frame = box.grown(line_);
  ink_.add(Box{frame.x, frame.y, frame.width, line_});
  ink_.add(Box{frame.x, box.y + box.height, frame.width, line_});
  ink_.add(Box{frame.x, box.y, line_, box.height});
  ink_.add(Box{box.x + box.width, box.y, line_, box.height});
  colored_.push_back({box, std::move(color)});
}

void Pen::draw_on(Canvas& canvas) const {
  const bool light = canvas.is_light(area_);
  const Vec3d black{0, 0, 0};
  const Vec3d white{1, 1, 1};
  canvas.paint(ink_.grown(halo_width(font_.size())), light ? white : black, halo_strength);
  for (const Colored& part : colored_) {
    Coverage inside(part.box);
    inside.add(part.box);
    for (int y = inside.top(); y < inside.top() + inside.height(); ++y) {
      const double share = 1 - (y + 0.5 - part.box.y) / part.box.height;
      const Vec3d color = part.color(std::clamp(share, 0.0, 1.0));
      for (int x = inside.left(); x < inside.left() + inside.width(); ++x) {
        canvas.paint(x, y, color, inside.at(x, y));
      }
    }
  }
  canvas.paint(ink_, light ? black : white);
}

}  // namespace parray::labels
