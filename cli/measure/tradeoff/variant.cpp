#include "cli/measure/tradeoff/variant.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "cli/output/text.h"
#include "common/base/printable.h"
#include "common/scene/limits.h"
#include "common/scene/settings.h"

namespace parray::tradeoff {
namespace {

constexpr std::uint32_t least_samples = 16;
constexpr std::uint32_t most_samples = 4096;
constexpr double shorter_side = 200;
/// 1/100 of the speed of a slow machine.
constexpr double samples_a_second = 250'000;

std::string stop_options(const RenderSettings& settings) {
  if (settings.target_error > 0) {
    return std::string(settings.adaptive ? "" : " --adaptive off") + " --target-error " +
           number_text(settings.target_error);
  }
  return (settings.adaptive ? " --adaptive on --spp " : " --spp ") +
         std::to_string(settings.samples_per_pixel);
}

std::string sampler_options(const RenderSettings& settings) {
  return "--sampler " + std::string(name_of(settings.sampler)) + stop_options(settings);
}

/// Returns the options of settings. `named` decides which of three members they name.
std::string options_where(const RenderSettings& s, const auto& named) {
  std::string text = sampler_options(s);
  if (named(&RenderSettings::max_depth)) text += " --max-depth " + std::to_string(s.max_depth);
  const auto add = [&](auto member, const char* option) {
    if (named(member)) text += option + std::string(name_of(s.*member));
  };
  add(&RenderSettings::precision, " --precision ");
  add(&RenderSettings::accelerator, " --accelerator ");
  if (s.isa != Isa::automatic) text += " --isa " + std::string(name_of(s.isa));
  return text + (s.replicates ? " --denoise" : "");
}

/// Returns the FNV-1a hash of a text. It is the same on every machine.
std::uint64_t hash_of(const std::string& text) {
  std::uint64_t hash = 0xCBF29CE484222325;
  for (const char letter : text) hash = (hash ^ static_cast<unsigned char>(letter)) * 0x100000001B3;
  return hash;
}

/// Returns a seed. Its two highest bits are the use, so that different uses have different seeds.
std::uint64_t seed_for(std::uint64_t use, std::uint64_t base, std::uint64_t number) {
  constexpr std::uint64_t low = (std::uint64_t{1} << 62) - 1;
  return use << 62 | ((base * 0x9E3779B97F4A7C15 + number) & low);
}

/// Rounds to two significant digits, as a person would write the number.
double rounded(double value) { return std::stod(formatted("%.2g", value)); }

std::uint32_t scaled_side(std::uint32_t side, double factor) {
  const double scaled = std::round(side * factor);
  return static_cast<std::uint32_t>(
      std::clamp(scaled, 1.0, static_cast<double>(limits::max_image_side)));
}

/// Collects variants, with as many runs as their share of the time allows.
class Planner {
 public:
  Planner(const RenderSettings& base, const Pilot& pilot, double seconds)
      : base_(base), pilot_(pilot), seconds_(seconds) {}

  /// Adds a variant, unless it is known. `samples`: expected samples per pixel. Returns false if
  /// there is no time for it.
  bool add(VariedSetting varied, const RenderSettings& settings, double samples, double speed = 0) {
    const std::string options = options_of(settings);
    if (!known_.insert(options).second) return true;
    const double one = cost(samples, speed > 0 ? speed : pilot_.samples_per_second) +
                       (settings.replicates ? pilot_.denoise : 0);
    const bool first =
        varied != VariedSetting::accelerator && begun_.insert({varied, settings.sampler}).second;
    const bool needed = first || varied == VariedSetting::also;
    const std::uint32_t runs =
        varied == VariedSetting::denoise ? denoised_runs_of(one, needed) : runs_of(one, needed);
    if (runs == 0) {
      sweep_.left_out.push_back(options);
      return false;
    }
    sweep_.variants.push_back({varied, settings, runs});
    return true;
  }

  /// Returns the samples per pixel for varying other settings: few, so that there can be many runs.
  [[nodiscard]] std::uint32_t setting_samples() const {
    for (const std::uint32_t samples : {64U, 32U}) {
      if (8 * cost(samples, pilot_.samples_per_second) <= seconds_ / 40) return samples;
    }
    return least_samples;
  }

  Sweep take() { return std::move(sweep_); }

 private:
  [[nodiscard]] double cost(double samples, double speed) const {
    return pilot_.overhead + samples * base_.width * base_.height / speed;
  }
  /// Returns the number of runs: many if they are short, few if they are long.
  [[nodiscard]] std::uint32_t runs_of(double one, bool needed) const {
    if (16 * one <= seconds_ / 60) return 16;
    if (8 * one <= seconds_ / 25) return 8;
    return 4 * one <= seconds_ / 12 ? 4 : needed ? 2 : 0;
  }
  /// Returns the number of runs with denoising. All are long, because denoising takes the same time
  /// for any number of samples.
  [[nodiscard]] std::uint32_t denoised_runs_of(double one, bool needed) const {
    return 4 * one <= seconds_ / 24 ? 4 : 2 * one <= seconds_ / 24 || needed ? 2 : 0;
  }

  const RenderSettings& base_;
  const Pilot& pilot_;
  const double seconds_;
  Sweep sweep_;
  std::set<std::string> known_;
  std::set<std::pair<VariedSetting, Sampler>> begun_;
};

RenderSettings uniform(RenderSettings settings, Sampler sampler, std::uint32_t samples) {
  settings.sampler = sampler;
  settings.samples_per_pixel = samples;
  return settings;
}

/// Returns the samples per pixel of adaptive passes to `share` of the pilot's error.
double expected_samples(double share) { return Pilot::samples / (share * share) / 1.5; }

double samples_of(const RenderSettings& settings, const Pilot& pilot) {
  const bool targeted = settings.target_error > 0 && pilot.error > 0;
  const double samples = targeted ? expected_samples(settings.target_error / pilot.error) : 1e9;
  return std::min<double>(samples, settings.samples_per_pixel);
}

constexpr std::array samplers = {Sampler::independent, Sampler::sobol};

void add_targets(const RenderSettings& base, const Pilot& pilot, Planner& planner) {
  if (!(pilot.error > 0)) return;  // the picture has no noise
  // Begins below the error of the first pass. Each target needs four times the work of the
  // previous.
  for (double target = pilot.error / 2; target > 1e-9; target /= 2) {
    const double share = target / pilot.error;
    bool any = false;
    for (const Sampler sampler : samplers) {
      any |= planner.add(VariedSetting::target, with_target(base, sampler, rounded(target)),
                         expected_samples(share));
    }
    if (!any) break;
  }
}

/// Adds denoised pictures, each of four times as many samples as the one before. Targets are left
/// out: `parray render --denoise --target-error` traces until the denoised picture meets its
/// target.
void add_denoised(const RenderSettings& base, Planner& planner) {
  for (std::uint32_t samples = least_samples; samples <= most_samples; samples *= 4) {
    const RenderSettings settings = uniform(base, Sampler::sobol, samples);
    if (!planner.add(VariedSetting::denoise, with_denoise(settings, true), samples)) break;
  }
}

}  // namespace

std::string_view name_of(VariedSetting varied) {
  constexpr std::array<std::string_view, 9> known = {
      "scene", "also", "spp", "target", "denoise", "depth", "precision", "accelerator", "answer"};
  return known.at(static_cast<std::size_t>(varied));
}

double pixels_of(const RenderSettings& settings) {
  return static_cast<double>(pixel_count(settings));
}

std::string options_of(const RenderSettings& settings) {
  return options_where(settings, [](auto /*member*/) { return true; });
}

std::string options_against(const RenderSettings& settings, const RenderSettings& base) {
  return options_where(settings, [&](auto member) { return settings.*member != base.*member; });
}

std::uint64_t seed_of(const RenderSettings& settings, std::uint64_t base, std::uint32_t run) {
  return seed_for(0, base, hash_of(sampler_options(settings)) + run);
}
std::uint64_t reference_seed(std::uint64_t base, std::uint64_t chunk) {
  return seed_for(1, base, chunk);
}
std::uint64_t paired_seed(std::uint64_t base, std::uint32_t pair) {
  return seed_for(2, base, pair);
}

RenderSettings with_target(RenderSettings settings, Sampler sampler, double target) {
  settings.sampler = sampler;
  settings.samples_per_pixel = limits::max_samples_per_pixel;
  settings.adaptive = true;
  settings.target_error = target;
  return settings;
}

RenderSettings with_denoise(RenderSettings settings, bool denoise) {
  settings.replicates = denoise;
  return settings;
}

RenderSettings with_size(RenderSettings settings, std::uint32_t width, std::uint32_t height,
                         double seconds) {
  const double across = settings.width;
  const double down = settings.height;
  if (width == 0 && height == 0) {
    const double most = std::max(seconds * samples_a_second / settings.samples_per_pixel, 2000.0);
    const double factor =
        std::min({1.0, shorter_side / std::min(across, down), std::sqrt(most / (across * down))});
    settings.width = scaled_side(settings.width, factor);
    settings.height = scaled_side(settings.height, factor);
    return settings;
  }
  settings.width = width > 0 ? width : scaled_side(settings.width, height / down);
  settings.height = height > 0 ? height : scaled_side(settings.height, width / across);
  return settings;
}

std::uint32_t reference_depth(std::uint32_t base_depth) {
  return std::min(std::max(4 * std::min(base_depth, limits::max_depth / 4), 50U),
                  limits::max_depth);
}

std::vector<std::uint32_t> depths_of(std::uint32_t base_depth) {
  std::set<std::uint32_t> depths = {base_depth};
  for (const std::uint32_t depth : {2U, 3U, 5U, base_depth / 2, 2 * base_depth}) {
    if (depth >= 2 && depth < reference_depth(base_depth)) depths.insert(depth);
  }
  return {depths.begin(), depths.end()};
}

Sweep plan_sweep(const RenderSettings& base, const std::vector<Boxed<RenderSettings>>& also,
                 const Pilot& pilot, double seconds) {
  Planner planner(base, pilot, seconds);
  planner.add(VariedSetting::scene, base, base.samples_per_pixel);
  for (const Boxed<RenderSettings>& boxed : also) {
    const RenderSettings& settings = *boxed;
    const auto speed = pilot.other_speeds.find(settings.accelerator);
    planner.add(VariedSetting::also, settings, samples_of(settings, pilot),
                speed == pilot.other_speeds.end() ? 0 : speed->second);
  }
  const Sampler own = base.sampler;
  for (std::uint32_t samples = least_samples; samples <= most_samples; samples *= 2) {
    bool any = false;
    for (const Sampler sampler : samplers) {
      any |= planner.add(VariedSetting::spp, uniform(base, sampler, samples), samples);
    }
    if (!any) break;
  }
  add_targets(base, pilot, planner);
  add_denoised(base, planner);
  const std::uint32_t setting_samples = planner.setting_samples();
  RenderSettings turned = uniform(base, own, setting_samples);
  for (const std::uint32_t depth : depths_of(base.max_depth)) {
    turned.max_depth = depth;
    planner.add(VariedSetting::depth, turned, setting_samples);
  }
  turned = uniform(base, own, setting_samples);
  for (const Precision precision : {Precision::f32, Precision::mixed, Precision::f64}) {
    turned.precision = precision;
    planner.add(VariedSetting::precision, turned, setting_samples);
  }
  // Uses few samples, because some accelerators are very slow.
  turned = uniform(base, own, least_samples);
  for (const auto& [accelerator, speed] : pilot.other_speeds) {
    turned.accelerator = accelerator;
    planner.add(VariedSetting::accelerator, turned, least_samples, speed);
  }
  return planner.take();
}

}  // namespace parray::tradeoff
