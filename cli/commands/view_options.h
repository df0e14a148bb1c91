#pragma once

#include <optional>

#include "common/process/command_line.h"

namespace parray::commands {

/// Options about how a scene is looked at, wherever one is rendered. What is not given stays as the
/// scene has it. Part of RenderOptions.
class ViewOptions {
 public:
  void add_to(Command& command);

  /// Takes this from a recipe instead of from the scene.
  void follow(bool transparent) { followed_ = transparent; }

  /// Whether the background is left out of the picture, where the scene says `of_scene`.
  [[nodiscard]] bool transparent(bool of_scene) const;

 private:
  std::optional<bool> transparent_;
  std::optional<bool> followed_;
};

}  // namespace parray::commands
