#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/scene/limits.h"

namespace parray::input {

namespace drawing_ranges {
inline constexpr NumberRange font_size{1, 200};     ///< points
inline constexpr NumberRange dpi{10, 10000};        ///< pixels per inch
inline constexpr NumberRange print_width{1, 5000};  ///< millimetres
}  // namespace drawing_ranges

/// The labels on a picture, and the size of the picture in print.
struct LabelSettings {
  bool legend = false;  ///< show the meaning of the particles' colours
  /// UTF-8; replaces the title and the unit of legends; empty: the name of the numbers or
  /// categories
  std::string legend_title{};
  bool scale_bar = false;   ///< show a bar that stands for a round length, such as 10 nm
  bool time_stamp = false;  ///< show frame and time of the particles
  bool cell = false;   ///< show the outline of the particles' box or crystal cell, and the axes
  std::string text{};  ///< UTF-8, may have several lines; empty: none
  std::string
      unit{};  ///< unit of lengths: "angstrom" or any other text; empty: the unit of the file
  std::optional<double> font_size{};  ///< in drawing_ranges::font_size; not given: usual_font_size
  /// Pixels per inch, in drawing_ranges::dpi, and width in print, in drawing_ranges::print_width.
  /// Options may give both to determine the width in pixels. LabelOptions (cli/commands) then
  /// removes width_mm, so that labels.h gets at most one of them. None given: see dots_per_inch()
  /// in labels.h.
  std::optional<double> dpi{};
  std::optional<double> width_mm{};

  /// Returns whether the picture has any label.
  [[nodiscard]] bool any() const {
    return legend || scale_bar || time_stamp || cell || !text.empty();
  }
  friend bool operator==(const LabelSettings&, const LabelSettings&) = default;
};

inline constexpr double usual_font_size = 8;  ///< points
/// Pixels per inch that turn width_mm into a width in pixels, if neither that width nor dpi is
/// given.
inline constexpr double usual_dpi = 300;
inline constexpr std::size_t longest_label_text = 4000;   ///< bytes
inline constexpr std::size_t longest_unit = 40;           ///< bytes
inline constexpr std::size_t longest_legend_title = 200;  ///< bytes

/// Returns why a text cannot be a label or a unit, with the remedy. Returns "" for texts of 1 to
/// `longest` bytes.
inline std::string problem_with_label_text(std::string_view text, std::size_t longest) {
  if (text.empty()) return "the text is empty: write the text to be shown";
  if (text.size() <= longest) return "";
  return "the text has " + std::to_string(text.size()) + " bytes, more than " +
         std::to_string(longest) + ": shorten it";
}

/// Returns the sign of a unit: "\u00c5" for "angstrom", "\u00b5m" for "um". Returns other units
/// unchanged.
inline std::string_view unit_sign(std::string_view unit) {
  if (unit == "angstrom") return "\u00c5";
  return unit == "um" ? "\u00b5m" : unit;
}

}  // namespace parray::input
