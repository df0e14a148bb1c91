#include "cli/commands/drawing.h"

#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <type_traits>
#include <utility>

#include "cli/input/scene_file/scene_fields.h"
#include "common/base/error.h"
#include "proto/job_head.h"

namespace parray::commands {
namespace {

using nlohmann::json;

json json_of(const Vec3d& v) { return {v.x, v.y, v.z}; }
Vec3d vec3_of(const json& list) { return {list.at(0), list.at(1), list.at(2)}; }

json json_of(const LabelSettings& labels) {
  json map = json::object();
  label_fields(
      [&map](const Setting& setting, const auto& /*rule*/, const auto& value) {
        if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::optional<double>>) {
          if (value) map[setting.key] = *value;
        } else {
          map[setting.key] = value;
        }
      },
      labels);
  return map;
}

LabelSettings labels_of(const json& map) {
  LabelSettings labels;
  label_fields(
      [&map](const Setting& setting, const auto& /*rule*/, auto& value) {
        if (!map.contains(setting.key)) return;
        if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::optional<double>>) {
          value = map.at(setting.key).template get<double>();
        } else {
          map.at(setting.key).get_to(value);
        }
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

json json_of(const Legend& legend) {
  json map = {{"title", legend.title},   {"unit", legend.unit}, {"low", legend.low},
              {"high", legend.high},     {"log", legend.log},   {"stops", json::array()},
              {"entries", json::array()}};
  for (const Vec3d& stop : legend.stops) map["stops"].push_back(json_of(stop));
  for (const LegendEntry& entry : legend.entries) {
    map["entries"].push_back({entry.name, json_of(entry.color), entry.count, entry.arrow});
  }
  return map;
}

Legend legend_of(const json& map) {
  Legend legend;
  map.at("title").get_to(legend.title);
  map.at("unit").get_to(legend.unit);
  map.at("low").get_to(legend.low);
  map.at("high").get_to(legend.high);
  map.at("log").get_to(legend.log);
  for (const json& stop : map.at("stops")) legend.stops.push_back(vec3_of(stop));
  for (const json& entry : map.at("entries")) {
    legend.entries.push_back({entry.at(0), vec3_of(entry.at(1)), entry.at(2), entry.at(3)});
  }
  return legend;
}

json json_of(const ParticleCell& cell) {
  return {{"origin", json_of(cell.origin)},
          {"edges", {json_of(cell.edges[0]), json_of(cell.edges[1]), json_of(cell.edges[2])}},
          {"periodic", cell.periodic}};
}

ParticleCell cell_of(const json& map) {
  ParticleCell cell{vec3_of(map.at("origin")), {}, map.at("periodic")};
  for (std::size_t i = 0; i < cell.edges.size(); ++i) {
    cell.edges.at(i) = vec3_of(map.at("edges").at(i));
  }
  return cell;
}

/// Returns the facts about particle files that labels show.
json facts_of(const std::vector<ParticleFile>& files) {
  json list = json::array();
  for (const ParticleFile& file : files) {
    const ParticleFacts& facts = file.facts;
    list.push_back({{"format", facts.format},
                    {"frame", facts.frame},
                    {"time", facts.time ? json(*facts.time) : json()},
                    {"length_unit", facts.length_unit}});
  }
  return list;
}

std::vector<ParticleFile> files_of(const json& list) {
  std::vector<ParticleFile> files;
  for (const json& map : list) {
    ParticleFile file;
    map.at("format").get_to(file.facts.format);
    map.at("frame").get_to(file.facts.frame);
    if (!map.at("time").is_null()) file.facts.time = map.at("time").get<double>();
    map.at("length_unit").get_to(file.facts.length_unit);
    files.push_back(std::move(file));
  }
  return files;
}

SceneFile scene_file_of(const json& map) {
  SceneFile file;
  file.labels = labels_of(map.at("labels"));
  file.postprocessing = postprocessing_of(map.at("finishing"));
  for (const json& legend : map.at("legends")) file.legends.push_back(legend_of(legend));
  if (map.contains("cell")) file.cell = cell_of(map.at("cell"));
  map.at("cell_if_it_fits").get_to(file.cell_if_it_fits);
  map.at("solid_cell").get_to(file.solid_cell);
  map.at("scenery").get_to(file.scenery);
  file.particle_files = files_of(map.at("files"));
  if (map.contains("background")) file.background = vec3_of(map.at("background"));
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
              {"legends", json::array()},
              {"cell_if_it_fits", file.cell_if_it_fits},
              {"solid_cell", file.solid_cell},
              {"scenery", file.scenery},
              {"files", facts_of(file.particle_files)}};
  for (const Legend& legend : file.legends) map["legends"].push_back(json_of(legend));
  if (file.cell) map["cell"] = json_of(*file.cell);
  if (file.background) map["background"] = json_of(*file.background);
  std::string text = map.dump(-1, ' ', true, json::error_handler_t::replace);
  if (text.size() > max_drawing) {
    map["legends"] = json::array();
    if (!map["labels"]["legend"].get<bool>()) return map.dump(-1, ' ', true);
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
        std::string("what the coordinator says about the picture's labels is damaged: ") +
        error.what());
  }
}

}  // namespace parray::commands
