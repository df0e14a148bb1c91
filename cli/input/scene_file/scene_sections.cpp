#include "cli/input/scene_file/scene_sections.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>

#include "cli/input/scene_file/json_fields.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/scene/limits.h"
#include "common/scene/scene_ranges.h"

namespace parray::input {
namespace {

/// Least sine of the angle between `up` and the view. Any nearer, and the last digits of `up`
/// decide how the picture is turned.
constexpr double min_up_sine = 1e-6;

}  // namespace

std::string problem_with(const Camera& camera) {
  const Vec3d view = camera.look_at - camera.look_from;
  const double distance = length(view);
  if (distance == 0) return "look_from and look_at are the same point: move one";
  if (distance < limits::min_radius || distance > limits::max_length) {
    return "look_from and look_at are " + number_text(distance) + " apart: bring that between " +
           number_text(limits::min_radius) + " and " + number_text(limits::max_length);
  }
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
  place.fail(value.line, "version " + std::to_string(version) +
                             " is newer than this program: use one that knows it, or version 1");
}

namespace {

Projection read_projection(const JsonFields& fields) {
  const JsonValue* const value = fields.find("projection");
  if (value == nullptr) return Projection::perspective;
  const std::string& name = fields.string("projection");
  const auto* const found = std::find(projection_names.begin(), projection_names.end(), name);
  if (found == projection_names.end()) {
    fields.place()
        .at("projection")
        .fail(value->line, "unknown projection '" + printable(name) +
                               "': " + remedy_for_name(name, projection_names));
  }
  return static_cast<Projection>(found - projection_names.begin());
}

/// Throws InputError if the camera has a key that its projection does not use.
void refuse(const JsonFields& fields, std::string_view key, const std::string& problem) {
  const JsonValue* const value = fields.find(key);
  if (value != nullptr) fields.place().at(key).fail(value->line, problem);
}

/// How much of the scene it sees.
void read_view(const JsonFields& fields, Camera& camera) {
  camera.projection = read_projection(fields);
  if (camera.projection == Projection::orthographic) {
    refuse(fields, "vfov",
           "an orthographic camera has no angle of view: leave it out, and give view_height");
    camera.view_height = fields.number("view_height", ranges::length);
    camera.vfov = 0;
  } else {
    refuse(fields, "view_height",
           "a perspective camera has an angle of view instead: leave it out, and give vfov, or "
           "\"projection\": \"orthographic\"");
    camera.vfov = fields.number("vfov", ranges::vfov);
    camera.tan_half_vfov = tan_half_of(camera.vfov);
  }
}

}  // namespace

Camera read_camera(const JsonValue& value, const JsonPlace& place) {
  return camera_from(JsonFields(value, place, camera_keys));
}

Camera camera_from(const JsonFields& fields) {
  Camera camera;
  camera.look_from = fields.vec3("look_from", ranges::coordinate);
  camera.look_at = fields.vec3("look_at", ranges::coordinate);
  camera.up = fields.vec3_or("up", ranges::coordinate, {0, 1, 0});
  read_view(fields, camera);
  camera.aperture = fields.number_or("aperture", ranges::aperture, 0);
  camera.focus_distance =
      fields.number_or("focus_distance", ranges::length, length(camera.look_at - camera.look_from));
  const std::string problem = problem_with(camera);
  if (!problem.empty()) fields.place().fail(fields.line(), problem);
  return camera;
}

Sky read_sky(const JsonValue& value, const JsonPlace& place) {
  static constexpr std::array<std::string_view, 2> keys{"horizon", "zenith"};
  const JsonFields fields(value, place, keys);
  const Sky usual;
  return {fields.vec3_or("horizon", ranges::radiance, usual.horizon),
          fields.vec3_or("zenith", ranges::radiance, usual.zenith)};
}

void read_image(const JsonValue& value, const JsonPlace& place, RenderSettings& settings,
                bool& transparent) {
  static constexpr std::array<std::string_view, 3> keys{"width", "height", "transparent"};
  const JsonFields fields(value, place, keys);
  const IntegerRange sides{1, limits::max_image_side};
  const std::uint64_t width = fields.integer_or("width", sides, settings.width);
  const std::uint64_t height = fields.integer_or("height", sides, settings.height);
  if (width * height > limits::max_pixels) {
    place.fail(value.line, "image of " + std::to_string(width) + " x " + std::to_string(height) +
                               " pixels is too large: use at most " +
                               std::to_string(limits::max_pixels) + " pixels");
  }
  settings.width = static_cast<std::uint32_t>(width);
  settings.height = static_cast<std::uint32_t>(height);
  transparent = fields.boolean_or("transparent", transparent);
}

void read_render(const JsonValue& value, const JsonPlace& place, RenderSettings& settings) {
  static constexpr std::array<std::string_view, 3> keys{"samples_per_pixel", "max_depth", "seed"};
  const JsonFields fields(value, place, keys);
  settings.samples_per_pixel = static_cast<std::uint32_t>(fields.integer_or(
      "samples_per_pixel", {1, limits::max_samples_per_pixel}, settings.samples_per_pixel));
  settings.max_depth = static_cast<std::uint32_t>(
      fields.integer_or("max_depth", {1, limits::max_depth}, settings.max_depth));
  settings.seed = fields.integer_or("seed", {0, UINT64_MAX}, settings.seed);
}

Material read_material(const JsonValue& value, const JsonPlace& place) {
  static constexpr std::array<std::string_view, 4> keys{"type", "albedo", "fuzz", "ior"};
  static constexpr std::array<std::string_view, 3> types{"diffuse", "metal", "dielectric"};
  static constexpr std::array<std::string_view, 2> diffuse_keys{"type", "albedo"};
  static constexpr std::array<std::string_view, 3> metal_keys{"type", "albedo", "fuzz"};
  static constexpr std::array<std::string_view, 2> dielectric_keys{"type", "ior"};
  const JsonFields all(value, place, keys);
  const std::string& type = all.string("type");
  Material material;
  if (type == "diffuse") {
    const JsonFields fields(value, place, diffuse_keys);
    material.albedo = fields.vec3("albedo", ranges::unit_interval);
  } else if (type == "metal") {
    const JsonFields fields(value, place, metal_keys);
    material.type = MaterialType::metal;
    material.albedo = fields.vec3("albedo", ranges::unit_interval);
    material.fuzz = fields.number_or("fuzz", ranges::unit_interval, 0);
  } else if (type == "dielectric") {
    const JsonFields fields(value, place, dielectric_keys);
    material.type = MaterialType::dielectric;
    material.ior = fields.number("ior", ranges::ior);
  } else {
    place.at("type").fail(all.find("type")->line, "unknown material type '" + printable(type) +
                                                      "': " + remedy_for_name(type, types));
  }
  return material;
}

NamedSphere read_sphere(const JsonValue& value, const JsonPlace& place) {
  static constexpr std::array<std::string_view, 3> keys{"center", "radius", "material"};
  const JsonFields fields(value, place, keys);
  NamedSphere out;
  out.sphere.center = fields.vec3("center", ranges::coordinate);
  out.sphere.radius = fields.number("radius", ranges::length);
  out.material = &fields.string("material");
  out.material_line = fields.find("material")->line;
  return out;
}

}  // namespace parray::input
