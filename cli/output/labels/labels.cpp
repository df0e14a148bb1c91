#include "cli/output/labels/labels.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cli/input/particles/length_unit.h"
#include "cli/input/select/columns.h"
#include "cli/output/labels/round_numbers.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::labels {
namespace {

constexpr double points_an_inch = 72;
constexpr double line_points = 0.6;
constexpr double cell_line_points = 0.5;
constexpr double gap_in_ems = 0.8;        ///< between labels, and between labels and particles
constexpr double edge_name_in_ems = 1.6;  ///< room for the name of an edge of the cell

/// Returns the size of letters in pixels.
double letter_size(const LabelSettings& settings, double dpi, double height) {
  const double points = settings.font_size.value_or(usual_font_size);
  const double size = points * dpi / points_an_inch;
  if (size > height) {
    throw InputError("--font-size: letters of " + number_text(points) + " points are " +
                     number_text(std::round(size)) + " pixels high, but the picture only " +
                     number_text(height) + ": use a smaller --font-size");
  }
  return std::max(size, 1.0);
}

}  // namespace

double dots_per_inch(const LabelSettings& settings, double width) {
  constexpr double millimetres_an_inch = 25.4;
  constexpr double usual_width_mm = 120;
  constexpr double screen = 96;
  if (settings.dpi) return *settings.dpi;
  if (settings.width_mm) return width / *settings.width_mm * millimetres_an_inch;
  return std::max(width / usual_width_mm * millimetres_an_inch, screen);
}

bool shows_lengths(const Legend& legend) {
  return !legend.stops.empty() && is_length_number(legend.title);
}

void set_title(Legend& legend, const LabelSettings& settings) {
  const bool arrows = !legend.entries.empty() && legend.entries.front().arrow;
  if (shows_lengths(legend) && !settings.unit.empty()) {
    legend.unit = trimmed(unit_sign(settings.unit));
  }
  if (settings.legend_title.empty() || arrows) return;
  legend.title = settings.legend_title;
  legend.unit.clear();
}

Labels::Labels(LabelContent content)
    : content_(std::move(content)),
      width_(content_.width),
      height_(content_.height),
      dpi_(dots_per_inch(content_.settings, width_)),
      font_(letter_size(content_.settings, dpi_, height_)),
      line_(std::max(line_points * dpi_ / points_an_inch, 1.0)),
      film_(content_.camera, width_, height_),
      margin_(gap_in_ems * font_.size()),
      style_{font_, line_, height_ - 2 * margin_} {
  make_blocks();
  placed_ = lay_out(blocks_, width_, height_, margin_, gap_in_ems * font_.size());
}

void Labels::make_blocks() {
  const LabelSettings& wanted = content_.settings;
  const auto add_text = [&](const char* option, const std::string& text) {
    std::string letters = text;
    std::erase(letters, '\n');
    font_.check(letters, option);
    blocks_.push_back(text_block(style_, option, Corner::top_left, text));
  };
  if (!wanted.text.empty()) add_text("--text", wanted.text);
  if (wanted.time_stamp) {
    if (content_.time_stamp.empty()) {
      throw InputError(
          "--time-stamp: the scene's particles have no time and only one frame: leave out "
          "--time-stamp, or time_stamp in the scene file");
    }
    add_text("--time-stamp", content_.time_stamp);
  }
  if (wanted.legend) add_legends();
  if (wanted.scale_bar) add_scale_bar();
  if (wanted.cell) {
    if (!content_.cell) {
      throw InputError(
          "--cell: the scene's particles have no box and no cell: leave out --cell, or cell in the "
          "scene file");
    }
    blocks_.push_back(axes_block(style_, film_));
  }
}

void Labels::add_legends() {
  if (content_.legends.empty()) {
    throw InputError(
        "--legend: the scene has no colours to explain: colour particles by element, type or "
        "number");
  }
  for (Legend& legend : content_.legends) {
    set_title(legend, content_.settings);
    font_.check(content_.settings.legend_title, "--legend-title");
    font_.check(content_.settings.unit, "--unit");
    blocks_.push_back(legend_block(style_, legend));
  }
}

std::string Labels::unit() const {
  const std::string& named = content_.settings.unit;
  return named.empty() ? content_.unit : named;
}

/// Returns the largest length of a scale bar, in pixels.
double Labels::longest_bar() const {
  return std::max(0.25 * width_, std::min(4 * font_.size(), 0.5 * width_));
}

void Labels::add_scale_bar() {
  font_.check(unit(), "--unit");
  const double pixels_per_unit = film_.pixels_per_unit(film_.distance());
  const double length = round_below(longest_bar() / pixels_per_unit);
  blocks_.push_back(scale_bar(length, length * pixels_per_unit));
}

/// Returns a scale bar in the unit that needs the fewest digits.
Block Labels::scale_bar(double length, double pixels) const {
  const ShownLength shown = shown_length(length, unit());
  return scale_bar_block(style_, shown.value, pixels, std::string(unit_sign(shown.unit)));
}

/// Returns the width of the widest scale bar of a camera that shows the scene at the same size or
/// up to ten times smaller.
double Labels::widest_bar() const {
  const double pixels_per_unit = film_.pixels_per_unit(film_.distance());
  double widest = 0;
  for (const double smaller : {1.0, 2.0, 2.5, 4.0, 5.0, 8.0, 10.0}) {
    const double length = round_below(longest_bar() / (pixels_per_unit / smaller));
    widest = std::max(widest, scale_bar(length, longest_bar()).width);
  }
  return widest;
}

/// Returns whether the map shows a particle in the box.
static bool shows_particle(const DepthMap& map, const Box& box, double width) {
  constexpr std::uint32_t sky = 0xffffffff;
  if (map.sphere.empty()) return false;
  for (auto y = static_cast<std::size_t>(box.y); static_cast<double>(y) < box.y + box.height; ++y) {
    for (auto x = static_cast<std::size_t>(box.x); static_cast<double>(x) < box.x + box.width;
         ++x) {
      const std::uint32_t sphere = map.sphere[y * static_cast<std::size_t>(width) + x];
      if (sphere != sky && sphere >= map.scenery) return true;
    }
  }
  return false;
}

/// Returns the place of the name of an edge: beside the edge, or farther out if particles or labels
/// are there.
Point Labels::place_of(const EdgeName& edge, const DepthMap& map) const {
  const double em = font_.size();
  for (double out = 0; out < std::max(width_, height_); out += em / 8) {
    const Point at = edge.middle + out * edge.outwards;
    const Box letter = Box{at.x, at.y, 0, 0}.grown(0.5 * em);
    const bool inside = letter.x >= 0 && letter.y >= 0 && letter.x + letter.width <= width_ &&
                        letter.y + letter.height <= height_;
    if (!inside) break;
    const bool labelled = std::ranges::any_of(
        placed_, [&](const Placed& label) { return overlap(letter, label.box); });
    if (!labelled && !shows_particle(map, letter, width_)) return at;
  }
  return edge.middle;
}

LabelPlaces Labels::places(const LabelContent& content) {
  const Labels labels(content);
  const double em = labels.font_.size();
  const double names = content.settings.cell ? edge_name_in_ems * em : 0;
  LabelPlaces places;
  places.margin_x = 2 * names / labels.width_;
  places.margin_y = 2 * names / labels.height_;
  for (const Placed& label : labels.placed_) {
    Box box = label.box;
    if (label.block->name == scale_bar_name) {
      const double more = std::max(labels.widest_bar() - box.width, 0.0);
      box.x -= more;
      box.width += more;
    }
    box = box.grown(gap_in_ems * em + names);
    places.boxes.push_back(
        {2 * box.x / labels.width_ - 1, 2 * (box.x + box.width) / labels.width_ - 1,
         1 - 2 * (box.y + box.height) / labels.height_, 1 - 2 * box.y / labels.height_});
  }
  return places;
}

std::vector<Box> Labels::boxes() const {
  std::vector<Box> boxes;
  for (const Placed& label : placed_) boxes.push_back(label.box);
  return boxes;
}

void Labels::draw(Image& image, std::vector<float>& alpha, const DepthMap& map) const {
  Canvas canvas(image, alpha);
  const double em = font_.size();
  if (content_.settings.cell) {
    const double cell_line = std::max(cell_line_points * dpi_ / points_an_inch, 1.0);
    if (!content_.solid_cell) {
      draw_lines(canvas, cell_lines(*content_.cell, film_), film_, map, cell_line);
    }
    for (const EdgeName& edge : edge_names(*content_.cell, film_, 0.7 * em)) {
      const Point at = place_of(edge, map);
      Pen pen(font_, line_, {at.x - em / 2, at.y - em / 2, em, em});
      pen.centered(at.x, at.y + 0.27 * em, std::string(1, edge.name));
      pen.draw_on(canvas);
    }
  }
  for (const Placed& label : placed_) {
    Pen pen(font_, line_, label.box);
    label.block->draw(pen, {label.box.x, label.box.y});
    pen.draw_on(canvas);
  }
}

}  // namespace parray::labels
