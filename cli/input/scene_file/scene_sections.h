#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "cli/input/scene_file/json_fields.h"
#include "cli/input/scene_file/json_value.h"
#include "common/scene/scene.h"
#include "common/scene/settings.h"

/// The sections of scene JSON v1, each from its JSON. What they take is what
/// scenes/schema/scene.v1.schema.json says, and what a schema cannot say: cameras that look
/// nowhere, images of too many pixels.
namespace parray::input {

/// Each throws InputError that names the place and the line in the file.
void read_version(const JsonValue& value, const JsonPlace& place);
Camera read_camera(const JsonValue& value, const JsonPlace& place);
/// The keys of a camera.
inline constexpr std::array<std::string_view, 8> camera_keys{
    "look_from", "look_at",     "up",       "projection",
    "vfov",      "view_height", "aperture", "focus_distance"};
/// Names of projections, in their order.
inline constexpr std::array<std::string_view, 2> projection_names{"perspective", "orthographic"};
/// The same of an object that may have other keys, too.
Camera camera_from(const JsonFields& fields);
Sky read_sky(const JsonValue& value, const JsonPlace& place);
/// Sets width and height of `settings`, where the section names them, and `transparent` likewise.
void read_image(const JsonValue& value, const JsonPlace& place, RenderSettings& settings,
                bool& transparent);
/// Sets samples_per_pixel, max_depth and seed of `settings`, where the section names them.
void read_render(const JsonValue& value, const JsonPlace& place, RenderSettings& settings);
Material read_material(const JsonValue& value, const JsonPlace& place);

/// A sphere whose material is still a name.
struct NamedSphere {
  Sphere sphere;                ///< `material` is not set
  const std::string* material;  ///< refers to the JSON
  std::uint64_t material_line;
};
NamedSphere read_sphere(const JsonValue& value, const JsonPlace& place);

/// Why a camera sees nothing, with the remedy; empty: it does.
std::string problem_with(const Camera& camera);

/// tan(vfov / 2), vfov in degrees.
double tan_half_of(double vfov);

}  // namespace parray::input
