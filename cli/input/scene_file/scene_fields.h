#pragma once

#include <array>
#include <string_view>

#include "cli/input/scene_file/finish.h"
#include "cli/input/scene_file/label_settings.h"
#include "common/scene/scene.h"
#include "common/scene/scene_ranges.h"
#include "common/scene/setting_rules.h"

/// The descriptions of a scene file's sections: of each member its key, its rule, and the help of
/// its option if it has one. They are made like those of settings.
namespace parray::input {

// Rules.
struct Flag {};                          ///< a boolean; its option has no value
struct Vec3Range : NumberRange {};       ///< three numbers
struct LineWidthRange : NumberRange {};  ///< as line_width_from() has it
struct ShareRange : NumberRange {};      ///< as depth_cue_from() has it
/// As problem_with_label_text() has it; empty: none.
struct LabelText {
  std::size_t longest;
};

namespace scene_words {
inline constexpr std::array<std::string_view, 2> projections{"perspective", "orthographic"};
inline constexpr std::array<std::string_view, 3> materials{"diffuse", "metal", "dielectric"};
inline constexpr Words projection{"projection", projections};
inline constexpr Words material{"material type", materials};
}  // namespace scene_words

template <typename F, typename... S>
void camera_fields(F&& f, S&... s) {
  using namespace traits;
  constexpr Vec3Range point{ranges::coordinate};
  f({"look_from", nullptr, required}, point, s.look_from...);
  f({"look_at", nullptr, required}, point, s.look_at...);
  f({"up"}, point, s.up...);
  f({"projection"}, scene_words::projection, s.projection...);
  // Each projection requires one of these and refuses the other.
  f({"vfov", nullptr, if_set}, ranges::vfov, s.vfov...);
  f({"view_height", nullptr, if_set}, ranges::length, s.view_height...);
  f({"aperture"}, ranges::aperture, s.aperture...);
  f({"focus_distance"}, ranges::length, s.focus_distance...);
}

template <typename F, typename... S>
void sky_fields(F&& f, S&... s) {
  f({"horizon"}, Vec3Range{ranges::radiance}, s.horizon...);
  f({"zenith"}, Vec3Range{ranges::radiance}, s.zenith...);
}

/// Of a material of that type.
template <typename F, typename... S>
void material_fields(F&& f, MaterialType type, S&... s) {
  using namespace traits;
  f({"type", nullptr, required}, scene_words::material, s.type...);
  if (type == MaterialType::dielectric) {
    f({"ior", nullptr, required}, ranges::ior, s.ior...);
  } else {
    f({"albedo", nullptr, required}, Vec3Range{ranges::unit_interval}, s.albedo...);
  }
  if (type == MaterialType::metal) f({"fuzz"}, ranges::unit_interval, s.fuzz...);
}

template <typename F, typename... S>
void finish_fields(F&& f, S&... s) {
  f({"outline",
     "Dark lines where spheres end before others that are farther away, so many pixels or, with "
     "--dpi, points (0.5pt) wide; on: a 450th of the picture's height",
     0, "on|off|WIDTH"},
    LineWidthRange{drawing_ranges::line_width}, s.outline...);
  f({"depth_cue", "What is far fades into the background, the farthest by that share; on: 0.6", 0,
     "on|off|SHARE"},
    ShareRange{drawing_ranges::depth_cue}, s.depth_cue...);
}

template <typename F, typename... S>
void label_fields(F&& f, S&... s) {
  f({"legend", "What the particles' colours mean: a bar of colours with numbers, or names"}, Flag{},
    s.legend...);
  f({"scale_bar",
     "A round length; with a perspective camera that of things as far away as look_at"},
    Flag{}, s.scale_bar...);
  f({"unit",
     "Unit of lengths, as it is to be written; angstrom and um are known (default: that of the "
     "file's format)",
     0, "UNIT"},
    LabelText{longest_unit}, s.unit...);
  f({"time_stamp", "Which frame it is, and at which step or time"}, Flag{}, s.time_stamp...);
  f({"cell",
     "Outline of the simulation's box or the crystal's cell, hidden behind what is nearer, and the "
     "axes x, y, z"},
    Flag{}, s.cell...);
  f({"text", "A text; \\n begins a new line", 0, "TEXT"}, LabelText{longest_label_text}, s.text...);
  f({"font_size", "Size of letters in print, in points (default: 8)", 0, "PT"},
    drawing_ranges::font_size, s.font_size...);
  f({"width_mm",
     "Width of the picture in print: without --width it has as many pixels as --dpi says "
     "(default: 300)",
     0, "MM"},
    drawing_ranges::print_width, s.width_mm...);
  f({"dpi", "Pixels an inch in print, for sizes and the file's metadata", 0, "N"},
    drawing_ranges::dpi, s.dpi...);
}

}  // namespace parray::input
