#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/scene/number_range.h"

namespace parray::input {

namespace drawing_ranges {
inline constexpr NumberRange font_size{1, 200};     ///< points
inline constexpr NumberRange dpi{10, 10000};        ///< pixels an inch
inline constexpr NumberRange print_width{1, 5000};  ///< millimetres
}  // namespace drawing_ranges

/// What is written on a picture once it is traced, and how large it is to be printed.
struct LabelSettings {
  bool legend = false;      ///< what the particles' colours mean
  bool scale_bar = false;   ///< a round length
  bool time_stamp = false;  ///< frame and time of the particles
  bool cell = false;        ///< outline of the particles' box or crystal cell, and the axes
  std::string text{};       ///< UTF-8, lines; empty: none
  std::string unit{};       ///< of lengths: "angstrom" or as it is to be written; empty: the file's
  std::optional<double> font_size{};  ///< in drawing_ranges::font_size; usual_font_size
  std::optional<double> dpi{};        ///< in drawing_ranges::dpi
  std::optional<double> width_mm{};   ///< in drawing_ranges::print_width

  /// Something is to be drawn.
  [[nodiscard]] bool any() const {
    return legend || scale_bar || time_stamp || cell || !text.empty();
  }
  friend bool operator==(const LabelSettings&, const LabelSettings&) = default;
};

inline constexpr double usual_font_size = 8;  ///< points
/// Where a width is given and no resolution.
inline constexpr double usual_dpi = 300;
inline constexpr std::size_t longest_label_text = 4000;  ///< bytes
inline constexpr std::size_t longest_unit = 40;

/// Why it cannot be a label's text or a unit, with the remedy; empty: it can.
std::string problem_with_label_text(std::string_view text, std::size_t longest);

/// As lengths are written: "angstrom" is \u00c5, "um" is \u00b5m; others stay as they are.
std::string_view unit_sign(std::string_view unit);

/// The unit of lengths in files of a format (ParticleFacts::format): "angstrom", or empty, not
/// known.
std::string_view length_unit_of(std::string_view format);

}  // namespace parray::input
