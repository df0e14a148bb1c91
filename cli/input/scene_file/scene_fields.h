#pragma once

#include <array>
#include <string_view>

#include "cli/input/scene_file/label_settings.h"
#include "cli/input/scene_file/postprocessing.h"
#include "common/scene/limits.h"
#include "common/scene/scene.h"
#include "common/scene/setting_rules.h"
#include "common/scene/settings_fields.h"

/// Descriptions of the sections of a scene file. Each member has a key, a rule, and the help text
/// of its option if it has one. They work like the descriptions of settings (settings_fields.h).
namespace parray::input {

// Rules.
struct Flag {};                          ///< a boolean; its option takes no value
struct Vec3Range : NumberRange {};       ///< three numbers
struct LineWidthRange : NumberRange {};  ///< the texts of line_width_from()
struct ShareRange : NumberRange {};      ///< the texts of depth_cue_from()
/// A text that problem_with_label_text() accepts. Empty: none.
struct LabelText {
  std::size_t longest;
};

namespace scene_words {
inline constexpr std::array<std::string_view, 2> projections{"perspective", "orthographic"};
inline constexpr std::array<std::string_view, 3> materials{"diffuse", "metal", "dielectric"};
inline constexpr scene::Words projection{"projection", projections};
inline constexpr scene::Words material{"material type", materials};
}  // namespace scene_words

template <typename F, typename... S>
void camera_fields(F&& f, S&... s) {
  using namespace traits;
  constexpr Vec3Range point{ranges::coordinate};
  f({"look_from", nullptr, required}, point, s.look_from...);
  f({"look_at", nullptr, required}, point, s.look_at...);
  f({"up"}, point, s.up...);
  f({"projection"}, scene_words::projection, s.projection...);
  // Each projection requires one of these two keys and forbids the other.
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

/// Visits the members of a material of type `type`.
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
void postprocessing_fields(F&& f, S&... s) {
  f({"outline",
     "Draw dark lines around spheres and capsules in front of others that are farther away. WIDTH "
     "in pixels or, with --dpi or --width-mm, in points (0.5pt); on: 1/450 of the picture's height",
     0, "on|off|WIDTH"},
    LineWidthRange{drawing_ranges::line_width}, s.outline...);
  f({"depth_cue",
     "Fade distant surfaces into the background. SHARE (0 to 1): the share of the background in "
     "the colour of the farthest surface; on: 0.6",
     0, "on|off|SHARE"},
    ShareRange{drawing_ranges::depth_cue}, s.depth_cue...);
}

template <typename F, typename... S>
void label_fields(F&& f, S&... s) {
  f({"legend", "Show what the particles' colours mean: a colour bar with numbers, or names"},
    Flag{}, s.legend...);
  f({"legend_title",
     "Title of the legend, with the unit if it has one (default: the name of the numbers or "
     "categories)",
     0, "TEXT"},
    LabelText{longest_legend_title}, s.legend_title...);
  f({"scale_bar",
     "Show a bar that stands for a round length, such as 10 nm; with a perspective camera, it "
     "holds at the distance of look_at"},
    Flag{}, s.scale_bar...);
  f({"unit",
     "Unit of lengths, any text; angstrom and um get their signs (default: the unit in the file, "
     "or of its format)",
     0, "UNIT"},
    LabelText{longest_unit}, s.unit...);
  f({"time_stamp", "Show the number of the frame, and its step or time"}, Flag{}, s.time_stamp...);
  f({"cell",
     "Show the outline of the simulation box or crystal cell, behind nearer particles, and the "
     "axes x, y, z"},
    Flag{}, s.cell...);
  f({"text", "Show a text; \\n begins a new line", 0, "TEXT"}, LabelText{longest_label_text},
    s.text...);
  f({"font_size", "Size of letters in print, in points (default: 8)", 0, "PT"},
    drawing_ranges::font_size, s.font_size...);
  f({"width_mm",
     "Width of the picture in print, in millimetres. Without --width, the number of pixels follows "
     "from --dpi, or from 300 pixels per inch",
     0, "MM"},
    drawing_ranges::print_width, s.width_mm...);
  f({"dpi", "Pixels per inch in print, for sizes and the file's metadata", 0, "N"},
    drawing_ranges::dpi, s.dpi...);
}

/// Describes the members of the sections `image` and `render` of a scene file: calls `f`, a visitor
/// as in settings_fields.h, for the settings of a picture and for the boolean `transparent`. The
/// traits `image` and `render` of a member tell its section. The visitor must skip members with
/// neither trait. Callers without a value for `transparent` leave out that argument.
template <typename F, typename S, typename... T>
void image_fields(F&& f, S& settings, T&... transparent) {
  stop_fields(f, settings);
  picture_fields(f, settings);
  f({"transparent", nullptr, traits::image}, Flag{}, transparent...);
}

}  // namespace parray::input
