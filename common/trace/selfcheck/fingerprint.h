#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "common/trace/tracer.h"

namespace parray::trace {

/// SHA-256 of a small built-in picture, with every material, a lens and nested glass, traced with
/// every sampler in every precision: two builds that agree on it trace the same bits. Takes a few
/// milliseconds.
std::string trace_fingerprint();

/// What it is for this trace_version (proto/messages.h), whatever the compiler and the machine.
inline constexpr std::string_view pinned_fingerprint =
    "8ecfb48df8efcc1326fba13fd47b8d326affc517beb8aab7435e0ac5396582d9";

/// Makes the tracer of a scene: make_path_tracer(), or one that insists on a choice.
using TracerMaker = std::function<std::unique_ptr<PathTracer>(const Scene&, const RenderSettings&)>;

/// The same picture by tracers of `make`. Throws what it throws.
std::string trace_fingerprint(const TracerMaker& make);

}  // namespace parray::trace
