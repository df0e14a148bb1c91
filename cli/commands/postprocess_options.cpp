#include "cli/commands/postprocess_options.h"

#include <algorithm>
#include <iostream>
#include <limits>
#include <span>

#include "cli/commands/setting_options.h"
#include "cli/output/picture/image_file.h"
#include "cli/output/picture/transparency.h"
#include "cli/output/postprocess/outline.h"
#include "cli/output/recipe.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/base/printable.h"

namespace parray::commands {
namespace {

/// Returns the width of the outline in pixels. 0: no outline. `height`: of the picture, in pixels.
/// `dpi`: pixels per inch, or 0 if unknown. Throws InputError for a width in points without `dpi`.
double pixels_of(const LineWidth& width, std::uint32_t height, double dpi) {
  constexpr double lines_in_height = 450;
  constexpr double points_an_inch = 72;
  switch (width.unit) {
    case LineWidth::Unit::automatic: return std::max(1.0, height / lines_in_height);
    case LineWidth::Unit::pixels: return width.value;
    case LineWidth::Unit::points:
      if (dpi == 0) {
        throw InputError("outline of " + number_text(width.value) +
                         "pt: points need the picture's size in print: add --dpi or --width-mm, or "
                         "give the outline's width in pixels, such as 2");
      }
      return width.value / points_an_inch * dpi;
    case LineWidth::Unit::none: break;
  }
  return 0;
}

/// Returns the depth of the back of the farthest shape that is no scenery.
double depth_of_farthest(const Scene& scene, std::uint32_t scenery) {
  const Vec3d forward = normalize(scene.camera.look_at - scene.camera.look_from);
  double farthest = 0;
  const auto add = [&](const Vec3d& point, double radius) {
    farthest = std::max(farthest, dot(point - scene.camera.look_from, forward) + radius);
  };
  for (const Sphere& sphere : std::span(scene.spheres).subspan(scenery)) {
    add(sphere.center, sphere.radius);
  }
  for (const Capsule& capsule : scene.capsules) {
    add(capsule.from, capsule.radius);
    add(capsule.to, capsule.radius);
  }
  return farthest;
}

/// The data that both steps need.
struct Seen {
  std::shared_ptr<const Scene> scene;
  std::uint32_t scenery;
  double depth_cue;
  NumberBounds depths;                                        ///< of all frames of a film
  double farthest = std::numeric_limits<double>::infinity();  ///< see SeenSpheres

  [[nodiscard]] SeenSpheres spheres(const ShownPicture& picture) const {
    return {picture.floats("Z"), picture.wholes("sphere"), scenery, farthest};
  }
  [[nodiscard]] DepthFade fade(const ShownPicture& picture) const {
    if (depth_cue == 0) return {};
    if (!depths.empty()) return {depths.low, depths.high, depth_cue};
    return {spheres(picture), picture.image.width, depth_cue};
  }
};

PostprocessStep depth_cue_step(const Seen& seen) {
  return {"depth-cue", {Aov::depth, Aov::sphere}, [seen](ShownPicture& picture) {
            const SeenSpheres spheres = seen.spheres(picture);
            fade(picture.image, picture.alpha, spheres, seen.fade(picture),
                 background_color(picture.image, spheres, *seen.scene));
          }};
}

PostprocessStep outline_step(const Seen& seen, double width) {
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

void PostprocessOptions::add_to(Command& command, const Option* image) {
  postprocessing_fields(
      [&](const Setting& setting, const auto& rule, auto& value) {
        Option option = add_setting(command, setting, rule, value);
        option.group(postprocess_group);
        if (image != nullptr) option.needs(*image);
        if (rarely_needed(setting)) option.special();
      },
      given_);
}

std::string PostprocessOptions::first_given() const {
  if (given_.outline && given_.outline->unit != LineWidth::Unit::none) return "--outline";
  return given_.depth_cue && *given_.depth_cue > 0 ? "--depth-cue" : "";
}

void add_postprocessing(OutputPaths& outputs, const PostprocessOptions& options,
                        const SceneFile& file, const std::shared_ptr<const Scene>& scene,
                        const RenderSettings& settings) {
  if (!outputs.shows_postprocessing()) {
    const std::string given = options.first_given();
    if (given.empty()) return;
    throw InputError(given +
                     ": an EXR file stores the traced values, without postprocessing: write a "
                     ".png, .tif, .jpg or .jp2");
  }
  const Postprocessing postprocessing = options.over(file.postprocessing);
  const double width = pixels_of(postprocessing.outline, height_of(settings), outputs.dpi);
  if (width > 0 && scene->camera.aperture > 0) {
    throw InputError(
        "outline: the camera's lens blurs the edges of spheres, so they have no outline: set "
        "aperture to 0, or add --outline off");
  }
  Seen seen{scene, file.scenery, postprocessing.depth_cue, postprocessing.depths};
  PostprocessSteps steps;
  if (postprocessing.depth_cue > 0) {
    if (file.scenery > 0) seen.farthest = depth_of_farthest(*scene, file.scenery);
    steps.push_back(depth_cue_step(seen));
  }
  if (width > 0) steps.push_back(outline_step(seen, width));
  outputs.finishing.insert(outputs.finishing.begin(), steps.begin(), steps.end());
}

void add_background(OutputPaths& outputs, const Vec3d& color) {
  if (can_hold_channels(outputs.image)) {
    throw InputError(
        "--background: an EXR file stores the traced values: write a .png, or use --transparent on "
        "and choose the background later");
  }
  const PostprocessStep step{background_step, {}, [color](ShownPicture& picture) {
                               put_on_background(picture.image, picture.alpha, color);
                             }};
  outputs.finishing.insert(outputs.finishing.begin(), step);
}

void warn_of_missing_postprocessing(const Postprocessing& postprocessing, bool labels,
                                    const std::string& name, const std::string& remedy) {
  std::string missing = postprocessing == Postprocessing{} ? "" : "no outlines and no depth cue";
  if (labels) missing += missing.empty() ? "no labels" : " and no labels";
  if (missing.empty()) return;
  std::cerr << "parray: " + name + ": the farm draws " + missing + " on the picture: " + remedy +
                   "\n";
}

}  // namespace parray::commands
