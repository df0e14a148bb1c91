#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/input/scene_file/label_settings.h"
#include "cli/input/scene_file/scene_file.h"
#include "cli/output/write_outputs.h"
#include "common/process/command_line.h"
#include "common/scene/settings.h"

namespace parray::commands {

class RenderOptions;

/// Heading, in a command's help, of what is written on a picture.
inline constexpr const char* labels_group = "Labels, drawn on a PNG picture (default: the scene's)";

/// What is written on a picture after it was traced, and its size in print. What is not given stays
/// as the scene has it.
class LabelOptions {
 public:
  /// `render` learns the width that the size in print means. Both must stay where they are while
  /// the command line is parsed.
  void add_to(Command& command, const Option& image, RenderOptions& render);

  /// The first of those given that ask for something to be drawn, as "--legend"; empty: none.
  [[nodiscard]] std::string first_given() const;
  /// Laid over those of the scene, for a picture of that width. At most one of `dpi` and `width_mm`
  /// is left. Throws InputError where the size in print contradicts the width.
  [[nodiscard]] LabelSettings over(const LabelSettings& of_scene, std::uint32_t width) const;

 private:
  [[nodiscard]] std::optional<std::uint32_t> printed_width() const;

  LabelSettings settings_;
  std::optional<bool> of_scene_;  ///< whether the labels that the scene asks for are drawn
};

/// What a picture of a scene is finished with, and what its file and report say of it: legends,
/// resolution, and, as the last of `outputs.finishing`, labels. `file` is what was loaded; its
/// camera is looked at, not its spheres. `settings` are those of the picture.
///
/// Throws InputError where a label is impossible, or no output is PNG that it could be drawn on.
void add_labels(OutputPaths& outputs, const LabelOptions& options, const SceneFile& file,
                const RenderSettings& settings);

}  // namespace parray::commands
