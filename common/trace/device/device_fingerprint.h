#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "common/image/pixel_sums.h"
#include "common/scene/scene.h"
#include "common/scene/settings_fwd.h"

namespace parray::trace {

/// Traces all samples of a picture: adds them to `pixels` (row after row) and to `counts`.
using PictureTracer = std::function<void(const Scene& scene, const RenderSettings& settings,
                                         std::span<PixelSums> pixels, TraceCounts& counts)>;

/// Returns the SHA-256 of 100,800 samples that show whether a device computes by IEEE 754. Their
/// scenes have radii from 1e-15 to 1e15, coincident shapes, touching shapes, denormal colours and
/// positions whose squares are denormal, overlapping glass, and cameras inside of shapes. Each
/// scene is traced in every precision. Rethrows the exceptions of `trace`.
std::string device_fingerprint(const PictureTracer& trace);

/// The value of device_fingerprint() for this trace_version (proto/messages.h).
inline constexpr std::string_view pinned_device_fingerprint =
    "090981e98de16a59387e3b6d0d2711e69fd9e2548a7d39ae8ce2b8924f15d4b1";

}  // namespace parray::trace
