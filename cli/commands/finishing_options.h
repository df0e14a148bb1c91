#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/input/scene_file/label_settings.h"
#include "cli/input/scene_file/postprocessing.h"
#include "cli/input/scene_file/scene_file.h"
#include "cli/input/view/free_area.h"
#include "cli/output/write_outputs.h"
#include "common/base/error.h"
#include "common/process/command_line.h"
#include "common/scene/settings_fwd.h"

/// The options for what is drawn on a picture after tracing.
namespace parray::commands {

class RenderOptions;

/// Heading of the labels in a command's help.
inline constexpr const char* labels_group = "Labels, not in EXR files (default: the scene's)";

/// The options for labels drawn on a picture, and for its size in print. An option that is absent
/// leaves the scene's value.
class LabelOptions {
 public:
  /// Declares the options. They pass the width in pixels that follows from the size in print to
  /// `render`, and the places that automatic scenes keep free. `image`: the option that must be
  /// given with any of them; null: none. `render` must not move while the command line is parsed.
  /// This object must not move as long as `render` or a copy of it loads scenes.
  void add_to(Command& command, const Option* image, RenderOptions& render);

  /// Returns the first given option that asks for a label: "--legend". Empty: none.
  [[nodiscard]] std::string first_given() const;
  /// Returns draw(labels). If that throws InputError, and the edges of the cell are drawn only
  /// because `file` draws them where they fit, returns draw() of the labels without the cell.
  auto fitting(const SceneFile& file, LabelSettings labels, const auto& draw) const {
    try {
      return draw(labels);
    } catch (const InputError&) {
      if (!labels.cell || settings_.cell || !file.cell_if_it_fits) throw;
    }
    labels.cell = false;
    return draw(labels);
  }
  /// Lays the options over the scene's labels, for a picture of that width. The result has at most
  /// one of `dpi` and `width_mm`. Throws InputError if the size in print contradicts the width, or
  /// if a title is given without a legend.
  [[nodiscard]] LabelSettings over(const LabelSettings& of_scene, std::uint32_t width) const;
  /// Throws InputError for a unit or a size of letters that nothing shows. `drawn`: the result of
  /// over(). `legends`: of the scene; a file states their unit even if it shows no legend.
  void check_used(const LabelSettings& drawn, const std::vector<Legend>& legends) const;

  /// Returns over() the labels of the loaded scene, for a picture with its settings. Leaves out the
  /// cell as fitting() does. Throws InputError as over() and Labels do.
  [[nodiscard]] LabelSettings fitting_in(const SceneFile& file) const;

  /// Returns where labels cover the picture of an automatic scene `file`. Its camera frames the
  /// particles as if there were no labels; the final camera may show them smaller. Throws
  /// InputError as over() and Labels do.
  [[nodiscard]] LabelPlaces places(const SceneFile& file) const;

 private:
  [[nodiscard]] std::optional<std::uint32_t> printed_width() const;

  LabelSettings settings_;
  std::optional<bool> of_scene_;  ///< whether to draw the scene's own labels
};

/// Adds legends and resolution to `outputs`, and the labels as the last step of
/// `outputs.finishing`. `file`: the loaded scene; its `scene` needs only the camera.
/// `settings`: of the picture.
///
/// Throws InputError if a label is impossible, or if an option asks for one and every output is an
/// EXR file.
void add_labels(OutputPaths& outputs, const LabelOptions& options, const SceneFile& file,
                const RenderSettings& settings);

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
