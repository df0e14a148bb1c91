#pragma once

#include <memory>
#include <string>

#include "cli/commands/finishing_options.h"
#include "cli/input/scene_file/scene_file.h"
#include "cli/output/write_outputs.h"
#include "common/scene/scene.h"
#include "common/scene/settings_fwd.h"

namespace parray::commands {

/// Returns what is drawn on 8-bit pictures of a scene, as text for JobHead::drawing: labels with
/// the facts that they show, postprocessing, and the colour of the background. Empty: nothing.
/// `file`: the loaded scene, of which only the camera is left. `settings`: of the picture. Throws
/// InputError if a label or a step is impossible, or if a legend to draw has too many entries.
std::string drawing_text(const LabelOptions& labels, const PostprocessOptions& postprocessing,
                         const SceneFile& file, const std::shared_ptr<const Scene>& scene,
                         const RenderSettings& settings);

/// Adds what drawing_text() has described to the outputs of a fetched picture, whose file must not
/// be an EXR file. Does nothing if `drawing` is empty. Throws RunError if the text is damaged.
void add_drawing(OutputPaths& outputs, const std::string& drawing,
                 const std::shared_ptr<const Scene>& scene, const RenderSettings& settings);

}  // namespace parray::commands
