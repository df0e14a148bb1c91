#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/input/scene_file/scene_file.h"
#include "cli/input/view/surroundings.h"
#include "common/process/command_line.h"

namespace parray::commands {

class ParticleOptions;

/// Returns the names of views and axes, as words of an option.
std::vector<std::string> view_words();

/// View, style, camera and background of an automatic scene. Part of RenderOptions.
class AutoSceneOptions {
 public:
  /// Declares the options. The object must not move while the command line is parsed. --style also
  /// sets the style of `particles`.
  void add_to(Command& command, ParticleOptions& particles);
  /// Declares --background, for commands that make pictures.
  void add_background_to(Command& command);
  /// Throws InputError if any of the options is given: the scene `file` is not a particle file.
  void check_unused(const std::string& file) const;
  /// Throws InputError if options exclude each other.
  [[nodiscard]] Viewing viewing() const;
  /// Returns the colour of the background in linear RGB. Not given: that of the style.
  [[nodiscard]] const std::optional<Vec3d>& background() const { return background_; }

  [[nodiscard]] bool has_view() const { return view_.has_value(); }
  void look_from(View view) { view_ = view; }
  /// Parses the name of a view, and notes whether it is the name of an axis. Throws InputError.
  View named_view(std::string_view name);
  /// Notes where to read, when the scene is made, whether the picture must contain the whole cell
  /// of the particles (the periodic box of a simulation). `wanted` must not move until then.
  void frame_cell(const bool& wanted) { whole_cell_ = &wanted; }
  /// Sets the places of labels, which the particles of the scene will not meet.
  void keep_free(std::function<LabelPlaces(const SceneFile&)> labels) {
    labels_ = std::move(labels);
  }

 private:
  void add_style_to(Command& command, ParticleOptions& particles);
  void add_camera_to(Command& command);

  std::optional<View> view_;
  bool names_axis_ = false;  ///< a view is named by an axis
  std::optional<Style> style_;
  bool styles_particles_ = false;
  std::optional<Projection> projection_;
  Turning turning_;
  std::optional<double> zoom_;
  std::optional<Vec3d> background_;
  std::function<LabelPlaces(const SceneFile&)> labels_;
  const bool* whole_cell_ = nullptr;
};

/// Options for the picture of any scene. An option that is absent leaves the scene's value. Part of
/// RenderOptions.
class ViewOptions {
 public:
  void add_to(Command& command);

  /// Makes transparent() return this value, from a recipe, instead of the scene's.
  void follow(bool transparent) { followed_ = transparent; }

  /// Returns whether the background is transparent. `of_scene`: the scene's value.
  [[nodiscard]] bool transparent(bool of_scene) const;

 private:
  std::optional<bool> transparent_;
  std::optional<bool> followed_;
};

}  // namespace parray::commands
