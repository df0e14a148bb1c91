#include "cli/output/labels/block.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cli/output/labels/round_numbers.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::labels {
namespace {

double widest(const Font& font, const auto& lines) {
  double width = 0;
  for (const std::string_view line : lines) width = std::max(width, font.width(line));
  return width;
}

Vec3d color_at(const Legend& legend, double share) {
  const auto last = static_cast<double>(legend.stops.size() - 1);
  const double place = std::clamp(share, 0.0, 1.0) * last;
  const auto below = static_cast<std::size_t>(std::min(std::floor(place), last - 1));
  const double rest = place - static_cast<double>(below);
  return (1 - rest) * legend.stops[below] + rest * legend.stops[below + 1];
}

std::string title_of(const Legend& legend, int exponent) {
  std::string unit = exponent == 0 ? "" : power_of_ten(exponent);
  if (!legend.unit.empty()) unit += (unit.empty() ? "" : " ") + legend.unit;
  return legend.title + (unit.empty() ? "" : " (" + unit + ")");
}

/// Draws an arrow. Returns the unit vector along it. An arrow towards or away from the viewer is a
/// point, with the name beside it.
Point draw_arrow(Pen& pen, const Point& from, const Point& to) {
  const Point way = to - from;
  const double length = std::hypot(way.x, way.y);
  if (length <= pen.line()) return {-M_SQRT1_2, M_SQRT1_2};
  const Point along = 1 / length * way;
  pen.stroke(from, to);
  const double head = std::min(0.5 * pen.font().size(), length);
  for (const double turn : {-1.0, 1.0}) {
    pen.stroke(to, {to.x - head * (along.x * 0.9 + turn * along.y * 0.4),
                    to.y - head * (along.y * 0.9 - turn * along.x * 0.4)});
  }
  return along;
}

/// The places of the parts of a legend, from its upper left corner.
class LegendLayout {
 public:
  LegendLayout(const BlockStyle& style, const Legend& legend)
      : legend_(legend), em_(style.font.size()), line_(style.line) {
    bar_.height = std::clamp(0.4 * style.room_y, 5 * em_, 12 * em_);
    if (has_scale()) {
      const int most = static_cast<int>(bar_.height / (1.4 * em_));
      ticks_ = legend.log ? log_ticks_between(legend.low, legend.high, most)
                          : ticks_between(legend.low, legend.high, most);
    }
    title_ = title_of(legend, ticks_.exponent);
    width_ = style.font.width(title_);
    height_ = title_.empty() ? 0 : style.font.cap_height() + style.font.descent() + 0.35 * em_;
    if (has_scale()) place_scale(style);
    if (!legend.entries.empty()) place_entries(style);
  }

  [[nodiscard]] double width() const { return width_; }
  [[nodiscard]] double height() const { return height_; }

  void draw(Pen& pen, const Point& at) const {
    pen.text(at.x, at.y + pen.font().cap_height(), title_);
    if (has_scale()) draw_scale(pen, at);
    for (std::size_t i = 0; i < legend_.entries.size(); ++i) draw_entry(pen, at, i);
  }

 private:
  [[nodiscard]] bool has_scale() const { return !legend_.stops.empty(); }
  [[nodiscard]] double pitch() const { return 1.35 * em_; }

  void place_scale(const BlockStyle& style) {
    bar_ = {line_, height_ + line_, 1.1 * em_, bar_.height};
    // The outermost numbers extend beyond the bar.
    const double half = style.font.cap_height() / 2;
    bar_.y += std::max(0.0, half - y_of(ticks_.values.back()) + bar_.y);
    numbers_ = bar_.width + 2 * line_ + 0.6 * em_;
    width_ = std::max(width_, numbers_ + widest(style.font, ticks_.texts));
    height_ = bar_.y + bar_.height +
              std::max(line_, half - (bar_.y + bar_.height) + y_of(ticks_.values.front()));
    if (!legend_.entries.empty()) height_ += 0.6 * em_;
  }

  /// Places entries in rows, and in further columns when the height is used up.
  void place_entries(const BlockStyle& style) {
    entries_top_ = height_;
    const std::size_t count = legend_.entries.size();
    const double room = std::max(style.room_y - entries_top_, pitch());
    rows_ = std::min(count, static_cast<std::size_t>(room / pitch()));
    const std::size_t columns = (count + rows_ - 1) / rows_;
    rows_ = (count + columns - 1) / columns;
    std::vector<std::string> names;
    for (const LegendEntry& entry : legend_.entries) names.push_back(entry.name);
    column_ = 1.4 * em_ + widest(style.font, names);
    width_ = std::max(width_, static_cast<double>(columns) * (column_ + em_) - em_);
    height_ += static_cast<double>(rows_) * pitch();
  }

  [[nodiscard]] double y_of(double value) const {
    const auto on_scale = [this](double number) {
      return (legend_.log ? std::log(number) : number) / 2;  // half: the width may overflow
    };
    const double low = on_scale(legend_.low);
    const double share = (on_scale(value) - low) / (on_scale(legend_.high) - low);
    return bar_.y + bar_.height * (1 - share);
  }

  void draw_scale(Pen& pen, const Point& at) const {
    pen.colored({at.x + bar_.x, at.y + bar_.y, bar_.width, bar_.height},
                [legend = legend_](double share) { return color_at(legend, share); });
    const double right = at.x + bar_.x + bar_.width + line_;
    for (std::size_t i = 0; i < ticks_.values.size(); ++i) {
      const double y = at.y + y_of(ticks_.values[i]);
      pen.stroke({right, y}, {right + 0.3 * em_, y});
      pen.text(at.x + numbers_, y + pen.font().cap_height() / 2, ticks_.texts[i]);
    }
  }

  void draw_entry(Pen& pen, const Point& at, std::size_t i) const {
    const std::size_t column = i / rows_;
    const double x = at.x + static_cast<double>(column) * (column_ + em_);
    const double y = at.y + entries_top_ + static_cast<double>(i % rows_) * pitch();
    const double side = 0.9 * em_;
    const double middle = y + pitch() / 2;
    if (legend_.entries[i].arrow) {
      draw_arrow(pen, {x, middle}, {x + side + line_, middle});
    } else {
      pen.colored({x + line_, middle - side / 2, side, side},
                  [color = legend_.entries[i].color](double /*share*/) { return color; });
    }
    pen.text(x + 1.4 * em_, middle + pen.font().cap_height() / 2, legend_.entries[i].name);
  }

  Legend legend_;
  double em_, line_;
  std::string title_;
  Ticks ticks_;
  Box bar_{};
  double numbers_ = 0;
  double entries_top_ = 0;
  std::size_t rows_ = 1;
  double column_ = 0;
  double width_ = 0;
  double height_ = 0;
};

/// Moves the points until they are about `distance` apart.
void move_apart(std::array<Point, 3>& points, double distance) {
  for (int round = 0; round < 8; ++round) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      Point& a = points[i];
      Point& b = points[(i + 1) % points.size()];
      const Point way = b - a;
      const double length = std::hypot(way.x, way.y);
      if (length >= distance) continue;
      const Point along = length > 0 ? 1 / length * way : Point{1, 0};
      a = a - (distance - length) / 2 * along;
      b = b + (distance - length) / 2 * along;
    }
  }
}

[[noreturn]] void fail_to_fit(const Block& block, double width, double height,
                              const std::string& other) {
  std::string key = block.name.substr(2);
  std::ranges::replace(key, '-', '_');
  throw InputError(block.name + ": the label does not fit into " + number_text(width) + " x " +
                   number_text(height) + " pixels" + (other.empty() ? "" : " beside " + other) +
                   ": use a smaller --font-size, or leave out " + block.name + ", or " + key +
                   " in the scene file");
}

}  // namespace

Block text_block(const BlockStyle& style, const std::string& name, Corner corner,
                 const std::string& text) {
  const std::vector<std::string_view> lines = split_at('\n', text);
  const auto draw = [text](Pen& pen, const Point& at) {
    double baseline = at.y + pen.font().cap_height();
    for (const std::string_view line : split_at('\n', text)) {
      pen.text(at.x, baseline, line);
      baseline += pen.font().line_height();
    }
  };
  // From the top of the first line's capitals to the lowest letters of the last line.
  const double height = style.font.cap_height() +
                        static_cast<double>(lines.size() - 1) * style.font.line_height() +
                        style.font.descent();
  return {name, corner, widest(style.font, lines), height, draw};
}

Block legend_block(const BlockStyle& style, const Legend& legend) {
  const LegendLayout layout(style, legend);
  return {"--legend", Corner::top_right, layout.width(), layout.height(),
          [layout](Pen& pen, const Point& at) { layout.draw(pen, at); }};
}

Block scale_bar_block(const BlockStyle& style, double length, double pixels,
                      const std::string& unit) {
  const Ticks number = ticks_between(0, length, 2);
  std::string text = number.texts.back();
  if (number.exponent != 0) text += " \u00d7 " + power_of_ten(number.exponent);
  if (!unit.empty()) text += " " + unit;
  const double em = style.font.size();
  const double width = std::max(pixels, style.font.width(text));
  const double above = style.font.cap_height() + 0.4 * em;
  const double thick = 0.25 * em;
  const auto draw = [=](Pen& pen, const Point& at) {
    const double middle = at.x + width / 2;
    pen.centered(middle, at.y + pen.font().cap_height(), text);
    pen.bar({middle - pixels / 2, at.y + above, pixels, thick});
  };
  return {scale_bar_name, Corner::bottom_right, width, above + thick, draw};
}

Block axes_block(const BlockStyle& style, const CameraFilm& film) {
  const double em = style.font.size();
  const double arm = 2.2 * em;
  const double side = 2 * (arm + 1.3 * em);
  const std::array<Vec3d, 3> axes{film.turned({1, 0, 0}), film.turned({0, 1, 0}),
                                  film.turned({0, 0, 1})};
  const auto draw = [=](Pen& pen, const Point& at) {
    const Point middle{at.x + side / 2, at.y + side / 2};
    std::array<Point, 3> names;
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const Point end{middle.x + arm * axes[i].x, middle.y - arm * axes[i].y};
      names[i] = end + 0.55 * em * draw_arrow(pen, middle, end);
    }
    move_apart(names, 0.9 * em);
    for (std::size_t i = 0; i < names.size(); ++i) {
      pen.centered(names[i].x, names[i].y + 0.27 * em, std::string(1, static_cast<char>('x' + i)));
    }
  };
  return {"--cell", Corner::bottom_left, side, side, draw};
}

bool overlap(const Box& a, const Box& b) {
  return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}

std::vector<Placed> lay_out(const std::vector<Block>& blocks, double width, double height,
                            double margin, double gap) {
  std::array<double, 4> filled{};
  std::vector<Placed> placed;
  for (const Block& block : blocks) {
    double& used = filled[static_cast<std::size_t>(block.corner)];
    const bool top = block.corner == Corner::top_left || block.corner == Corner::top_right;
    const bool left = block.corner == Corner::top_left || block.corner == Corner::bottom_left;
    const Box box{left ? margin : width - margin - block.width,
                  top ? margin + used : height - margin - used - block.height, block.width,
                  block.height};
    used += block.height + gap;
    constexpr double rounding = 1e-6;  // tolerance for blocks at the margin
    const double least = margin - rounding;
    const bool inside = box.x >= least && box.y >= least && box.x + box.width <= width - least &&
                        box.y + box.height <= height - least;
    if (!inside) fail_to_fit(block, width, height, "");
    for (const Placed& other : placed) {
      if (overlap(box.grown(gap / 2), other.box)) {
        fail_to_fit(block, width, height, other.block->name);
      }
    }
    placed.push_back({&block, box});
  }
  return placed;
}

}  // namespace parray::labels
