#include "cli/output/labels/canvas.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace parray::labels {
namespace {

constexpr double halo_strength = 0.75;

}  // namespace

double halo_width(double size) { return std::max(0.1 * size, 1.0); }

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

Ink ink_for(bool light) {
  const Vec3d black{0, 0, 0};
  const Vec3d white{1, 1, 1};
  return light ? Ink{black, white} : Ink{white, black};
}

Pen::Pen(const Font& font, double line, const Box& area)
    : font_(font), line_(line), area_(area), ink_(area.grown(2 * halo_width(font.size()) + 1)) {}

void Pen::text(double x, double baseline, std::string_view text) {
  font_.draw(ink_, {x, baseline}, text);
}

void Pen::centered(double x, double baseline, std::string_view words) {
  text(x - font_.width(words) / 2, baseline, words);
}

void Pen::stroke(const Point& from, const Point& to) { ink_.add_line(from, to, line_); }

void Pen::bar(const Box& box) { ink_.add(box); }

void Pen::colored(const Box& box, std::function<Vec3d(double)> color) {
  const Box frame = box.grown(line_);
  ink_.add(Box{frame.x, frame.y, frame.width, line_});
  ink_.add(Box{frame.x, box.y + box.height, frame.width, line_});
  ink_.add(Box{frame.x, box.y, line_, box.height});
  ink_.add(Box{box.x + box.width, box.y, line_, box.height});
  colored_.push_back({box, std::move(color)});
}

void Pen::draw_on(Canvas& canvas) const {
  const Ink ink = ink_for(canvas.is_light(area_));
  canvas.paint(ink_.grown(halo_width(font_.size())), ink.halo, halo_strength);
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
  canvas.paint(ink_, ink.color);
}

}  // namespace parray::labels
