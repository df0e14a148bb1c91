#include "cli/input/scene_file/scene_writer.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <unordered_map>
#include <vector>

#include "cli/input/scene_file/material_table.h"
#include "common/base/error.h"
#include "common/base/printable.h"

namespace parray::input {
namespace {

std::string json_text(std::string_view text) {
  try {
    return nlohmann::json(text).dump();
  } catch (const nlohmann::json::type_error&) {
    throw InputError("'" + printable(text, 4096) +
                     "' is not UTF-8, as all names in a scene are: rename it");
  }
}

std::string array_text(const Vec3d& v) {
  return "[" + number_text(v.x) + "," + number_text(v.y) + "," + number_text(v.z) + "]";
}

std::string object_text(const Material& material) {
  switch (material.type) {
    case MaterialType::metal:
      return R"({"type":"metal","albedo":)" + array_text(material.albedo) + R"(,"fuzz":)" +
             number_text(material.fuzz) + "}";
    case MaterialType::dielectric:
      return R"({"type":"dielectric","ior":)" + number_text(material.ior) + "}";
    case MaterialType::diffuse:
      break;
  }
  return R"({"type":"diffuse","albedo":)" + array_text(material.albedo) + "}";
}

std::string members_text(const ParticleFilter& filter) {
  std::string text;
  if (!filter.select.empty()) text += R"(, "select":)" + json_text(filter.select);
  if (!filter.slice.empty()) text += R"(, "slice":)" + json_text(filter.slice);
  if (!filter.hide) return text;
  std::string words;
  for (const std::string& word : *filter.hide) {
    words += (words.empty() ? "" : ",") + json_text(word);
  }
  return text + R"(, "hide":[)" + words + "]";
}

std::string members_text(const ParticleColoring& coloring) {
  std::string text;
  if (!coloring.empty()) text += R"(, "color_by":)" + json_text(coloring.by);
  if (coloring.map) text += R"(, "colormap":)" + json_text(name_of(*coloring.map));
  const TextRange& range = coloring.range;
  if (range.open()) return text;
  if (range.low && range.high && !range.low->percent && !range.high->percent) {
    return text + R"(, "range":[)" + number_text(range.low->value) + "," +
           number_text(range.high->value) + "]";
  }
  return text + R"(, "range":)" + json_text(text_of(range));
}

std::string object_text(const ParticleSource& source) {
  std::string text = R"({"file":)" + json_text(source.file);
  if (const std::string material = text_of(source.material); !material.empty()) {
    text += R"(, "material":)" + json_text(material);
  }
  if (source.radius.rule == ParticleRadius::Rule::fixed) {
    text += R"(, "radius":)" + number_text(source.radius.value);
  } else if (source.radius.rule != ParticleRadius::Rule::automatic) {
    text += R"(, "radius":)" + json_text(text_of(source.radius));
  }
  if (!source.topology.empty()) text += R"(, "topology":)" + json_text(source.topology);
  if (source.frame) {
    text += R"(, "frame":)" + (source.frame->last ? json_text(last_frame_word)
                                                  : std::to_string(source.frame->number));
  }
  if (source.alternatives != AlternativeChoice{}) {
    text += R"(, "alternatives":)" + json_text(text_of(source.alternatives));
  }
  return text + members_text(source.filter) + members_text(source.coloring) + "}";
}

std::string head_text(const SceneFile& file) {
  const Camera& camera = file.scene.camera;
  const RenderSettings& settings = file.settings;
  std::string text = "{\"version\": 1,\n\"camera\": {\"look_from\":" + array_text(camera.look_from);
  text += ", \"look_at\":" + array_text(camera.look_at) + ", \"up\":" + array_text(camera.up);
  text +=
      camera.projection == Projection::orthographic
          ? ", \"projection\":\"orthographic\", \"view_height\":" + number_text(camera.view_height)
          : ", \"vfov\":" + number_text(camera.vfov);
  text += ", \"aperture\":" + number_text(camera.aperture);
  text += ", \"focus_distance\":" + number_text(camera.focus_distance) + "},\n";
  text += "\"image\": {\"width\":" + std::to_string(settings.width) +
          ", \"height\":" + std::to_string(settings.height) +
          (file.transparent ? ", \"transparent\":true},\n" : "},\n");
  text += "\"render\": {\"samples_per_pixel\":" + std::to_string(settings.samples_per_pixel) +
          ", \"max_depth\":" + std::to_string(settings.max_depth) +
          ", \"seed\":" + std::to_string(settings.seed) + "},\n";
  text += "\"sky\": {\"horizon\":" + array_text(file.scene.sky.horizon) +
          ", \"zenith\":" + array_text(file.scene.sky.zenith) + "},\n";
  if (file.finish != Finish{}) text += "\"finishing\": " + finish_text(file.finish) + ",\n";
  if (file.labels != LabelSettings{}) text += "\"labels\": " + labels_text(file.labels) + ",\n";
  return text;
}

/// A section's items, one on a line, written in blocks.
class Section {
 public:
  Section(std::ostream& out, const std::function<void()>& poll, const char* start)
      : out_(out), poll_(poll), text_(start) {}

  void add(const std::string& item) {
    text_ += first_ ? "\n" : ",\n";
    text_ += item;
    first_ = false;
    if (text_.size() >= block) flush();
  }
  void end(const char* closing) {
    text_ += closing;
    flush();
  }

 private:
  static constexpr std::size_t block = std::size_t{1} << 18;

  void flush() {
    poll_();
    out_ << text_;
    text_.clear();
  }

  std::ostream& out_;
  const std::function<void()>& poll_;
  std::string text_;
  bool first_ = true;
};

/// Writes the section `materials`; returns the JSON text of the name of each of the scene's.
std::vector<std::string> write_materials(const SceneFile& file, Section section) {
  std::unordered_map<Material, std::string, MaterialHash> names;
  for (const NamedMaterial& named : file.materials.defined()) {
    const std::string name = json_text(named.name);
    names.try_emplace(named.material, name);
    section.add(name + ": " + object_text(named.material));
  }
  std::vector<std::string> of_scene;
  for (const Material& material : file.scene.materials) {
    const auto known = names.find(material);
    if (known != names.end()) {
      of_scene.push_back(known->second);
      continue;
    }
    std::string name = "material " + std::to_string(of_scene.size());
    while (file.materials.find(name) != nullptr) name += "'";
    of_scene.push_back(json_text(name));
    section.add(of_scene.back() + ": " + object_text(material));
  }
  section.end("},\n");
  return of_scene;
}

}  // namespace

void write_scene(std::ostream& out, const SceneFile& file, const std::function<void()>& poll) {
  out << head_text(file);
  const std::vector<std::string> names =
      write_materials(file, Section(out, poll, "\"materials\": {"));
  Section spheres(out, poll, "\"spheres\": [");
  for (const Sphere& sphere : file.scene.spheres) {
    spheres.add(R"({"center":)" + array_text(sphere.center) + R"(,"radius":)" +
                number_text(sphere.radius) + R"(,"material":)" + names[sphere.material] + "}");
  }
  if (file.particles.empty()) {
    spheres.end("]}\n");
    return;
  }
  spheres.end("],\n");
  Section particles(out, poll, "\"particles\": [");
  for (const ParticleSource& source : file.particles) particles.add(object_text(source));
  particles.end("]}\n");
}

}  // namespace parray::input
