#include "cli/commands/label_options.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <type_traits>
#include <utility>

#include "cli/commands/setting_options.h"
#include "cli/input/formats/format_table.h"
#include "cli/output/labels/labels.h"
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

LabelPlaces LabelOptions::places(const SceneFile& file) const {
  return fitting(file, over(file.labels, width_of(file.settings)), [&](const auto& labels) {
    return labels.any() ? Labels::places(content_of(labels, file, file.settings)) : LabelPlaces{};
  });
}

void add_labels(OutputPaths& outputs, const LabelOptions& options, const SceneFile& file,
                const RenderSettings& settings) {
  const LabelSettings labels = options.over(file.labels, width_of(settings));
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

}  // namespace parray::commands
