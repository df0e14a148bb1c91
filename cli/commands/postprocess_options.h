#pragma once

#include <memory>
#include <string>

#include "cli/input/scene_file/postprocessing.h"
#include "cli/input/scene_file/scene_file.h"
#include "cli/output/write_outputs.h"
#include "common/process/command_line.h"
#include "common/scene/settings_fwd.h"

namespace parray::commands {

/// Options for postprocessing. Part of OutputOptions. An option that is absent leaves the value of
/// the scene, or of the style of its automatic scene.
class PostprocessOptions {
 public:
  /// Declares the options, for commands that have the scene of the picture that they write.
  /// `image`: the option that must be given with any of them; null: none. The object must not move
  /// while the command line is parsed.
  void add_to(Command& command, const Option* image);
  /// Returns the scene's postprocessing, replaced by the options that are given.
  [[nodiscard]] Postprocessing over(const Postprocessing& of_scene) const {
    return given_.over(of_scene);
  }
  /// Returns the first given option that asks for a step: "--outline". Empty: none.
  [[nodiscard]] std::string first_given() const;

 private:
  PostprocessingSection given_;
};

/// Adds depth cue and outline before the other steps of `outputs.finishing`. Call add_labels()
/// before: it sets the resolution in print, which outlines in points need. `file`: the loaded
/// scene; its shapes are in `scene`. `settings`: of the picture.
///
/// Throws InputError if a step is impossible, or if an option asks for one and every output is an
/// EXR file.
void add_postprocessing(OutputPaths& outputs, const PostprocessOptions& options,
                        const SceneFile& file, const std::shared_ptr<const Scene>& scene,
                        const RenderSettings& settings);

/// Adds the colour of the background, linear RGB, as the first step of `outputs.finishing`. The
/// picture must be transparent. Throws InputError for an EXR picture.
void add_background(OutputPaths& outputs, const Vec3d& color);

/// If `postprocessing` asks for outlines or a depth cue, or `labels` is true, warns on stderr that
/// the farm draws none of them on the picture of the job `name`. `remedy`: how to get them.
void warn_of_missing_postprocessing(const Postprocessing& postprocessing, bool labels,
                                    const std::string& name, const std::string& remedy);

}  // namespace parray::commands
