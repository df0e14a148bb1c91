#include "cli/commands/finish_options.h"

#include "cli/commands/options.h"
#include "common/base/error.h"

namespace parray {
void FinishOptions::add_to(Command& command, const Option& image) {
  command
      .option(
          "--outline", [this](const std::string& text) { outline_ = line_width_from(text); },
          "Dark lines where spheres end before others that are farther away, so many pixels or, "
          "with --dpi, points (0.5pt) wide; on: a 450th of the picture's height")
      .type_name("on|off|WIDTH")
      .group(finish_group)
      .needs(image);
  command
      .option(
          "--depth-cue", [this](const std::string& text) { depth_cue_ = depth_cue_from(text); },
          "What is far fades into the background, the farthest by that share; on: 0.6")
      .type_name("on|off|SHARE")
      .group(finish_group)
      .needs(image);
}

Finish FinishOptions::over(Finish of_scene) const {
  of_scene.outline = outline_.value_or(of_scene.outline);
  of_scene.depth_cue = depth_cue_.value_or(of_scene.depth_cue);
  return of_scene;
}

std::string FinishOptions::first_given() const {
  if (outline_ && outline_->unit != LineWidth::Unit::none) return "--outline";
  return depth_cue_ && *depth_cue_ > 0 ? "--depth-cue" : "";
}

}  // namespace parray
