#include "cli/commands/label_options.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "cli/commands/options.h"
#include "cli/input/formats/format_table.h"
#include "cli/output/labels/labels.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/scene/limits.h"

namespace parray::commands {
namespace {

constexpr double millimetres_an_inch = 25.4;

double pixels_in(double millimetres, double dpi) { return millimetres / millimetres_an_inch * dpi; }

/// A text as a shell gives it: \n, which is awkward to type there, is a new line, too.
std::string with_new_lines(const std::string& text) {
  std::string lines;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool escaped = text.compare(i, 2, "\\n") == 0;
    lines += escaped ? '\n' : text[i];
    i += escaped ? 1 : 0;
  }
  return lines;
}

bool may_hold_frames_of(const std::string& format) {
  return std::ranges::any_of(particle_formats(), [&](const ParticleFormat* known) {
    return known->name == format && known->frames;
  });
}

/// What the first file says that knows of frames or time; empty: none does.
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
  content.time_stamp = time_stamp_of(file.particle_files);
  if (!file.particle_files.empty()) {
    content.unit = length_unit_of(file.particle_files.front().facts.format);
  }
  content.camera = file.scene.camera;
  content.width = settings.width;
  content.height = settings.height;
  content.scenery = file.scenery;
  return content;
}

/// What is drawn, by the options' names without their dashes.
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

FinishingStep label_step(const LabelSettings& labels, LabelContent content) {
  FinishingStep step;
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

void LabelOptions::add_to(Command& command, const Option& image, RenderOptions& render) {
  const auto flag = [&](const char* name, bool& target, const char* description) {
    command.flag(name, target, description).group(labels_group).needs(image);
  };
  const auto text = [&](const char* name, std::size_t longest, std::string& target,
                        const char* description) {
    return command
        .option(
            name,
            [longest, &target](const std::string& value) {
              const std::string problem = problem_with_label_text(value, longest);
              if (!problem.empty()) throw InputError(problem);
              target = with_new_lines(value);
            },
            description)
        .group(labels_group)
        .needs(image);
  };
  const auto size = [&](const char* name, NumberRange range, std::optional<double>& target,
                        const char* type, const char* description) {
    command
        .option(
            name,
            [this, range, &target, &render](const std::string& value) {
              target = real_number(value, range);
              render.print_width(printed_width());
            },
            description)
        .type_name(type)
        .group(labels_group)
        .needs(image);
  };
  flag("--legend", settings_.legend,
       "What the particles' colours mean: a bar of colours with numbers, or names");
  flag("--scale-bar", settings_.scale_bar,
       "A round length; with a perspective camera that of things as far away as look_at");
  text("--unit", longest_unit, settings_.unit,
       "Unit of lengths, as it is to be written; angstrom and um are known (default: that of the "
       "file's format)")
      .type_name("UNIT");
  flag("--time-stamp", settings_.time_stamp, "Which frame it is, and at which step or time");
  render.auto_scene().frame_cell(settings_.cell);
  flag("--cell", settings_.cell,
       "Outline of the simulation's box or the crystal's cell, hidden behind what is nearer, and "
       "the axes x, y, z");
  text("--text", longest_label_text, settings_.text, "A text; \\n begins a new line")
      .type_name("TEXT");
  size("--font-size", drawing_ranges::font_size, settings_.font_size, "PT",
       "Size of letters in print, in points (default: 8)");
  size("--width-mm", drawing_ranges::print_width, settings_.width_mm, "MM",
       "Width of the picture in print: without --width it has as many pixels as --dpi says "
       "(default: 300)");
  size("--dpi", drawing_ranges::dpi, settings_.dpi, "N",
       "Pixels an inch in print, for sizes and the file's metadata");
  command
      .on_off("--labels", of_scene_,
              "off: none of the labels that the scene asks for, only those of other options "
              "(default: on)")
      .group(labels_group);
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
                     std::to_string(limits::max_image_side) + " are possible");
  }
  return static_cast<std::uint32_t>(pixels);
}

LabelSettings LabelOptions::over(const LabelSettings& of_scene, std::uint32_t width) const {
  LabelSettings labels = of_scene;
  if (!of_scene_.value_or(true)) {
    labels.legend = labels.scale_bar = labels.time_stamp = labels.cell = false;
    labels.text.clear();
  }
  labels.legend |= settings_.legend;
  labels.scale_bar |= settings_.scale_bar;
  labels.time_stamp |= settings_.time_stamp;
  labels.cell |= settings_.cell;
  if (!settings_.text.empty()) labels.text = settings_.text;
  if (!settings_.unit.empty()) labels.unit = settings_.unit;
  if (settings_.font_size) labels.font_size = settings_.font_size;
  if (!settings_.dpi && !settings_.width_mm) return labels;
  labels.dpi = settings_.dpi;
  labels.width_mm = settings_.width_mm;
  if (!labels.width_mm) return labels;
  if (printed_width() == width) {
    labels.dpi = settings_.dpi.value_or(usual_dpi);
    labels.width_mm.reset();
  } else if (labels.dpi) {
    throw InputError("--width-mm " + number_text(*labels.width_mm) + " --dpi " +
                     number_text(*labels.dpi) + ": that is " + std::to_string(*printed_width()) +
                     " pixels wide, and the picture " + std::to_string(width) +
                     ": leave one of them out");
  }
  return labels;
}

void add_labels(OutputPaths& outputs, const LabelOptions& options, const SceneFile& file,
                const RenderSettings& settings) {
  const LabelSettings labels = options.over(file.labels, settings.width);
  if (!file.legends.empty()) outputs.legends = legends_text(file.legends);
  if (labels.dpi || labels.width_mm) outputs.dpi = dots_per_inch(labels, settings.width);
  if (!labels.any()) return;
  if (outputs.has_png()) {
    outputs.finishing.push_back(label_step(labels, content_of(labels, file, settings)));
  } else if (!options.first_given().empty()) {
    throw InputError(options.first_given() +
                     ": labels are drawn on PNG pictures, an EXR file keeps what was traced: "
                     "write a .png");
  }
}

}  // namespace parray::commands
