#pragma once

#include <memory>
#include <string>

#include "cli/input/scene_file/finish.h"
#include "cli/input/scene_file/scene_file.h"
#include "cli/output/write_outputs.h"
#include "common/process/command_line.h"
#include "common/scene/settings.h"

namespace parray::commands {

/// What is done to a picture before it is looked at. Part of OutputOptions. What is not given stays
/// as the scene, or the style of its portrait, has it.
class FinishOptions {
 public:
  /// For commands that have the scene of the picture that they write, as `image` says. They must
  /// stay where they are while the command line is parsed.
  void add_to(Command& command, const Option& image);
  [[nodiscard]] Finish over(const Finish& of_scene) const { return given_.over(of_scene); }
  /// The first of those given that ask for something to be done, as "--outline"; empty: none.
  [[nodiscard]] std::string first_given() const;

 private:
  FinishSection given_;
};

/// Puts what is done to the picture before the other steps of `outputs.finishing`: depth cue, then
/// outline. `file` is what was loaded, its spheres in `scene`; `settings` are those of the picture.
/// After add_labels(), which knows how large it is printed.
///
/// Throws InputError where a step is impossible, or asked for by an option and no output is PNG.
void add_finishing(OutputPaths& outputs, const FinishOptions& options, const SceneFile& file,
                   const std::shared_ptr<const Scene>& scene, const RenderSettings& settings);

/// Says on stderr of the job `name` that its picture comes without them, if there are such steps:
/// they need the scene. `remedy`: how to have them.
void say_unfinished(const Finish& finish, const std::string& name, const std::string& remedy);

}  // namespace parray::commands
