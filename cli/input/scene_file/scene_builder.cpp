#include <algorithm>
#include <array>
#include <cstdint>
#include <istream>
#include <optional>
#include <streambuf>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/input/particles/packed_file.h"
#include "cli/input/scene_file/json_stream.h"
#include "cli/input/scene_file/json_value.h"
#include "cli/input/scene_file/material_names.h"
#include "cli/input/scene_file/scene_fields.h"
#include "cli/input/scene_file/scene_file.h"
#include "cli/input/scene_file/scene_sections.h"
#include "cli/input/scene_file/sphere_text.h"
#include "cli/input/view/style.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/base/text.h"
#include "common/scene/limits.h"
#include "common/scene/scene_bytes.h"

namespace parray::input {
namespace {

/// A sphere of the seed format, the scene format of the program from which ParRay developed:
/// {"spheres": [{"sphere": {"location": {x, y, z}, "material": {...}, "radius": r}}]} and nothing
/// else. Camera, image and settings are the defaults of Camera and RenderSettings.
struct SeedSphere {
  Sphere sphere;  ///< `material` is not set
  Material material;
};

/// Reads {"x": 1, "y": 2, "z": 3}, or an object with other names.
Vec3d read_named_vec3(const JsonFields& parent, std::string_view key,
                      const std::array<std::string_view, 3>& names, NumberRange range) {
  const JsonPlace place = parent.place().at(key);
  const JsonFields fields(parent.any(key, "{ ... } with " + list_names(names)), place, names);
  return {fields.number(names[0], range), fields.number(names[1], range),
          fields.number(names[2], range)};
}

Vec3d read_color(const JsonFields& material) {
  return read_named_vec3(material, "color", {"r", "g", "b"}, ranges::unit_interval);
}

Material read_seed_material(const JsonValue& value, const JsonPlace& place) {
  static constexpr std::array<std::string_view, 3> types{"lambertian", "metal", "dielectric"};
  const JsonFields all(value, place, {"type", "color", "fuzz", "refraction_index"});
  const std::string& type = all.string("type");
  Material material;
  if (type == "lambertian") {
    material.albedo = read_color(JsonFields(value, place, {"type", "color"}));
  } else if (type == "metal") {
    const JsonFields fields(value, place, {"type", "color", "fuzz"});
    material.type = MaterialType::metal;
    material.albedo = read_color(fields);
    material.fuzz = fields.number("fuzz", ranges::unit_interval);
  } else if (type == "dielectric") {
    const JsonFields fields(value, place, {"type", "refraction_index"});
    material.type = MaterialType::dielectric;
    material.ior = fields.number("refraction_index", ranges::ior);
  } else {
    place.at("type").fail(all.find("type")->line, "unknown material type '" + printable(type) +
                                                      "': " + remedy_for_name(type, types));
  }
  return material;
}

bool is_seed_sphere(const JsonValue& value) {
  return std::ranges::find(value.members, "sphere", &JsonMember::key) != value.members.end();
}

/// Reads a sphere of the seed format. Ranges and errors are those of version 1.
SeedSphere read_seed_sphere(const JsonValue& value, const JsonPlace& place) {
  const JsonFields outer(value, place, {"sphere"});
  const JsonPlace inner = place.at("sphere");
  const JsonFields fields(outer.any("sphere", "the sphere"), inner,
                          {"location", "material", "radius"});
  SeedSphere out;
  out.sphere.center = read_named_vec3(fields, "location", {"x", "y", "z"}, ranges::coordinate);
  out.sphere.radius = fields.number("radius", ranges::length);
  out.material =
      read_seed_material(fields.any("material", "{ ... } with its type"), inner.at("material"));
  return out;
}

struct RequiredKey {
  std::string_view key;
  std::string_view expectation;
  bool unless_other_shapes;  ///< optional beside particles; spheres also beside capsules
};
constexpr std::array<RequiredKey, 4> required_keys{{
    {"version", "\"version\": 1", false},
    {"camera", "{ ... } with look_from, look_at and vfov", false},
    {"materials", "{ ... } with the materials by name", true},
    {"spheres", "[ ... ], which may be empty", true},
}};

constexpr const char* write_spheres =
    "write spheres as {\"center\": [X, Y, Z], \"radius\": R, \"material\": NAME}";
constexpr const char* too_many_materials =
    "the scene has too many distinct materials: let spheres share materials";

/// Builds a scene from the pieces of its JSON, in either format.
///
/// The pieces show the format. An item {"sphere": ...} belongs to the seed format. All keys except
/// "spheres" belong to version 1. A file with both is an error. Every member function throws
/// InputError with the place and the line.
class SceneBuilder final : public JsonSink {
 public:
  /// `file` names the input in messages and must outlive this object.
  explicit SceneBuilder(const std::string& file) : root_(file) {}

  JsonDelivery on_key(const std::string& key, std::uint64_t line) override {
    const JsonPlace place = root_.at(key);
    if (!place_in(scene_keys, key)) fail_unknown_key(key, line, root_, scene_keys);
    if (has_key(key)) place.fail(line, "duplicate key '" + key + "': remove one of them");
    keys_.push_back(key);
    if (key == "spheres") return JsonDelivery::by_item;
    if (format_ == Format::seed) {
      place.fail(line, std::string("this key belongs to scene JSON version 1, but the spheres have "
                                   "the seed format ({\"sphere\": ...}): ") +
                           write_spheres);
    }
    format_ = Format::version_1;
    if (key == "particles" || key == "capsules") return JsonDelivery::by_item;
    return key == "materials" ? JsonDelivery::by_member : JsonDelivery::whole;
  }

  void on_member(const JsonMember& member) override {
    const JsonPlace place = root_.at(member.key);
    if (member.key == "version") {
      read_version(member.value, place);
    } else if (member.key == "camera") {
      out_.scene.camera = read_camera(member.value, place);
    } else if (member.key == "image" || member.key == "render") {
      read_settings(member.value, place, member.key == "image", out_.settings, out_.transparent);
    } else if (member.key == "style") {
      style_ = read_style(member.value, place);
    } else if (member.key == "finishing") {
      postprocessing_ = read_postprocessing(member.value, place);
    } else if (member.key == "sky") {
      out_.scene.sky = read_sky(member.value, place);
    } else {
      out_.labels = read_labels(member.value, place);
    }
  }

  void on_child(const JsonMember& child) override {
    const JsonPlace section = root_.at(keys_.back());
    if (keys_.back() == "materials") {
      add_material(child, section.at(child.key));
    } else if (keys_.back() == "particles") {
      add_particles(child.value, section.at(out_.particles.size()));
    } else if (keys_.back() == "capsules") {
      add_capsule(child.value, section.at(out_.scene.capsules.size()));
    } else {
      add_sphere(child.value, section.at(out_.scene.spheres.size()));
    }
  }

  /// Takes further spheres in the usual form whose materials earlier spheres have used.
  std::size_t take_items(ByteSource& source) override {
    if (keys_.back() != "spheres" || format_ != Format::version_1) return 0;
    constexpr std::size_t usual_bytes = 4096;
    std::vector<Sphere>& spheres = out_.scene.spheres;
    const std::size_t before = spheres.size();
    while (has_room()) {
      const std::optional<SphereText> text = next_sphere_text(source.ahead(usual_bytes));
      const auto material = text ? names_.used(text->material) : std::nullopt;
      if (!material) break;
      spheres.push_back(text->sphere);
      spheres.back().material = *material;
      source.skip(text->bytes, text->newlines);
    }
    return spheres.size() - before;
  }

  /// Completes the scene. Call it once, after the last piece. `start_line` is the line where the
  /// document starts.
  SceneFile finish(std::uint64_t start_line) {
    // No spheres and no other key: the file has the seed format, although no item shows it.
    const bool is_bare = format_ == Format::unknown && has_key("spheres");
    if (format_ == Format::seed || is_bare) {
      out_.seed_format = true;
      out_.scene.camera.tan_half_vfov = tan_half_of(out_.scene.camera.vfov);
    } else {
      finish_version_1(start_line);
    }
    out_.scene.materials = table_.take();
    return std::move(out_);
  }

 private:
  enum class Format : std::uint8_t { unknown, version_1, seed };

  bool has_key(std::string_view key) const { return place_in(keys_, key).has_value(); }

  bool has_room() const {
    return out_.scene.spheres.size() + out_.scene.capsules.size() < limits::max_shapes;
  }
  void check_room(const JsonPlace& place, std::uint64_t line) const {
    if (has_room()) return;
    place.fail(line, "the scene has more than " + std::to_string(limits::max_shapes) +
                         " spheres and capsules: split the scene");
  }

  void add_material(const JsonMember& member, const JsonPlace& place) {
    const Material material = read_material(member.value, place);
    if (!names_.define(member.key, material)) {
      place.fail(member.line, "duplicate key '" + printable(member.key) + "': remove one of them");
    }
    check_names(place, member.line);
  }
  void check_names(const JsonPlace& place, std::uint64_t line) const {
    if (names_.size() > limits::max_materials) place.fail(line, too_many_materials);
  }

  void add_sphere(const JsonValue& value, const JsonPlace& place) {
    check_room(place, value.line);
    const bool seed = is_seed_sphere(value);
    if (format_ == Format::unknown) format_ = seed ? Format::seed : Format::version_1;
    if (format_ == Format::seed) return add_seed_sphere(value, place);
    if (seed) {
      place.fail(value.line, std::string("the sphere has the seed format ({\"sphere\": ...}), but "
                                         "the scene has version 1: ") +
                                 write_spheres);
    }
    const JsonFields fields(value, place, {"center", "radius", "material"});
    const Vec3d center = fields.vec3("center", ranges::coordinate);
    const double radius = fields.number("radius", ranges::length);
    add_shape(Sphere{center, radius, 0}, "spheres", fields, out_.scene.spheres);
  }

  void add_seed_sphere(const JsonValue& value, const JsonPlace& place) {
    const SeedSphere read = read_seed_sphere(value, place);
    const std::optional<std::uint32_t> material = table_.intern(read.material);
    if (!material) place.fail(value.line, too_many_materials);
    out_.scene.spheres.push_back(read.sphere);
    out_.scene.spheres.back().material = *material;
  }

  void add_capsule(const JsonValue& value, const JsonPlace& place) {
    check_room(place, value.line);
    const JsonFields fields(value, place, {"from", "to", "radius", "material"});
    const Vec3d from = fields.vec3("from", ranges::coordinate);
    const Vec3d to = fields.vec3("to", ranges::coordinate);
    const Capsule capsule{from, to, fields.number("radius", ranges::length), 0};
    add_shape(capsule, "capsules", fields, out_.scene.capsules);
    if (has_valid_ends(capsule)) return;
    place.at("to").fail(fields.find("to")->line,
                        "the ends of the capsule are less than 2e-15 apart: write equal ends, or "
                        "use a smaller unit of length");
  }

  /// Adds a shape of a scene file of version 1. Its field "material" names its material.
  template <typename Shape>
  void add_shape(Shape shape, std::string_view section, const JsonFields& fields,
                 std::vector<Shape>& to) {
    const std::string& material = fields.string("material");
    shape.material = names_.use(material, section, to.size(), fields.find("material")->line);
    to.push_back(shape);
    check_names(fields.place(), fields.line());
  }

  void add_particles(const JsonValue& value, const JsonPlace& place) {
    if (out_.particles.size() == limits::max_particle_files) {
      place.fail(value.line, "the scene has more than " +
                                 std::to_string(limits::max_particle_files) +
                                 " particle files: join some");
    }
    out_.particles.push_back(read_particle_source(value, place));
  }

  void finish_version_1(std::uint64_t start_line) {
    for (const RequiredKey& required : required_keys) {
      const bool optional =
          required.unless_other_shapes &&
          (has_key("particles") || (required.key == "spheres" && has_key("capsules")));
      if (has_key(required.key) || optional) continue;
      fail_missing_key(required.key, start_line, root_, required.expectation);
    }
    if (style_ && !has_key("sky")) out_.scene.sky = sky_of(*style_);
    out_.postprocessing =
        postprocessing_.over(style_ ? postprocessing_of(*style_) : Postprocessing{});
    resolve_materials();
    out_.materials = std::move(names_);
  }

  /// Replaces names by numbers of distinct materials, in the order in which shapes first use them.
  void resolve_materials() {
    std::vector<std::optional<std::uint32_t>> numbers(names_.size());
    const auto resolve = [&](auto& shape) {
      std::optional<std::uint32_t>& number = numbers[shape.material];
      if (!number) number = resolve_material(shape.material);
      shape.material = *number;
    };
    std::ranges::for_each(out_.scene.spheres, resolve);
    std::ranges::for_each(out_.scene.capsules, resolve);
  }

  std::uint32_t resolve_material(std::uint32_t name) {
    const MaterialNames::Entry& entry = names_[name];
    // The table has room: there are at most as many values as names.
    if (entry.value) return *table_.intern(*entry.value);
    const JsonPlace section = root_.at(entry.first_section);
    const JsonPlace shape = section.at(entry.first_shape);
    shape.at("material")
        .fail(entry.first_line, "unknown material '" + printable(names_.name_of(name)) +
                                    "': " + names_.remedy_for_undefined(names_.name_of(name)));
  }

  JsonPlace root_;
  std::vector<std::string> keys_;  // the top-level keys so far; the last is the current one
  Format format_ = Format::unknown;
  SceneFile out_;
  std::optional<Style> style_;
  PostprocessingSection postprocessing_;
  MaterialNames names_;  // of version 1; until finish(), a shape's material is one of their numbers
  MaterialTable table_;
};

/// A stream over a file, which is unpacked if necessary; only for reads of whole blocks.
class FileBuffer : public std::streambuf {
 public:
  explicit FileBuffer(PackedFile& file) : file_(file) {}

 protected:
  std::streamsize xsgetn(char* to, std::streamsize bytes) override {
    return static_cast<std::streamsize>(file_.read(to, static_cast<std::size_t>(bytes)));
  }

 private:
  PackedFile& file_;
};

}  // namespace

SceneFile read_scene(std::istream& input, const std::string& name, int threads) {
  SceneBuilder builder(name);
  const std::uint64_t start_line = parse_json(input, name, builder);
  SceneFile file = builder.finish(start_line);
  file.duplicates = remove_duplicates(file.scene, threads);
  return file;
}

SceneFile read_scene_file(PackedFile& file, int threads) {
  if (file.size().value_or(0) > limits::max_scene_file_bytes) {
    FilePlace{file.name()}.fail("the file has " + std::to_string(*file.size()) +
                                " bytes, more than " +
                                std::to_string(limits::max_scene_file_bytes) + ": split it");
  }
  file.rewind();
  FileBuffer buffer(file);
  std::istream input(&buffer);
  input.exceptions(std::ios::badbit);  // passes on exceptions of the file
  return read_scene(input, file.name(), threads);
}

SceneFile read_scene_file(const std::filesystem::path& path, int threads) {
  PackedFile file(path);
  return read_scene_file(file, threads);
}

}  // namespace parray::input
