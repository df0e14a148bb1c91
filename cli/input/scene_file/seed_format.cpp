#include "cli/input/scene_file/seed_format.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "cli/input/scene_file/json_fields.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/scene/scene_ranges.h"

namespace parray::input {
namespace {

/// {"x": 1, "y": 2, "z": 3}, or the same with other names.
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
  static constexpr std::array<std::string_view, 4> keys{"type", "color", "fuzz",
                                                        "refraction_index"};
  static constexpr std::array<std::string_view, 3> types{"lambertian", "metal", "dielectric"};
  static constexpr std::array<std::string_view, 2> lambertian_keys{"type", "color"};
  static constexpr std::array<std::string_view, 3> metal_keys{"type", "color", "fuzz"};
  static constexpr std::array<std::string_view, 2> dielectric_keys{"type", "refraction_index"};
  const JsonFields all(value, place, keys);
  const std::string& type = all.string("type");
  Material material;
  if (type == "lambertian") {
    material.albedo = read_color(JsonFields(value, place, lambertian_keys));
  } else if (type == "metal") {
    const JsonFields fields(value, place, metal_keys);
    material.type = MaterialType::metal;
    material.albedo = read_color(fields);
    material.fuzz = fields.number("fuzz", ranges::unit_interval);
  } else if (type == "dielectric") {
    material.type = MaterialType::dielectric;
    material.ior =
        JsonFields(value, place, dielectric_keys).number("refraction_index", ranges::ior);
  } else {
    place.at("type").fail(all.find("type")->line, "unknown material type '" + printable(type) +
                                                      "': " + remedy_for_name(type, types));
  }
  return material;
}

}  // namespace

bool is_seed_sphere(const JsonValue& value) {
  return std::ranges::find(value.members, "sphere", &JsonMember::key) != value.members.end();
}

SeedSphere read_seed_sphere(const JsonValue& value, const JsonPlace& place) {
  static constexpr std::array<std::string_view, 1> outer_keys{"sphere"};
  static constexpr std::array<std::string_view, 3> keys{"location", "material", "radius"};
  const JsonFields outer(value, place, outer_keys);
  const JsonPlace inner = place.at("sphere");
  const JsonFields fields(outer.any("sphere", "the sphere"), inner, keys);
  SeedSphere out;
  out.sphere.center = read_named_vec3(fields, "location", {"x", "y", "z"}, ranges::coordinate);
  out.sphere.radius = fields.number("radius", ranges::length);
  out.material =
      read_seed_material(fields.any("material", "{ ... } with its type"), inner.at("material"));
  return out;
}

}  // namespace parray::input
