#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/input/view/surroundings.h"
#include "common/process/command_line.h"

namespace parray::commands {

/// Returns the names of views and axes, as words of an option.
std::vector<std::string> view_words();

/// View, style and projection of an automatic scene. Part of RenderOptions.
class AutoSceneOptions {
 public:
  /// Declares the options. The object must not move while the command line is parsed.
  void add_to(Command& command);
  /// Throws InputError that names the options given: the scene `file` is not a particle file.
  void check_unused(const std::string& file) const;
  [[nodiscard]] Viewing viewing() const;

  [[nodiscard]] bool has_view() const { return view_.has_value(); }
  void look_from(View view) { view_ = view; }
  /// The picture will contain the particles' cell if `wanted` is true when the scene is made.
  /// `wanted` must not move.
  void frame_cell(const bool& wanted) { whole_cell_ = &wanted; }

 private:
  std::optional<View> view_;
  std::optional<Style> style_;
  std::optional<Projection> projection_;
  const bool* whole_cell_ = nullptr;
};

/// Options for the picture of any scene. An option that is absent leaves the scene's value. Part of
/// RenderOptions.
class ViewOptions {
 public:
  void add_to(Command& command);

  /// Takes the value from a recipe instead of from the scene.
  void follow(bool transparent) { followed_ = transparent; }

  /// Returns whether the background is transparent. `of_scene`: the scene's value.
  [[nodiscard]] bool transparent(bool of_scene) const;

 private:
  std::optional<bool> transparent_;
  std::optional<bool> followed_;
};

}  // namespace parray::commands
