#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "cli/input/scene_file/json_value.h"
#include "cli/input/scene_file/label_settings.h"
#include "cli/input/scene_file/particle_source.h"
#include "cli/input/scene_file/postprocessing.h"
#include "common/scene/scene.h"
#include "common/scene/settings_fwd.h"

/// Readers of the sections of scene JSON v1. They accept what scenes/schema/scene.v1.schema.json
/// allows. They also reject what a schema cannot express, such as invalid cameras, images with too
/// many pixels, and contradictions between members.
namespace parray::input {

/// Each throws InputError with the place and the line in the file.
void read_version(const JsonValue& value, const JsonPlace& place);
Camera read_camera(const JsonValue& value, const JsonPlace& place);
/// Returns the keys of a camera.
std::span<const std::string_view> camera_keys();
/// Reads a camera from an object that may have further keys.
Camera camera_from(const JsonFields& fields);
Sky read_sky(const JsonValue& value, const JsonPlace& place);
PostprocessingSection read_postprocessing(const JsonValue& value, const JsonPlace& place);
LabelSettings read_labels(const JsonValue& value, const JsonPlace& place);
/// Sets those members of `settings` that the section `image` (or `render` if `image` is false)
/// names, and `transparent` if `image` names it.
void read_settings(const JsonValue& value, const JsonPlace& place, bool image,
                   RenderSettings& settings, bool& transparent);
Material read_material(const JsonValue& value, const JsonPlace& place);

/// Reads an item of the section `particles`.
ParticleSource read_particle_source(const JsonValue& value, const JsonPlace& place);
/// Throws InputError with the place and the line of the member `key` of the item at `place`. For a
/// member of a representation, the line is that where the representation starts. `source` is the
/// item and gives the lines.
[[noreturn]] void fail_in(const ParticleSource& source, const JsonPlace& place,
                          const std::string& key, const std::optional<std::size_t>& representation,
                          std::string_view problem);

/// Returns why a camera is not valid, with the remedy. Returns "" for a valid camera.
std::string problem_with(const Camera& camera);

/// Returns tan(vfov / 2), with vfov in degrees.
double tan_half_of(double vfov);

}  // namespace parray::input
