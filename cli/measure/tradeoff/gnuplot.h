#pragma once

#include <string>
#include <vector>

#include "cli/measure/tradeoff/findings.h"
#include "cli/measure/tradeoff/label_places.h"

/// How plots look: one font, one size, markers and colours that anybody tells apart.
namespace parray::tradeoff {

/// Blocks of lines, which gnuplot numbers from 0.
class PlotData {
 public:
  /// `name` is what `columnheader(1)` reads.
  void block(const std::string& name);
  void line(const std::vector<double>& values, const std::string& label = "");
  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] std::size_t blocks() const { return blocks_; }

 private:
  std::string text_;
  std::size_t blocks_ = 0;
};

/// Of a series: `full` and `open` are the same shape.
struct SeriesStyle {
  const char* colour;
  int full;
  int open;
};
/// By number; after the last the first.
SeriesStyle series_style(std::size_t number);
/// Of a family (findings.h), the same in all plots.
SeriesStyle family_style(const std::string& family);

/// Of a plot, in pixels of the SVG; the axes lie inside of the margins.
struct Canvas {
  static constexpr double width = 900;
  static constexpr double height = 600;
  static constexpr double left = 80;
  static constexpr double right = 885;
  static constexpr double top = 15;
  static constexpr double bottom = 440;
  static constexpr double font = 12;
  /// About, of text.
  static double text_width(const std::string& text) {
    return 0.56 * font * static_cast<double>(text.size());
  }
};

/// An axis of logarithms that holds values > 0, with some room at its ends.
class LogAxis {
 public:
  /// `before` and `after`: of the room, relative to the values' own.
  LogAxis(const std::vector<double>& values, double before, double after);
  [[nodiscard]] double part(double value) const;  ///< 0 at the low end, 1 at the high one
  [[nodiscard]] std::string range() const;        ///< "[1:10]"
  [[nodiscard]] std::string tics() const;         ///< "(1,2,5,10)"

 private:
  double low_ = 0;
  double high_ = 1;
};

/// A point and its name.
struct NamedPoint {
  double x = 0;
  double y = 0;
  std::string name;
};
/// Commands for both axes.
std::string axes_commands(const LogAxis& x, const LogAxis& y);
/// Commands that write names beside points, with lines to those that are apart. `marked`: no name
/// covers these, either. `toward`: in pixels, y downwards.
std::string name_commands(const std::vector<NamedPoint>& points,
                          const std::vector<NamedPoint>& marked, const LogAxis& x, const LogAxis& y,
                          Place toward);

struct Plot {
  std::string name;
  std::string data;
  std::string commands;  ///< from the settings of the axes to `plot`
  double bottom = Canvas::bottom;
};

/// A string of gnuplot's.
std::string quoted(const std::string& text);

/// What was measured, on what, when, in one line.
std::string caption_of(const Findings& findings);

/// NAME.gp, which draws NAME.svg, .pdf and .png.
std::string script_of(const Plot& plot, const std::string& caption);

}  // namespace parray::tradeoff
