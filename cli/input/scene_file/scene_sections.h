#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "cli/input/scene_file/finish.h"
#include "cli/input/scene_file/json_fields.h"
#include "cli/input/scene_file/json_value.h"
#include "cli/input/scene_file/label_settings.h"
#include "common/scene/scene.h"
#include "common/scene/settings_fwd.h"

/// The sections of scene JSON v1, each from its JSON. What they take is what
/// scenes/schema/scene.v1.schema.json says, and what a schema cannot say: cameras that look
/// nowhere, images of too many pixels.
namespace parray::input {

/// Each throws InputError that names the place and the line in the file.
void read_version(const JsonValue& value, const JsonPlace& place);
Camera read_camera(const JsonValue& value, const JsonPlace& place);
/// The keys of a camera.
std::span<const std::string_view> camera_keys();
/// The same of an object that may have other keys, too.
Camera camera_from(const JsonFields& fields);
Sky read_sky(const JsonValue& value, const JsonPlace& place);
FinishSection read_finish(const JsonValue& value, const JsonPlace& place);
LabelSettings read_labels(const JsonValue& value, const JsonPlace& place);
/// Sets what the section `image`, or else `render`, names.
void read_settings(const JsonValue& value, const JsonPlace& place, bool image,
                   RenderSettings& settings, bool& transparent);
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
