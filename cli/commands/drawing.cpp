#include "cli/commands/drawing.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "cli/input/particles/json_types.h"
#include "cli/input/scene_file/scene_fields.h"
#include "common/base/error.h"
#include "common/base/json_text.h"
#include "proto/job_head.h"

namespace parray::input {

// What the description of a drawing says of legends, cells and particle files.
inline void to_json(nlohmann::json& list, const LegendEntry& entry) {
  list = {entry.name, entry.color, entry.count, entry.arrow};
}
inline void from_json(const nlohmann::json& list, LegendEntry& entry) {
  entry = {list.at(0), list.at(1), list.at(2), list.at(3)};
}
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Legend, title, unit, low, high, log, stops, entries)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ParticleCell, origin, edges, periodic)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ParticleFacts, format, frame, time, length_unit)

}  // namespace parray::input

namespace parray::commands {
namespace {

using nlohmann::json;

json json_of(const LabelSettings& labels) {
  json map = json::object();
  label_fields(
      [&map](const Setting& setting, const auto& /*rule*/, const auto& value) {
        if (json given = value; !given.is_null()) map[setting.key] = std::move(given);
      },
      labels);
  return map;
}

LabelSettings labels_of(const json& map) {
  LabelSettings labels;
  label_fields(
      [&map](const Setting& setting, const auto& /*rule*/, auto& value) {
        if (map.contains(setting.key)) map.at(setting.key).get_to(value);
      },
      labels);
  return labels;
}

json json_of(const Postprocessing& steps) {
  json map = {{"outline", {static_cast<int>(steps.outline.unit), steps.outline.value}},
              {"depth_cue", steps.depth_cue}};
  if (!steps.depths.empty()) map["depths"] = {steps.depths.low, steps.depths.high};
  return map;
}

Postprocessing postprocessing_of(const json& map) {
  Postprocessing steps;
  const int unit = map.at("outline").at(0);
  if (unit < 0 || unit > static_cast<int>(LineWidth::Unit::points)) {
    throw RunError(
        "the coordinator describes an outline of an unknown unit: use parray and "
        "parray-coordinator of the same release");
  }
  steps.outline = {static_cast<LineWidth::Unit>(unit), map.at("outline").at(1)};
  map.at("depth_cue").get_to(steps.depth_cue);
  if (map.contains("depths")) steps.depths = {map["depths"].at(0), map["depths"].at(1)};
  return steps;
}

SceneFile scene_file_of(const json& map) {
  SceneFile file;
  file.labels = labels_of(map.at("labels"));
  file.postprocessing = postprocessing_of(map.at("finishing"));
  map.at("legends").get_to(file.legends);
  if (map.contains("cell")) map["cell"].get_to(file.cell);
  map.at("cell_if_it_fits").get_to(file.cell_if_it_fits);
  map.at("solid_cell").get_to(file.solid_cell);
  map.at("scenery").get_to(file.scenery);
  for (const json& facts : map.at("files")) facts.get_to(file.particle_files.emplace_back().facts);
  if (map.contains("background")) map["background"].get_to(file.background);
  return file;
}

/// Adds labels, postprocessing and background. `outputs.image` must be a file of 8 bits.
void add_steps(OutputPaths& outputs, const LabelOptions& labels,
               const PostprocessOptions& postprocessing, const SceneFile& file,
               const std::shared_ptr<const Scene>& scene, const RenderSettings& settings) {
  outputs.transparent = file.background.has_value();
  add_labels(outputs, labels, file, settings);
  add_postprocessing(outputs, postprocessing, file, scene, settings);
  if (file.background) add_background(outputs, *file.background);
}

}  // namespace

std::string drawing_text(const LabelOptions& labels, const PostprocessOptions& postprocessing,
                         const SceneFile& file, const std::shared_ptr<const Scene>& scene,
                         const RenderSettings& settings) {
  OutputPaths outputs;
  outputs.image = "image.png";
  add_steps(outputs, labels, postprocessing, file, scene, settings);
  if (outputs.finishing.empty() && outputs.dpi == 0) return "";
  json map = {{"labels", json_of(labels.over(file.labels, width_of(settings)))},
              {"finishing", json_of(postprocessing.over(file.postprocessing))},
              {"legends", file.legends},
              {"cell_if_it_fits", file.cell_if_it_fits},
              {"solid_cell", file.solid_cell},
              {"scenery", file.scenery},
              {"files", json::array()}};
  for (const ParticleFile& one : file.particle_files) map["files"].push_back(one.facts);
  if (file.cell) map["cell"] = file.cell;
  if (file.background) map["background"] = file.background;
  std::string text = json_text(map, true);
  if (text.size() > max_drawing) {
    map["legends"] = json::array();
    if (!map["labels"]["legend"].get<bool>()) return json_text(map, true);
    throw InputError(
        "--legend: the legend has too many entries for a film or a picture by HTTP: colour by "
        "something with fewer values, or leave out the legend");
  }
  return text;
}

void add_drawing(OutputPaths& outputs, const std::string& drawing,
                 const std::shared_ptr<const Scene>& scene, const RenderSettings& settings) {
  if (drawing.empty()) return;
  try {
    SceneFile file = scene_file_of(json::parse(drawing));
    file.scene.camera = scene->camera;
    add_steps(outputs, {}, {}, file, scene, settings);
  } catch (const json::exception& error) {
    throw RunError(
        std::string("the coordinator's description of labels and outlines is damaged (") +
        error.what() + "): write the picture as .exr, without them");
  }
}

}  // namespace parray::commands
