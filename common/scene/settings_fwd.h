#pragma once

#include <cstdint>

#include "common/base/boxed.h"

namespace parray::scene {

// Declares the structs of settings.h for headers that only pass them on. Structs that many sources
// know hold `Boxed<RenderSettings>`.
struct PictureSettings;
struct StopSettings;
struct WorkSettings;
struct RenderSettings;

// Return values for sources that need nothing else of the settings; pixel_count() returns width
// times height.
std::uint32_t width_of(const RenderSettings& settings);
std::uint32_t height_of(const RenderSettings& settings);
std::uint64_t pixel_count(const RenderSettings& settings);
std::uint32_t max_depth_of(const RenderSettings& settings);
std::uint32_t samples_per_pixel_of(const RenderSettings& settings);
const PictureSettings& picture_of(const RenderSettings& settings);

}  // namespace parray::scene

extern template class parray::base::Boxed<parray::scene::RenderSettings>;
