#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "cli/check/doctor/check.h"
#include "cli/input/scene_file/scene_file.h"
#include "common/trace/selfcheck/fingerprint.h"

/// Checks whether this machine traces the right bits.
namespace parray::doctor {

/// Returns a function that makes tracers of `isa`, whatever the settings say.
TracerMaker tracers_of(Isa isa);

/// A small scene with every material, as the text of a scene file. parray and parray-mpi must make
/// the same picture of it.
extern const std::string_view doctor_scene_text;
SceneFile doctor_scene();

/// Compares trace_fingerprint(), the built-in picture in every precision, with its known bits, with
/// linear search and with the BVH.
CheckResult check_picture(const TracerMaker& make, std::string_view expected = pinned_fingerprint);

/// Returns the SHA-256 of the picture of doctor_scene() by `threads` threads.
std::string doctor_image_sha256(const TracerMaker& make, int threads);
/// Renders the picture of doctor_scene() with one thread and with `threads` threads, twice each.
/// Fails if any of these pictures differ.
CheckResult check_threads(const TracerMaker& make, int threads);

/// Calls `picture`, which returns a small picture's hash, `times` times in each of `threads`
/// threads. Fails if a hash differs from that of a first call. Bad memory or an overclocked
/// processor changes the hash now and then. Throws RunError if `picture` throws in a thread.
CheckResult check_repetition(const std::function<std::string()>& picture, int times, int threads);

}  // namespace parray::doctor
