#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "common/scene/setting_choices.h"
#include "common/scene/settings_fwd.h"

/// The settings that `parray tradeoff` tries. Pure functions.
namespace parray::tradeoff {

/// The setting that a variant varies, or another reason to measure it.
enum class VariedSetting : std::uint8_t {
  scene,  ///< the scene's own settings
  also,   ///< settings that the user gives with --also
  spp,
  target,
  denoise,
  depth,
  precision,
  accelerator,
  answer  ///< a candidate of the answer
};
std::string_view name_of(VariedSetting varied);

/// Settings to measure in several short renders, each with its own seed.
struct Variant {
  VariedSetting varied = VariedSetting::spp;
  Boxed<RenderSettings> settings;  ///< no value is `automatic`; seed_of() replaces the seed
  std::uint32_t runs = 0;          ///< number of renders
};

/// Returns the number of pixels of a picture.
double pixels_of(const RenderSettings& settings);

/// Returns the canonical form of settings, as options of `parray render`. It is the key of
/// measurements. Settings with `replicates` are those of denoised pictures (--denoise).
std::string options_of(const RenderSettings& settings);

/// Returns the options that a user has to type to change `base` into `settings`. Always contains
/// --sampler and the option that ends the render.
std::string options_against(const RenderSettings& settings, const RenderSettings& base);

/// Return the seed of a render: run number `run` of settings, render number `chunk` of the
/// reference, or pair number `pair`. `base` is the scene's seed. These three uses have different
/// seeds. Settings that differ only in depth, precision, accelerator, instruction set or --denoise
/// share their seeds, so that the noise does not hide the difference.
std::uint64_t seed_of(const RenderSettings& settings, std::uint64_t base, std::uint32_t run);
std::uint64_t reference_seed(std::uint64_t base, std::uint64_t chunk);
std::uint64_t paired_seed(std::uint64_t base, std::uint32_t pair);

/// Returns settings for adaptive passes to a target error in linear radiance, as for `parray render
/// --target-error`: the scene's own number of samples is no limit.
RenderSettings with_target(RenderSettings settings, Sampler sampler, double target);

/// Returns the same settings with or without denoising.
RenderSettings with_denoise(RenderSettings settings, bool denoise);

/// Returns `settings` with a smaller picture: at most 200 pixels on the shorter side. Reduces it
/// further, but not below 2000 pixels, until `seconds` suffice for many pictures with the scene's
/// own samples. If `width` or `height` is above 0, uses that size instead; one alone keeps the
/// aspect ratio. Sizes are in pixels.
RenderSettings with_size(RenderSettings settings, std::uint32_t width, std::uint32_t height,
                         double seconds);

/// Measurements of a scene on this machine before the sweep.
struct Pilot {
  static constexpr std::uint32_t samples = 16;  ///< per pixel of its picture
  double samples_per_second = 0;                ///< of the scene's own settings
  std::map<AcceleratorKind, double>
      other_speeds;     ///< the same for other accelerators; those that take too long are missing
  double overhead = 0;  ///< seconds per render without samples
  double error = 0;     ///< RMSE of its picture; 0: the picture has no noise
  double denoise = 0;   ///< seconds of denoising one picture
};
/// Scenes with more spheres do not try linear search.
inline constexpr std::size_t most_linear = 4096;
/// Scenes with more spheres do not try the octree: its build takes too long.
inline constexpr std::size_t most_octree = 100'000;

/// The settings to measure.
struct Sweep {
  std::vector<Variant> variants;      ///< options_of() differs for all of them
  std::vector<std::string> left_out;  ///< settings that take too long, by options_of()
};
/// Varies one setting of `base` at a time, not all combinations. Tries samples per pixel from 16 to
/// 4096 by doubling, and targets of adaptive passes, for each sampler; 16, 64, 256 ... Sobol
/// samples with denoising; the depths depths_of(); precisions; accelerators. Settings that exceed
/// their share of `seconds` get fewer runs (16, 8 or 4; denoised: 4 or 2), or are left out.
/// Some settings get at least 2 runs: `base`, `also` and, for each sampler, the first settings of
/// each VariedSetting except `accelerator`.
Sweep plan_sweep(const RenderSettings& base, const std::vector<Boxed<RenderSettings>>& also,
                 const Pilot& pilot, double seconds);

/// Returns the path depths to try, in ascending order: `base_depth` and some others below
/// reference_depth().
std::vector<std::uint32_t> depths_of(std::uint32_t base_depth);
/// Returns a path depth so large that it counts as unlimited.
std::uint32_t reference_depth(std::uint32_t base_depth);

}  // namespace parray::tradeoff
