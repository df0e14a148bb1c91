#include "cli/commands/finishing_options.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>

#include "cli/commands/setting_options.h"
#include "cli/input/formats/format_table.h"
#include "cli/output/labels/labels.h"
#include "cli/output/picture/image_file.h"
#include "cli/output/picture/transparency.h"
#include "cli/output/postprocess/outline_and_depth_cue.h"
#include "cli/output/recipe.h"
#include "common/base/cpu_count.h"
#include "common/base/printable.h"
#include "common/scene/limits.h"

namespace parray::commands {
namespace {

constexpr double millimetres_an_inch = 25.4;

double pixels_in(double millimetres, double dpi) { return millimetres / millimetres_an_inch * dpi; }

bool may_hold_frames_of(const std::string& format) {
  return std::ranges::any_of(particle_formats(), [&](const ParticleFormat* known) {
    return known->name == format && known->frames;
  });
}

/// Returns the frame and time of the first file that has them: "frame 3, time 1.5". Empty: no file
/// has them.
std::string time_stamp_of(const std::vector<ParticleFile>& files) {
  for (const ParticleFile& file : files) {
    const ParticleFacts& facts = file.facts;
    const bool frames = may_hold_frames_of(facts.format);
    std::string text = frames ? "frame " + std::to_string(facts.frame) : "";
    if (facts.time) {
      const bool steps = facts.format == "LAMMPS dump";
      text +=
          (frames ? ", " : "") + std::string(steps ? "step " : "time ") + number_text(*facts.time);
    }
    if (!text.empty()) return text;
  }
  return "";
}

LabelContent content_of(const LabelSettings& labels, const SceneFile& file,
                        const RenderSettings& settings) {
  LabelContent content{.settings = labels, .legends = file.legends};
  content.cell = file.cell;
  content.solid_cell = file.solid_cell;
  content.time_stamp = time_stamp_of(file.particle_files);
  if (!file.particle_files.empty()) {
    content.unit = file.particle_files.front().facts.length_unit;
  }
  content.camera = file.scene.camera;
  content.width = width_of(settings);
  content.height = height_of(settings);
  content.scenery = file.scenery;
  return content;
}

/// Returns the labels to draw, as names of their options without dashes.
std::vector<std::string> drawn_by(const LabelSettings& labels) {
  std::vector<std::string> names;
  for (const auto& [name, wanted] :
       {std::pair("legend", labels.legend), std::pair("scale-bar", labels.scale_bar),
        std::pair("time-stamp", labels.time_stamp), std::pair("cell", labels.cell),
        std::pair("text", !labels.text.empty())}) {
    if (wanted) names.emplace_back(name);
  }
  return names;
}

PostprocessStep label_step(const LabelSettings& labels, LabelContent content) {
  PostprocessStep step;
  for (const std::string& name : drawn_by(labels)) {
    step.name += (step.name.empty() ? "" : ", ") + name;
  }
  if (labels.cell) step.needs = {Aov::depth, Aov::sphere};
  const std::uint32_t scenery = content.scenery;
  const auto drawing = std::make_shared<const Labels>(std::move(content));
  step.apply = [drawing, scenery](ShownPicture& picture) {
    drawing->draw(picture.image, picture.alpha,
                  {picture.floats("Z"), picture.wholes("sphere"), scenery});
  };
  return step;
}

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

void LabelOptions::add_to(Command& command, const Option* image, RenderOptions& render) {
  const auto sized = [this, &render] { render.print_width(printed_width()); };
  label_fields(
      [&](const Setting& setting, const auto& rule, auto& value) {
        Option option = add_setting(command, setting, rule, value, sized);
        option.group(labels_group);
        if (image != nullptr) option.needs(*image);
        if (rarely_needed(setting)) option.special();
      },
      settings_);
  render.auto_scene().frame_cell(settings_.cell);
  render.auto_scene().keep_free([this](const SceneFile& file) { return places(file); });
  command
      .on_off("--labels", of_scene_,
              "off: ignore the labels that the scene asks for, and draw only those of options "
              "(default: on)")
      .group(labels_group)
      .special();
  command.renamed("--no-labels", "--labels off");
}

std::string LabelOptions::first_given() const {
  const std::vector<std::string> names = drawn_by(settings_);
  return names.empty() ? "" : "--" + names.front();
}

std::optional<std::uint32_t> LabelOptions::printed_width() const {
  if (!settings_.width_mm) return std::nullopt;
  const double pixels =
      std::max(std::round(pixels_in(*settings_.width_mm, settings_.dpi.value_or(usual_dpi))), 1.0);
  if (pixels > limits::max_image_side) {
    throw InputError("the picture would be " + number_text(pixels) + " pixels wide: at most " +
                     std::to_string(limits::max_image_side) +
                     " are possible: use a smaller --width-mm or --dpi");
  }
  return static_cast<std::uint32_t>(pixels);
}

LabelSettings LabelOptions::over(const LabelSettings& of_scene, std::uint32_t width) const {
  LabelSettings labels = of_scene;
  if (!of_scene_.value_or(true)) {
    labels.legend = labels.scale_bar = labels.time_stamp = labels.cell = false;
    labels.text.clear();
  }
  if (!settings_.legend_title.empty() && !labels.legend && !settings_.legend) {
    throw InputError("--legend-title has no effect without a legend: add --legend");
  }
  const bool sized = settings_.dpi || settings_.width_mm;
  if (sized) labels.dpi = labels.width_mm = std::nullopt;
  label_fields(
      [](const Setting& /*setting*/, const auto& /*rule*/, auto& to, const auto& from) {
        if (from != std::decay_t<decltype(from)>{}) to = from;
      },
      labels, settings_);
  if (!sized || !labels.width_mm) return labels;
  if (printed_width() == width) {
    labels.dpi = settings_.dpi.value_or(usual_dpi);
    labels.width_mm.reset();
  } else if (labels.dpi) {
    throw InputError("--width-mm " + number_text(*labels.width_mm) + " --dpi " +
                     number_text(*labels.dpi) + " require " + std::to_string(*printed_width()) +
                     " pixels across, but the picture has " + std::to_string(width) +
                     ": leave one of them out");
  }
  return labels;
}

LabelSettings LabelOptions::fitting_in(const SceneFile& file) const {
  return fitting(file, over(file.labels, width_of(file.settings)), [&](const auto& labels) {
    if (labels.any()) (void)Labels(content_of(labels, file, file.settings));
    return labels;
  });
}

LabelPlaces LabelOptions::places(const SceneFile& file) const {
  return fitting(file, over(file.labels, width_of(file.settings)), [&](const auto& labels) {
    return labels.any() ? Labels::places(content_of(labels, file, file.settings)) : LabelPlaces{};
  });
}

void LabelOptions::check_used(const LabelSettings& drawn,
                              const std::vector<Legend>& legends) const {
  if (settings_.font_size && !drawn.any()) {
    throw InputError("--font-size has no effect without labels: add one, such as --legend");
  }
  const bool names_unit =
      drawn.scale_bar || drawn.legend || std::ranges::any_of(legends, shows_lengths);
  if (!settings_.unit.empty() && !names_unit) {
    throw InputError("--unit has no effect without a scale bar or a legend: add --scale-bar");
  }
}

void add_labels(OutputPaths& outputs, const LabelOptions& options, const SceneFile& file,
                const RenderSettings& settings) {
  const LabelSettings labels = options.over(file.labels, width_of(settings));
  options.check_used(labels, file.legends);
  std::vector<Legend> legends = file.legends;
  for (Legend& legend : legends) set_title(legend, labels);
  if (!legends.empty()) outputs.legends = legends_text(legends);
  if (labels.dpi || labels.width_mm) outputs.dpi = dots_per_inch(labels, width_of(settings));
  if (!labels.any()) return;
  if (outputs.shows_postprocessing()) {
    options.fitting(file, labels, [&](const LabelSettings& fit) {
      if (fit.any()) outputs.finishing.push_back(label_step(fit, content_of(fit, file, settings)));
    });
  } else if (!options.first_given().empty()) {
    throw InputError(options.first_given() +
                     ": an EXR file stores the traced values, without labels: write a .png, .tif, "
                     ".jpg or .jp2");
  }
}

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
