#include "cli/input/scene_file/scene_builder.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <utility>

#include "cli/input/scene_file/byte_source.h"
#include "cli/input/scene_file/json_fields.h"
#include "cli/input/scene_file/scene_keys.h"
#include "cli/input/scene_file/scene_sections.h"
#include "cli/input/scene_file/seed_format.h"
#include "cli/input/scene_file/sphere_text.h"
#include "common/base/printable.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

struct RequiredKey {
  std::string_view key;
  std::string_view expectation;
  bool unless_particles;
};
constexpr std::array<RequiredKey, 4> required_keys{{
    {"version", "\"version\": 1", false},
    {"camera", "{ ... } with look_from, look_at and vfov", false},
    {"materials", "{ ... } with the surfaces by name", true},
    {"spheres", "[ ... ], which may be empty", true},
}};

constexpr std::string_view too_many_materials =
    "more distinct materials than this program holds: let spheres share some";

}  // namespace

bool SceneBuilder::has_key(std::string_view key) const {
  return std::ranges::find(keys_, key) != keys_.end();
}

JsonDelivery SceneBuilder::on_key(const std::string& key, std::uint64_t line) {
  const JsonPlace place = root_.at(key);
  if (std::ranges::find(scene_keys, key) == scene_keys.end()) {
    fail_unknown_key(key, line, root_, scene_keys);
  }
  if (has_key(key)) place.fail(line, "duplicate key '" + key + "': remove one of them");
  keys_.push_back(key);
  if (key == "spheres") return JsonDelivery::by_item;
  if (format_ == Format::seed) {
    place.fail(line,
               "a key of version 1 after spheres in the seed program's format: write the "
               "spheres as {\"center\", \"radius\", \"material\"}");
  }
  format_ = Format::version_1;
  if (key == "particles") return JsonDelivery::by_item;
  return key == "materials" ? JsonDelivery::by_member : JsonDelivery::whole;
}

void SceneBuilder::on_member(const JsonMember& member) {
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
    finish_ = read_finish(member.value, place);
  } else if (member.key == "sky") {
    out_.scene.sky = read_sky(member.value, place);
  } else {
    out_.labels = read_labels(member.value, place);
  }
}

void SceneBuilder::on_child(const JsonMember& child) {
  if (keys_.back() == "materials") {
    add_material(child);
  } else if (keys_.back() == "particles") {
    add_particles(child.value);
  } else {
    add_sphere(child.value);
  }
}

/// Spheres of materials that others have used before, as most files write them.
std::size_t SceneBuilder::take_items(ByteSource& source) {
  if (keys_.back() != "spheres" || format_ != Format::version_1) return 0;
  constexpr std::size_t usual_bytes = 4096;
  std::vector<Sphere>& spheres = out_.scene.spheres;
  const std::size_t before = spheres.size();
  while (spheres.size() < limits::max_spheres) {
    const std::optional<SphereText> text = next_sphere_text(source.ahead(usual_bytes));
    const auto material = text ? names_.used(text->material) : std::nullopt;
    if (!material) break;
    spheres.push_back(text->sphere);
    spheres.back().material = *material;
    source.skip(text->bytes, text->newlines);
  }
  return spheres.size() - before;
}

void SceneBuilder::add_material(const JsonMember& member) {
  const JsonPlace section = root_.at("materials");
  const JsonPlace place = section.at(member.key);
  const Material material = read_material(member.value, place);
  if (!names_.define(member.key, material)) {
    place.fail(member.line, "duplicate key '" + printable(member.key) + "': remove one of them");
  }
  if (names_.size() > limits::max_materials) place.fail(member.line, too_many_materials);
}

void SceneBuilder::add_sphere(const JsonValue& value) {
  const std::size_t index = out_.scene.spheres.size();
  const JsonPlace section = root_.at("spheres");
  const JsonPlace place = section.at(index);
  if (index == limits::max_spheres) {
    place.fail(value.line,
               "more than " + std::to_string(limits::max_spheres) + " spheres: split the scene");
  }
  if (format_ == Format::unknown) {
    format_ = is_seed_sphere(value) ? Format::seed : Format::version_1;
  }
  if (format_ == Format::seed) {
    add_seed_sphere(value, place);
  } else {
    add_named_sphere(value, place);
  }
}

void SceneBuilder::add_seed_sphere(const JsonValue& value, const JsonPlace& place) {
  const SeedSphere read = read_seed_sphere(value, place);
  const std::optional<std::uint32_t> material = table_.intern(read.material);
  if (!material) place.fail(value.line, too_many_materials);
  out_.scene.spheres.push_back(read.sphere);
  out_.scene.spheres.back().material = *material;
}

void SceneBuilder::add_named_sphere(const JsonValue& value, const JsonPlace& place) {
  if (is_seed_sphere(value)) {
    place.fail(value.line,
               "a sphere in the seed program's format in a scene of version 1: write "
               "it as {\"center\", \"radius\", \"material\"}");
  }
  const NamedSphere read = read_sphere(value, place);
  const std::size_t index = out_.scene.spheres.size();
  out_.scene.spheres.push_back(read.sphere);
  out_.scene.spheres.back().material = names_.use(*read.material, index, read.material_line);
  if (names_.size() > limits::max_materials) place.fail(value.line, too_many_materials);
}

void SceneBuilder::add_particles(const JsonValue& value) {
  const JsonPlace section = root_.at("particles");
  const JsonPlace place = section.at(out_.particles.size());
  if (out_.particles.size() == limits::max_particle_files) {
    place.fail(value.line, "more than " + std::to_string(limits::max_particle_files) +
                               " files of particles: join some");
  }
  out_.particles.push_back(read_particle_source(value, place));
}

SceneFile SceneBuilder::finish(std::uint64_t start_line) {
  // No spheres and nothing else: the seed's format, with no item to show it.
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

void SceneBuilder::finish_version_1(std::uint64_t start_line) {
  for (const RequiredKey& required : required_keys) {
    if (has_key(required.key) || (required.unless_particles && has_key("particles"))) continue;
    fail_missing_key(required.key, start_line, root_, required.expectation);
  }
  if (style_ && !has_key("sky")) out_.scene.sky = sky_of(*style_);
  out_.finish = finish_.over(style_ ? finish_of(*style_) : Finish{});
  resolve_materials();
  out_.materials = std::move(names_);
}

/// Turns names into numbers of distinct materials, in the order in which spheres first use them.
void SceneBuilder::resolve_materials() {
  std::vector<std::optional<std::uint32_t>> numbers(names_.size());
  for (Sphere& sphere : out_.scene.spheres) {
    std::optional<std::uint32_t>& number = numbers[sphere.material];
    if (!number) number = resolve_material(sphere.material);
    sphere.material = *number;
  }
}

std::uint32_t SceneBuilder::resolve_material(std::uint32_t name) {
  const MaterialNames::Entry& entry = names_[name];
  if (entry.value) return *table_.intern(*entry.value);  // no more values than names
  const JsonPlace section = root_.at("spheres");
  const JsonPlace sphere = section.at(entry.first_sphere);
  sphere.at("material")
      .fail(entry.first_line, "unknown material '" + printable(names_.name_of(name)) +
                                  "': " + names_.remedy_for_undefined(names_.name_of(name)));
}

}  // namespace parray::input
