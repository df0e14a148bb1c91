#pragma once

#include "cli/input/scene_file/json_value.h"
#include "common/scene/scene.h"

/// The scene format of the program that ParRay grew from: {"spheres": [{"sphere": {"location":
/// {x, y, z}, "material": {...}, "radius": r}}]} and nothing else. Camera, image and settings are
/// the defaults of Camera and RenderSettings.
namespace parray::input {

struct SeedSphere {
  Sphere sphere;  ///< `material` is not set
  Material material;
};

/// Whether an item of "spheres" has this format's shape.
bool is_seed_sphere(const JsonValue& value);

/// Throws InputError as the readers of scene_sections.h do, in the same ranges.
SeedSphere read_seed_sphere(const JsonValue& value, const JsonPlace& place);

}  // namespace parray::input
