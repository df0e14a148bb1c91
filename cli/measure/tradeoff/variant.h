#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "common/scene/settings.h"

/// Which settings a trade of speed for accuracy tries. Pure functions.
namespace parray::tradeoff {

/// Why settings are tried.
enum class Knob : std::uint8_t {
  scene,
  also,
  spp,
  target,
  denoise,
  depth,
  precision,
  accelerator,
  answer
};
std::string_view name_of(Knob knob);

/// Settings to be measured by several short renders with seeds of their own.
struct Variant {
  Knob knob = Knob::spp;
  RenderSettings settings;  ///< resolved; the seed is replaced by seed_of()
  std::uint32_t runs = 0;
};

/// Pixels of a picture.
inline double pixels_of(const RenderSettings& settings) {
  return static_cast<double>(settings.width) * settings.height;
}

/// The canonical form of settings, as options of `parray render`: what measurements are kept under.
/// Settings that keep their replicates are those of pictures that are denoised (--denoise).
std::string options_of(const RenderSettings& settings);

/// The same, without what `base` has, too: what somebody has to type. --sampler and where to stop
/// are always there.
std::string options_against(const RenderSettings& settings, const RenderSettings& base);

/// Seeds of different uses are apart; `base` is the scene's. Settings that differ in nothing but
/// depth, precision, accelerator and --denoise share theirs, so that what they differ by shows.
std::uint64_t seed_of(const RenderSettings& settings, std::uint64_t base, std::uint32_t run);
std::uint64_t reference_seed(std::uint64_t base, std::uint64_t chunk);
std::uint64_t paired_seed(std::uint64_t base, std::uint32_t pair);

/// Adaptive passes to a target error in linear radiance, as `parray render --target-error` makes
/// them: the scene's own number of samples is no bound.
RenderSettings with_target(RenderSettings settings, Sampler sampler, double target);

/// The same picture, denoised or not.
RenderSettings with_denoise(RenderSettings settings, bool denoise);

/// `settings` with the picture scaled down to 200 pixels on the shorter side at most, and further,
/// to 2000 pixels at least, so that a picture with the scene's own samples fits a time of `seconds`
/// many times; unless sides are given (0: not): one side alone keeps the shape.
RenderSettings with_size(RenderSettings settings, std::uint32_t width, std::uint32_t height,
                         double seconds);

/// What is known of a scene on this machine before the sweep.
struct Pilot {
  double samples_per_second = 0;                   ///< of the scene's own settings
  std::map<AcceleratorKind, double> other_speeds;  ///< likewise; without those that would not end
  double overhead = 0;                             ///< seconds a render, without samples
  double error = 0;                                ///< RMSE at pilot_samples
  double denoise = 0;                              ///< seconds that denoising takes
};
inline constexpr std::uint32_t pilot_samples = 16;
/// More spheres than that are never searched one by one.
inline constexpr std::size_t most_linear = 4096;
/// Nor by the octree, whose build takes long.
inline constexpr std::size_t most_octree = 100'000;

struct Sweep {
  std::vector<Variant> variants;      ///< each with a canonical form of its own
  std::vector<std::string> left_out;  ///< canonical forms: what would have taken too long
};
/// Not the product of all knobs, but a line along each through the scene's own settings `base`:
/// samples a pixel from 16 on by doubling, of each sampler; targets of adaptive passes likewise;
/// some of both with Sobol samples, denoised; depths from 2 to twice the base's; precisions;
/// accelerators. What takes longer than its share of
/// `seconds` gets fewer runs (16, 8 or 4; denoised: 4 or 2), or is left out; `base`, `also` and the
/// first settings of each knob but the last get 2 at least.
Sweep plan_sweep(const RenderSettings& base, const std::vector<RenderSettings>& also,
                 const Pilot& pilot, double seconds);

/// Depths that are tried: ascending, base_depth among them, below reference_depth().
std::vector<std::uint32_t> depths_of(std::uint32_t base_depth);
/// Deep enough to count as endless.
std::uint32_t reference_depth(std::uint32_t base_depth);

}  // namespace parray::tradeoff
