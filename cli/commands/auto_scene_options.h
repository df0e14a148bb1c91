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
  /// Notes where to read, when the scene is made, whether the picture must contain the whole cell
  /// of the particles (the periodic box of a simulation). `wanted` must not move until then.
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

  /// Makes transparent() return this value, from a recipe, instead of the scene's.
  void follow(bool transparent) { followed_ = transparent; }

  /// Returns whether the background is transparent. `of_scene`: the scene's value.
  [[nodiscard]] bool transparent(bool of_scene) const;

 private:
  std::optional<bool> transparent_;
  std::optional<bool> followed_;
};

}  // namespace parray::commands
