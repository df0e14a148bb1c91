#include "cli/commands/finish_options.h"

#include <algorithm>
#include <iostream>

#include "cli/commands/setting_options.h"
#include "cli/output/postprocess/depth_cue.h"
#include "cli/output/postprocess/outline.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/base/printable.h"

namespace parray::commands {
namespace {

/// Of the outline, in pixels; 0: none.
double pixels_of(const LineWidth& width, std::uint32_t height, double dpi) {
  constexpr double lines_in_height = 450;
  constexpr double points_an_inch = 72;
  switch (width.unit) {
    case LineWidth::Unit::automatic:
      return std::max(1.0, height / lines_in_height);
    case LineWidth::Unit::pixels:
      return width.value;
    case LineWidth::Unit::points:
      if (dpi == 0) {
        throw InputError("outline of " + number_text(width.value) +
                         "pt: how many pixels that are says the size in print: add --dpi or "
                         "--width-mm, or give pixels");
      }
      return width.value / points_an_inch * dpi;
    case LineWidth::Unit::none:
      break;
  }
  return 0;
}

/// What the steps share.
struct Seen {
  std::shared_ptr<const Scene> scene;
  std::uint32_t scenery;
  double depth_cue;

  [[nodiscard]] SeenSpheres spheres(const ShownPicture& picture) const {
    return {picture.floats("Z"), picture.wholes("sphere"), scenery};
  }
  [[nodiscard]] DepthFade fade(const ShownPicture& picture) const {
    if (depth_cue == 0) return {};
    return {spheres(picture), picture.image.width, depth_cue};
  }
};

FinishingStep depth_cue_step(const Seen& seen) {
  return {"depth-cue", {Aov::depth, Aov::sphere}, [seen](ShownPicture& picture) {
            const SeenSpheres spheres = seen.spheres(picture);
            fade(picture.image, picture.alpha, spheres, seen.fade(picture),
                 background_color(picture.image, spheres, *seen.scene));
          }};
}

FinishingStep outline_step(const Seen& seen, double width) {
  Aovs needs{Aov::sphere};
  if (seen.depth_cue > 0) needs.insert(Aov::depth);
  return {"outline", needs, [seen, width](ShownPicture& picture) {
            const Image& image = picture.image;
            draw_ink(picture.image, picture.alpha,
                     outline_of(*seen.scene, image.width, image.height, seen.spheres(picture),
                                width, seen.fade(picture), usable_cpus()));
          }};
}

}  // namespace

void FinishOptions::add_to(Command& command, const Option& image) {
  finish_fields(
      [&](const Setting& setting, const auto& rule, auto& value) {
        add_setting(command, setting, rule, value).group(finish_group).needs(image);
      },
      given_);
}

std::string FinishOptions::first_given() const {
  if (given_.outline && given_.outline->unit != LineWidth::Unit::none) return "--outline";
  return given_.depth_cue && *given_.depth_cue > 0 ? "--depth-cue" : "";
}

void add_finishing(OutputPaths& outputs, const FinishOptions& options, const SceneFile& file,
                   const std::shared_ptr<const Scene>& scene, const RenderSettings& settings) {
  const Finish finish = options.over(file.finish);
  const double width = pixels_of(finish.outline, height_of(settings), outputs.dpi);
  if (width > 0 && scene->camera.aperture > 0) {
    throw InputError(
        "outline: the camera's lens blurs what it would be drawn around: set aperture to 0, or add "
        "--outline off");
  }
  if (!outputs.has_png()) {
    const std::string given = options.first_given();
    if (given.empty()) return;
    throw InputError(
        given +
        ": postprocessing needs a PNG picture, because an EXR file keeps what was traced: write a "
        ".png");
  }
  const Seen seen{scene, file.scenery, finish.depth_cue};
  Finishing steps;
  if (finish.depth_cue > 0) steps.push_back(depth_cue_step(seen));
  if (width > 0) steps.push_back(outline_step(seen, width));
  outputs.finishing.insert(outputs.finishing.begin(), steps.begin(), steps.end());
}

void say_unfinished(const Finish& finish, const std::string& name, const std::string& remedy) {
  if (finish == Finish{}) return;
  std::cerr << "parray: " + name +
                   ": outlines and depth cues need the scene, so a fetched picture has none: " +
                   remedy + "\n";
}

}  // namespace parray::commands
