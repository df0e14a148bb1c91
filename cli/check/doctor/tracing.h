#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "cli/check/doctor/check.h"
#include "cli/input/scene_file/scene_file.h"
#include "common/trace/selfcheck/fingerprint.h"

/// Whether this machine traces the right bits: a short form of tests/extremes.
namespace parray::doctor {

/// make_path_tracer() with that instruction set; everything else as the settings say.
TracerMaker tracers_of(Isa isa);

/// A small scene with every material, as a scene file: for pictures that several programs make.
extern const std::string_view doctor_scene_text;
SceneFile doctor_scene();

/// The built-in picture, in every precision, by linear search and through the tree.
Finding check_picture(const TracerMaker& make, std::string_view expected = pinned_fingerprint);

/// A closed furnace has no contrast: under a white sky every sample of white surfaces is exactly 1,
/// and inside a closed white ball exactly 0, in every precision, by linear search and the tree.
Finding check_furnaces(const TracerMaker& make);

/// Every path from a lone convex ball takes two segments: none meets the surface that it leaves.
Finding check_self_hits(const TracerMaker& make);

/// A scene scaled by 2^-40, 1 and 2^40 has the sums of the scalar definition (path.h), unscaled.
Finding check_scaling(const TracerMaker& make);

/// SHA-256 of the image that `threads` threads make of doctor_scene().
std::string doctor_image_sha256(const TracerMaker& make, int threads);
/// The same image from one thread and from all, twice each.
Finding check_threads(const TracerMaker& make, int threads);

/// Takes a small picture's hash `times` times in each of `threads` threads: bad memory, or a
/// processor beyond its limits, gives another one now and then.
Finding check_repetition(const std::function<std::string()>& picture, int times, int threads);

}  // namespace parray::doctor
