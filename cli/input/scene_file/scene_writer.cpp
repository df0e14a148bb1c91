#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <vector>

#include "cli/input/scene_file/material_names.h"
#include "cli/input/scene_file/particle_fields.h"
#include "cli/input/scene_file/scene_fields.h"
#include "cli/input/scene_file/scene_file.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

std::string json_text(std::string_view text) {
  try {
    return nlohmann::json(text).dump();
  } catch (const nlohmann::json::type_error&) {
    throw InputError("'" + printable(text, 4096) +
                     "' is not UTF-8, but all names and texts in a scene must be: change it");
  }
}

std::string array_text(const Vec3d& v) {
  return "[" + number_text(v.x) + "," + number_text(v.y) + "," + number_text(v.z) + "]";
}

// Functions that return the JSON of a value by its rule. Empty: the value is the default of the
// reader.
std::string text_of(IntegerRange /*range*/, std::uint64_t value) { return std::to_string(value); }
std::string text_of(NumberRange /*range*/, const std::optional<double>& value) {
  return value ? number_text(*value) : "";
}
std::string text_of(Vec3Range /*range*/, const Vec3d& value) { return array_text(value); }
std::string text_of(Flag /*rule*/, bool value) { return value ? "true" : ""; }
std::string text_of(OnOff /*rule*/, bool value) { return value ? "true" : ""; }
std::string text_of(OnOff /*rule*/, const std::optional<bool>& value) {
  return !value ? "" : *value ? "true" : "false";
}
std::string text_of(Passes /*rule*/, const std::vector<std::uint64_t>& /*value*/) { return ""; }
std::string text_of(const Words& words, auto value) {
  return '"' + std::string(name_in(words, static_cast<std::size_t>(value))) + '"';
}
std::string text_of(LabelText /*rule*/, const std::string& value) {
  return value.empty() ? "" : json_text(value);
}
std::string text_of(LineWidthRange /*range*/, const LineWidth& value) {
  if (value.unit == LineWidth::Unit::none) return "";
  if (value.unit == LineWidth::Unit::automatic) return "true";
  const std::string number = number_text(value.value);
  return value.unit == LineWidth::Unit::points ? '"' + number + "pt\"" : number;
}
std::string text_of(ShareRange /*range*/, double value) {
  return value > 0 ? number_text(value) : "";
}

std::string text_of(FileName /*rule*/, const std::string& name) {
  return name.empty() ? "" : json_text(name);
}
template <typename T>
std::string text_of(const TextRule<T>& rule, const T& value) {
  std::string text = rule.text(value);
  if (text.empty()) return {};
  if (rule.form == JsonForm::number && is_number(text)) return text;
  if (rule.form != JsonForm::pair) return json_text(text);
  const std::size_t colon = text.find(':');
  const std::string low = text.substr(0, colon);
  const std::string high = text.substr(colon + 1);
  return is_number(low) && is_number(high) ? "[" + low + "," + high + "]" : json_text(text);
}
std::string text_of(HiddenClasses /*rule*/, const std::optional<std::vector<std::string>>& words) {
  if (!words) return {};
  std::string list;
  for (const std::string& word : *words) list += (list.empty() ? "" : ",") + json_text(word);
  return "[" + list + "]";
}

std::string text_of(Representations /*rule*/, const std::vector<Representation>& shows);

/// Returns the JSON object, on one line, of the members that `describe(visitor)` visits for
/// `section`. 0: all members.
std::string object_text(const auto& describe, const char* separator = ", ", unsigned section = 0) {
  std::string object;
  describe([&](const Setting& setting, const auto& rule, const auto& value) {
    using T = std::decay_t<decltype(value)>;
    const bool optional = setting.is(traits::if_set) || std::is_enum_v<T>;
    if (section != 0 && !setting.is(section)) return;
    if (optional && !setting.is(traits::required) && value == T{}) return;
    const std::string text = text_of(rule, value);
    if (text.empty()) return;
    object.append(object.empty() ? "\"" : separator + std::string("\""));
    object.append(setting.key).append("\":").append(text);
  });
  return "{" + object + "}";
}

std::string material_text(const Material& material) {
  return object_text([&](const auto& f) { material_fields(f, material.type, material); }, ",");
}

std::string text_of(Representations /*rule*/, const std::vector<Representation>& shows) {
  std::string list;
  for (const Representation& show : shows) {
    list += (list.empty() ? "" : ", ") +
            object_text([&](const auto& f) { representation_fields(f, show); });
  }
  return list.empty() ? "" : "[" + list + "]";
}

std::string object_text(const ParticleSource& source) {
  return object_text([&](const auto& f) { particle_fields(f, source); });
}

std::string head_text(const SceneFile& file) {
  const auto settings = [&file](const auto& f) {
    image_fields(f, *file.settings, file.transparent);
  };
  const auto camera = [&file](const auto& f) { camera_fields(f, file.scene.camera); };
  const auto sky = [&file](const auto& f) { sky_fields(f, file.scene.sky); };
  const auto postprocessing = [&file](const auto& f) {
    postprocessing_fields(f, file.postprocessing);
  };
  const auto labels = [&file](const auto& f) { label_fields(f, file.labels); };
  std::string text = "{\"version\": 1,\n\"camera\": " + object_text(camera) +
                     ",\n\"image\": " + object_text(settings, ", ", traits::image) +
                     ",\n\"render\": " + object_text(settings, ", ", traits::render) +
                     ",\n\"sky\": " + object_text(sky) + ",\n";
  if (file.postprocessing != Postprocessing{}) {
    text += "\"finishing\": " + object_text(postprocessing) + ",\n";
  }
  if (file.labels != LabelSettings{}) text += "\"labels\": " + object_text(labels) + ",\n";
  return text;
}

/// Writes the items of a section, one per line, in blocks.
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

/// Writes the section `materials`. Returns the name of each material of the scene, as JSON text.
std::vector<std::string> write_materials(const SceneFile& file, Section section) {
  std::unordered_map<Material, std::string, MaterialHash> names;
  for (const NamedMaterial& named : file.materials.defined()) {
    const std::string name = json_text(named.name);
    names.try_emplace(named.material, name);
    section.add(name + ": " + material_text(named.material));
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
    section.add(of_scene.back() + ": " + material_text(material));
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
  spheres.end("]");
  if (!file.scene.capsules.empty()) {
    Section capsules(out, poll, ",\n\"capsules\": [");
    for (const Capsule& capsule : file.scene.capsules) {
      capsules.add(R"({"from":)" + array_text(capsule.from) + R"(,"to":)" + array_text(capsule.to) +
                   R"(,"radius":)" + number_text(capsule.radius) + R"(,"material":)" +
                   names[capsule.material] + "}");
    }
    capsules.end("]");
  }
  if (!file.particles.empty()) {
    Section particles(out, poll, ",\n\"particles\": [");
    for (const ParticleSource& source : file.particles) particles.add(object_text(source));
    particles.end("]");
  }
  out << "}\n";
}

}  // namespace parray::input
