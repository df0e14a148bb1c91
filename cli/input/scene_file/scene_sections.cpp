#include "cli/input/scene_file/scene_sections.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "cli/input/scene_file/particle_fields.h"
#include "cli/input/scene_file/scene_fields.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"

namespace parray::input {

std::string problem_with(const Camera& camera) {
  const Vec3d view = camera.look_at - camera.look_from;
  const double distance = length(view);
  if (distance == 0) return "look_from and look_at are the same point: move one of them";
  if (distance < limits::min_radius || distance > limits::max_length) {
    return "look_from and look_at are " + number_text(distance) +
           " apart: use a distance between " + number_text(limits::min_radius) + " and " +
           number_text(limits::max_length);
  }
  // At smaller angles between `up` and the view, rounding of `up` would determine the rotation of
  // the picture.
  constexpr double min_up_sine = 1e-6;
  const double up_length = length(camera.up);
  if (up_length < limits::min_radius) return "up is zero: write a direction such as [0, 1, 0]";
  const double sine = length(cross((1 / up_length) * camera.up, normalize(view)));
  return sine < min_up_sine
             ? "up is parallel to the view from look_from to look_at: turn one of them"
             : "";
}

double tan_half_of(double vfov) { return std::tan(vfov / 2 * (std::numbers::pi / 180)); }

void read_version(const JsonValue& value, const JsonPlace& place) {
  const std::uint64_t version = read_integer(value, place, {1, 1'000'000});
  if (version == 1) return;
  place.fail(value.line,
             "version " + std::to_string(version) +
                 " is newer than this ParRay supports: install a newer ParRay, or write version 1");
}

namespace {

/// Returns whether a section has the setting. 0 means a section other than `image` and `render`.
bool is_in(unsigned section, const Setting& setting) { return section == 0 || setting.is(section); }

/// Returns the keys that `describe(visitor)` visits and that belong to `section`.
std::vector<std::string_view> keys_of(const auto& describe, unsigned section = 0) {
  std::vector<std::string_view> keys;
  describe([&](const Setting& setting, const auto&... /*rule and values*/) {
    if (is_in(section, setting)) keys.emplace_back(setting.key);
  });
  return keys;
}

/// A visitor of a description that sets the members that a section names. Throws InputError with
/// the place.
class SectionReader {
 public:
  explicit SectionReader(const JsonFields& fields, unsigned section = 0)
      : fields_(fields), section_(section) {}

  template <typename T>
  void operator()(const Setting& s, const auto& rule, T& value) const {
    if (!is_in(section_, s)) return;
    if (s.is(traits::required) || fields_.find(s.key) != nullptr) {
      value = static_cast<T>(read(s.key, rule));
    }
  }

 private:
  auto checked(const char* key, const auto& work) const {
    return fields_.place().at(key).checked(fields_.find(key)->line, work);
  }
  std::uint64_t read(const char* key, IntegerRange range) const {
    return fields_.integer(key, range);
  }
  double read(const char* key, NumberRange range) const { return fields_.number(key, range); }
  Vec3d read(const char* key, Vec3Range range) const { return fields_.vec3(key, range); }
  bool read(const char* key, Flag /*rule*/) const { return fields_.boolean(key); }
  bool read(const char* key, OnOff /*rule*/) const { return fields_.boolean(key); }
  static std::vector<std::uint64_t> read(const char* /*key*/, Passes /*rule*/) { return {}; }

  std::size_t read(const char* key, const Words& words) const {
    const std::string& name = fields_.string(key);
    return checked(key, [&] { return known_place(words.what, name, words.names); });
  }
  std::string read(const char* key, LabelText rule) const {
    const std::string& text = fields_.string(key);
    const std::string problem = problem_with_label_text(text, rule.longest);
    if (!problem.empty()) fail(key, problem);
    return text;
  }
  LineWidth read(const char* key, LineWidthRange range) const {
    if (fields_.find(key)->kind != JsonKind::number) return from_words(key, line_width_from);
    return {LineWidth::Unit::pixels, fields_.number(key, range)};
  }
  double read(const char* key, ShareRange range) const {
    if (fields_.find(key)->kind != JsonKind::number) return from_words(key, depth_cue_from);
    return fields_.number(key, range);
  }

  std::string read(const char* key, FileName /*rule*/) const {
    const std::string& name = fields_.string(key);
    if (name.empty()) fail(key, "the name is empty: write the name of a file");
    return name;
  }
  template <typename T>
  T read(const char* key, const TextRule<T>& rule) const {
    const std::string text =
        text_in(fields_.any(key, "a text in double quotes"), fields_.place().at(key), rule.form);
    return checked(key, [&] { return rule.parse(text); });
  }
  std::vector<std::string> read(const char* key, HiddenClasses /*rule*/) const {
    const JsonValue& list = *fields_.find(key);
    if (list.kind != JsonKind::array) {
      fail(key, "this is not a list: write words in brackets, such as [\"virtual\", \"water\"]");
    }
    std::vector<std::string> words;
    for (const JsonValue& word : list.items) {
      words.push_back(read_string(word, fields_.place().at(key).at(words.size())));
    }
    checked(key, [&] { check_hidden(words); });
    return words;
  }

  std::vector<Representation> read(const char* key, Representations /*rule*/) const {
    static const auto keys = keys_of([](const auto& f) { representation_fields(f); });
    const JsonValue& list = *fields_.find(key);
    if (list.kind != JsonKind::array) {
      fail(key, "this is not a list: write [{\"select\": \"protein\", ...}, ...]");
    }
    if (list.items.size() > max_representations) {
      fail(key, "the list has more than " + std::to_string(max_representations) +
                    " items: use several items of particles");
    }
    const JsonPlace object = fields_.place().at(key);
    std::vector<Representation> shows;
    for (const JsonValue& item : list.items) {
      const JsonPlace place = object.at(shows.size());
      const JsonFields fields(item, place, keys);
      Representation& show = shows.emplace_back();
      show.line = fields.line();
      representation_fields(SectionReader(fields), show);
    }
    return shows;
  }

  /// Returns the text of a value, which may also have the other form.
  static std::string text_in(const JsonValue& value, const JsonPlace& place, JsonForm form) {
    if (form == JsonForm::number && value.kind == JsonKind::number) return text_of_number(value);
    if (form == JsonForm::number && value.kind != JsonKind::string) {
      place.fail(value.line, "expected a number or a text, found " +
                                 std::string(name_of(value.kind)) +
                                 ": write a number, or a text in double quotes");
    }
    if (form != JsonForm::pair || value.kind != JsonKind::array) return read_string(value, place);
    if (value.items.size() != 2) {
      place.fail(value.line, "the array does not have two numbers: write [low, high]");
    }
    constexpr NumberRange finite{std::numeric_limits<double>::lowest(),
                                 std::numeric_limits<double>::max()};
    const double low = read_number(value.items[0], place.at(0), finite);
    const double high = read_number(value.items[1], place.at(1), finite);
    if (!(low < high)) {
      place.fail(value.line,
                 "low is not below high: write two different numbers, the smaller first");
    }
    return number_text(low) + ":" + number_text(high);
  }
  static std::string text_of_number(const JsonValue& value) {
    return value.is_natural ? std::to_string(value.natural) : number_text(value.number);
  }

  /// Returns the result of `from` for a boolean or a text.
  template <typename T>
  T from_words(const char* key, T (*from)(std::string_view)) const {
    const JsonValue& value = *fields_.find(key);
    if (value.kind == JsonKind::boolean) return from(value.is_true ? "on" : "off");
    const std::string& text = fields_.string(key);
    return checked(key, [&] { return from(text); });
  }
  [[noreturn]] void fail(const char* key, const std::string& problem) const {
    fields_.place().at(key).fail(fields_.find(key)->line, problem);
  }

  const JsonFields& fields_;
  unsigned section_;
};

/// Throws InputError if the camera has a key that its projection does not use.
void refuse(const JsonFields& fields, std::string_view key, const std::string& problem) {
  const JsonValue* const value = fields.find(key);
  if (value != nullptr) fields.place().at(key).fail(value->line, problem);
}

/// Checks that the camera has vfov or view_height as its projection requires.
void check_view(const JsonFields& fields, const Camera& camera) {
  if (camera.projection == Projection::orthographic) {
    refuse(fields, "vfov",
           "an orthographic camera has no angle of view: remove vfov and give view_height");
    static_cast<void>(fields.number("view_height", ranges::length));
  } else {
    refuse(fields, "view_height",
           "a perspective camera has an angle of view: remove view_height and give vfov, or set "
           "\"projection\": \"orthographic\"");
    static_cast<void>(fields.number("vfov", ranges::vfov));
  }
}

}  // namespace

std::span<const std::string_view> camera_keys() {
  static const auto keys = keys_of([](const auto& f) { camera_fields(f); });
  return keys;
}

Camera read_camera(const JsonValue& value, const JsonPlace& place) {
  return camera_from(JsonFields(value, place, camera_keys()));
}

Camera camera_from(const JsonFields& fields) {
  Camera camera;
  camera.vfov = camera.aperture = camera.focus_distance = 0;
  camera_fields(SectionReader(fields), camera);
  check_view(fields, camera);
  if (camera.vfov > 0) camera.tan_half_vfov = tan_half_of(camera.vfov);
  if (fields.find("focus_distance") == nullptr) {
    camera.focus_distance = length(camera.look_at - camera.look_from);
  }
  const std::string problem = problem_with(camera);
  if (!problem.empty()) fields.place().fail(fields.line(), problem);
  return camera;
}

Sky read_sky(const JsonValue& value, const JsonPlace& place) {
  const auto keys = keys_of([](const auto& f) { sky_fields(f); });
  Sky sky;
  sky_fields(SectionReader(JsonFields(value, place, keys)), sky);
  return sky;
}

PostprocessingSection read_postprocessing(const JsonValue& value, const JsonPlace& place) {
  const auto keys = keys_of([](const auto& f) { postprocessing_fields(f); });
  PostprocessingSection section;
  postprocessing_fields(SectionReader(JsonFields(value, place, keys)), section);
  return section;
}

LabelSettings read_labels(const JsonValue& value, const JsonPlace& place) {
  const auto keys = keys_of([](const auto& f) { label_fields(f); });
  const JsonFields fields(value, place, keys);
  LabelSettings labels;
  label_fields(SectionReader(fields), labels);
  if (labels.dpi && labels.width_mm) {
    place.at("dpi").fail(
        fields.find("dpi")->line,
        "width_mm and the picture's width in pixels already determine the pixels per "
        "inch: leave out dpi or width_mm");
  }
  return labels;
}

void read_settings(const JsonValue& value, const JsonPlace& place, bool image,
                   RenderSettings& settings, bool& transparent) {
  const unsigned section = image ? traits::image : traits::render;
  const auto keys =
      keys_of([&](const auto& f) { image_fields(f, settings, transparent); }, section);
  image_fields(SectionReader(JsonFields(value, place, keys), section), settings, transparent);
  // Each setting is in its range, so only a combination can be wrong.
  place.checked(value.line, [&] { check_settings(settings); });
}

Material read_material(const JsonValue& value, const JsonPlace& place) {
  static const auto keys_of_types = [] {
    std::array<std::vector<std::string_view>, scene_words::materials.size()> all;
    for (std::size_t i = 0; i < all.size(); ++i) {
      all[i] = keys_of([i](const auto& f) { material_fields(f, static_cast<MaterialType>(i)); });
    }
    return all;
  }();
  Material material;
  const JsonFields any(value, place, {"type", "albedo", "fuzz", "ior"});
  const SectionReader read_any(any);
  read_any({"type", nullptr, traits::required}, scene_words::material, material.type);
  const JsonFields fields(value, place, keys_of_types[static_cast<std::size_t>(material.type)]);
  material_fields(SectionReader(fields), material.type, material);
  return material;
}

void fail_in(const ParticleSource& source, const JsonPlace& place, const std::string& key,
             const std::optional<std::size_t>& representation, std::string_view problem) {
  if (!representation) place.at(key).fail(source.line_of(key), problem);
  const JsonPlace list = place.at("show");
  const JsonPlace show = list.at(*representation);
  show.at(key).fail(source.shows[*representation].line, problem);
}

ParticleSource read_particle_source(const JsonValue& value, const JsonPlace& place) {
  static const auto keys = keys_of([](const auto& f) { particle_fields(f); });
  const JsonFields fields(value, place, keys);
  ParticleSource out;
  out.line = fields.line();
  for (const JsonMember& member : value.members) out.lines.emplace(member.key, member.value.line);
  particle_fields(SectionReader(fields), out);
  if (const auto problem = problem_with(out)) {
    fail_in(out, place, problem->key, problem->representation, problem->text);
  }
  return out;
}

}  // namespace parray::input
