#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "cli/check/doctor/check.h"
#include "cli/input/scene_file/scene_file.h"
#include "common/trace/selfcheck/fingerprint.h"

/// Whether this machine traces the right bits.
namespace parray::doctor {

/// Returns make_path_tracer() for that instruction set.
TracerMaker tracers_of(Isa isa);

/// A small scene with every material, as a scene file, for pictures of several programs.
extern const std::string_view doctor_scene_text;
SceneFile doctor_scene();

/// Compares the built-in picture with its known bits, in every precision, with linear search and
/// the BVH.
CheckResult check_picture(const TracerMaker& make, std::string_view expected = pinned_fingerprint);

/// Returns the SHA-256 of the picture of doctor_scene() by `threads` threads.
std::string doctor_image_sha256(const TracerMaker& make, int threads);
/// Renders the picture of doctor_scene() with one thread and with `threads` threads, twice each.
CheckResult check_threads(const TracerMaker& make, int threads);

/// Calls `picture`, which returns a small picture's hash, `times` times in each of `threads`
/// threads. Bad memory or an overclocked processor changes the hash now and then. Throws RunError
/// if `picture` throws in a thread.
CheckResult check_repetition(const std::function<std::string()>& picture, int times, int threads);

}  // namespace parray::doctor
