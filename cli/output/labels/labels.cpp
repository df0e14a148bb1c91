#include "cli/output/labels/labels.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cli/input/particles/length_unit.h"
#include "cli/output/labels/block.h"
#include "cli/output/labels/round_numbers.h"
#include "common/base/error.h"
#include "common/base/printable.h"

namespace parray::labels {
namespace {

constexpr double points_an_inch = 72;
constexpr double line_points = 0.6;
constexpr double cell_line_points = 0.8;

/// Returns the size of letters in pixels.
double letter_size(const LabelSettings& settings, double dpi, double height) {
  const double points = settings.font_size.value_or(usual_font_size);
  const double size = points * dpi / points_an_inch;
  if (size > height) {
    throw InputError("--font-size: letters of " + number_text(points) + " points are " +
                     number_text(std::round(size)) + " pixels high, but the picture only " +
                     number_text(height) + ": use smaller letters or a larger picture");
  }
  return std::max(size, 1.0);
}

[[noreturn]] void fail_without(const std::string& option, const std::string& what) {
  throw InputError(option + ": " + what);
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

double scale_bar_length(double pixels_per_unit, double most_pixels) {
  return round_below(most_pixels / pixels_per_unit);
}

struct Labels::Parts {
  explicit Parts(LabelContent from)
      : content(std::move(from)),
        width(content.width),
        height(content.height),
        dpi(dots_per_inch(content.settings, width)),
        font(letter_size(content.settings, dpi, height)),
        line(std::max(line_points * dpi / points_an_inch, 1.0)),
        film(content.camera, width, height),
        margin(0.8 * font.size()),
        style{font, line, width - 2 * margin, height - 2 * margin} {
    make_blocks();
    placed = lay_out(blocks, width, height, margin, 0.8 * font.size());
  }

  void make_blocks();
  void add_legends();
  void add_scale_bar();

  LabelContent content;
  double width, height;
  double dpi;
  Font font;
  double line;
  CameraFilm film;
  double margin;
  BlockStyle style;
  std::vector<Block> blocks;
  std::vector<Placed> placed;
};

void Labels::Parts::make_blocks() {
  const LabelSettings& wanted = content.settings;
  const auto add_text = [&](const char* option, const std::string& text) {
    std::string letters = text;
    std::erase(letters, '\n');
    font.check(letters, option);
    blocks.push_back(text_block(style, option, Corner::top_left, text));
  };
  if (!wanted.text.empty()) add_text("--text", wanted.text);
  if (wanted.time_stamp) {
    if (content.time_stamp.empty()) {
      fail_without("--time-stamp",
                   "the scene's particles have no time and only one frame: leave out --time-stamp");
    }
    add_text("--time-stamp", content.time_stamp);
  }
  if (wanted.legend) add_legends();
  if (wanted.scale_bar) add_scale_bar();
  if (wanted.cell) {
    if (!content.cell) {
      fail_without("--cell", "the scene's particles have no box and no cell: leave out --cell");
    }
    blocks.push_back(axes_block(style, film));
  }
}

void Labels::Parts::add_legends() {
  if (content.legends.empty()) {
    fail_without("--legend",
                 "the scene has no colours to explain: colour particles by element, type or "
                 "number");
  }
  for (const Legend& legend : content.legends) {
    blocks.push_back(legend_block(style, legend));
  }
}

void Labels::Parts::add_scale_bar() {
  const std::string& named = content.settings.unit;
  const std::string& unit = named.empty() ? content.unit : named;
  font.check(unit, "--unit");
  const double pixels_per_unit = film.pixels_per_unit(film.distance());
  const double most = std::max(0.25 * width, std::min(4 * font.size(), 0.5 * width));
  const double length = scale_bar_length(pixels_per_unit, most);
  const ShownLength shown = shown_length(length, unit);
  blocks.push_back(scale_bar_block(style, shown.value, length * pixels_per_unit,
                                   std::string(unit_sign(shown.unit))));
}

Labels::Labels(LabelContent content) : parts_(std::make_unique<Parts>(std::move(content))) {}
Labels::~Labels() = default;
Labels::Labels(Labels&&) noexcept = default;

void Labels::draw(Image& image, std::vector<float>& alpha, const DepthMap& map) const {
  Canvas canvas(image, alpha);
  const Parts& parts = *parts_;
  const double em = parts.font.size();
  if (parts.content.settings.cell) {
    const double line = std::max(cell_line_points * parts.dpi / points_an_inch, 1.0);
    draw_lines(canvas, cell_lines(*parts.content.cell, parts.film), parts.film, map, line);
    for (const EdgeName& edge : edge_names(*parts.content.cell, parts.film, 0.7 * em)) {
      Pen pen(parts.font, parts.line, {edge.middle.x - em / 2, edge.middle.y - em / 2, em, em});
      pen.centered(edge.middle.x, edge.middle.y + 0.27 * em, std::string(1, edge.name));
      pen.draw_on(canvas);
    }
  }
  for (const Placed& label : parts.placed) {
    Pen pen(parts.font, parts.line, label.box);
    label.block->draw(pen, {label.box.x, label.box.y});
    pen.draw_on(canvas);
  }
}

}  // namespace parray::labels
