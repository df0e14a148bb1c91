#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "common/trace/tracer.h"

namespace parray::trace {

/// The value of trace_fingerprint() for this trace_version (proto/messages.h), with any compiler
/// and machine.
inline constexpr std::string_view pinned_fingerprint =
    "66ef74d674db1f7e92c437c65165de7a5e21abe5c15077a8296a813a4b3f4d2a";

/// Makes the tracer of a scene.
using TracerMaker = std::function<std::unique_ptr<PathTracer>(const Scene&, const RenderSettings&)>;

/// Returns the SHA-256 of a small built-in picture of spheres and capsules with every material, a
/// lens, nested and overlapping glass, traced with every sampler in every precision. Two builds
/// with the same value trace the same bits. Takes a few milliseconds. The coordinator refuses a
/// worker whose value differs from its own. `make` may, for example, always take the same
/// instruction set. Rethrows its exceptions.
std::string trace_fingerprint(const TracerMaker& make = [](const Scene& scene,
                                                           const RenderSettings& settings) {
  return make_path_tracer(scene, settings);
});

}  // namespace parray::trace
