#include "cli/measure/tradeoff/gnuplot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "cli/output/processor.h"
#include "cli/output/text.h"
#include "common/base/printable.h"

namespace parray::tradeoff {
namespace {

// Okabe and Ito's colours, which people with any colour vision tell apart.
constexpr std::array<SeriesStyle, 7> styles = {{{"#0072B2", 7, 6},
                                                {"#D55E00", 5, 4},
                                                {"#009E73", 9, 8},
                                                {"#CC79A7", 11, 10},
                                                {"#E69F00", 13, 12},
                                                {"#56B4E9", 15, 14},
                                                {"#000000", 3, 2}}};

/// Of the canvas, from its lower end, as gnuplot has it.
std::string screen_y(double y) { return formatted("screen %.4f", 1 - y / Canvas::height); }

}  // namespace

std::string quoted(const std::string& text) {
  std::string safe;
  for (const char c : text) safe += c == '\'' ? std::string("''") : std::string(1, c);
  return "'" + safe + "'";
}

void PlotData::block(const std::string& name) {
  text_ += (text_.empty() ? "\"" : "\n\n\"") + name + "\"\n";
  ++blocks_;
}

void PlotData::line(const std::vector<double>& values, const std::string& label) {
  std::string text;
  for (const double value : values) text += formatted("%.6g ", value);
  text_ += text + (label.empty() ? "" : "\"" + label + "\"") + "\n";
}

SeriesStyle series_style(std::size_t number) { return styles.at(number % styles.size()); }

SeriesStyle family_style(const std::string& family) {
  constexpr std::array names = {"independent",     "sobol",           "independent, adaptive",
                                "sobol, adaptive", "sobol, denoised", "sobol, adaptive, denoised"};
  const auto found = std::find(names.begin(), names.end(), family);
  return series_style(static_cast<std::size_t>(found - names.begin()));
}

LogAxis::LogAxis(const std::vector<double>& values, double before, double after) {
  double low = INFINITY;
  double high = -INFINITY;
  for (const double value : values) {
    if (!(value > 0)) continue;
    low = std::min(low, std::log10(value));
    high = std::max(high, std::log10(value));
  }
  if (!(low <= high)) return;
  const double span = std::max(high - low, 0.1);
  low_ = low - before * span;
  high_ = high + after * span;
}

double LogAxis::part(double value) const { return (std::log10(value) - low_) / (high_ - low_); }

std::string LogAxis::range() const {
  return formatted("[%.6g:%.6g]", std::pow(10, low_), std::pow(10, high_));
}

std::string LogAxis::tics() const {
  std::string text;
  for (int decade = static_cast<int>(std::floor(low_)); decade <= high_; ++decade) {
    for (const double digit : {1.0, 2.0, 5.0}) {
      const double tic = digit * std::pow(10, decade);
      const bool fits = part(tic) >= 0 && part(tic) <= 1;
      if (fits) text += (text.empty() ? "" : ",") + formatted("%.6g", tic);
    }
  }
  return "(" + text + ")";
}

std::string axes_commands(const LogAxis& x, const LogAxis& y) {
  return "set logscale xy\nset xrange " + x.range() + "\nset yrange " + y.range() + "\nset xtics " +
         x.tics() + "\nset ytics " + y.tics() + "\n";
}

std::string name_commands(const std::vector<NamedPoint>& points,
                          const std::vector<NamedPoint>& marked, const LogAxis& x, const LogAxis& y,
                          Place toward) {
  const double width = Canvas::right - Canvas::left;
  const double height = Canvas::bottom - Canvas::top;
  const auto place_of = [&](const NamedPoint& point) -> Place {
    return {width * x.part(point.x), height * (1 - y.part(point.y))};
  };
  constexpr double marker = 11;
  std::vector<Box> markers;
  for (const auto* some : {&points, &marked}) {
    for (const NamedPoint& point : *some) markers.push_back({place_of(point), marker, marker});
  }
  std::vector<Named> names;
  for (const NamedPoint& point : points) {
    names.push_back({place_of(point), Canvas::text_width(point.name), Canvas::font + 2});
  }
  const Box area{{width / 2, height / 2}, width - 6, height - 6};
  const auto places = place_names(names, markers, area, toward);
  std::string commands;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!places[i]) continue;
    const Named& name = names[i];
    const Place at = *places[i];
    commands +=
        "set label " + quoted(points[i].name) +
        formatted(" at graph %.4f, graph %.4f center front\n", at.x / width, 1 - at.y / height);
    // From the nearest point of the text's box.
    const Place end{std::clamp(name.at.x, at.x - name.width / 2, at.x + name.width / 2),
                    std::clamp(name.at.y, at.y - name.height / 2, at.y + name.height / 2)};
    if (std::hypot(end.x - name.at.x, end.y - name.at.y) < 10) continue;
    commands +=
        formatted("set arrow from graph %.4f, graph %.4f ", end.x / width, 1 - end.y / height) +
        formatted("to graph %.4f, graph %.4f nohead lw 0.5", name.at.x / width,
                  1 - name.at.y / height) +
        " lc rgb '#888888'\n";
  }
  return commands;
}

std::string caption_of(const Findings& findings) {
  const std::string name = std::filesystem::path(findings.scene_file).stem().string();
  return printable(name, 40) + ", " + counted(findings.spheres, "sphere") + ", " +
         std::to_string(findings.base.width) + " x " + std::to_string(findings.base.height) +
         " pixels; " + short_processor(findings.occasion.processor).substr(0, 40) + ", " +
         counted(static_cast<std::uint64_t>(findings.timing.threads), "thread") + ", " +
         findings.occasion.isa + "; ParRay " PARRAY_VERSION ", " + findings.occasion.date;
}

std::string script_of(const Plot& plot, const std::string& caption) {
  const std::string pixels = formatted("size %.0f,%.0f", Canvas::width, Canvas::height);
  const std::string inches =
      formatted("size %.4fin,%.4fin", Canvas::width / 96, Canvas::height / 96);
  const std::string font = " font 'DejaVu Sans,";
  const auto terminal = [&](const std::string& kind, const std::string& size, double points,
                            const std::string& more) {
    return "set terminal " + kind + " noenhanced " + size + font + formatted("%g'", points) + more +
           "\n";
  };
  const auto output = [&](const char* kind) {
    return "set output " + quoted(plot.name + "." + kind) + "\n";
  };
  return "# gnuplot " + plot.name + ".gp draws " + plot.name + ".svg, .pdf and .png of " +
         plot.name + ".dat.\nif (ARGC > 0) cd ARG1\n" +
         terminal("svg", pixels, Canvas::font, " background rgb 'white'") + output("svg") +
         "data = " + quoted(plot.name + ".dat") + "\n" +
         formatted("set lmargin at screen %.4f\n", Canvas::left / Canvas::width) +
         formatted("set rmargin at screen %.4f\n", Canvas::right / Canvas::width) +
         "set tmargin at " + screen_y(Canvas::top) + "\nset bmargin at " + screen_y(plot.bottom) +
         "\nset label " + quoted(caption) + " at screen 0.5, " + screen_y(Canvas::height - 12) +
         " center\nset key at screen 0.5, " + screen_y(plot.bottom + 52) +
         " center top horizontal maxcols 3 Left reverse samplen 2\nset grid lt 1 lw 0.5 lc rgb "
         "'#dddddd'\n" +
         plot.commands + "\n" +
         terminal("pdfcairo", inches, Canvas::font * 72 / 96, " fontscale 0.75") + output("pdf") +
         "replot\n" + terminal("pngcairo", pixels, Canvas::font * 72 / 96, "") + output("png") +
         "replot\nset output\n";
}

}  // namespace parray::tradeoff
