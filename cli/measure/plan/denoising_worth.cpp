#include "cli/measure/plan/denoising_worth.h"

#include <algorithm>
#include <cmath>

#include "cli/farm/direct_render.h"
#include "cli/measure/plan/effort.h"
#include "cli/measure/plan/part_of_picture.h"
#include "cli/output/denoise/denoise.h"
#include "cli/output/text.h"
#include "common/adaptive/error_estimate.h"
#include "common/adaptive/replicates.h"
#include "common/scene/settings.h"

namespace parray::plan {
namespace {

constexpr double share_exponent = 0.55;
constexpr double sobol_exponent = 1.25;

double raw_square(const DenoisingProbe& probe, Sampler sampler, double samples) {
  const double exponent = sampler == Sampler::sobol ? sobol_exponent : 1;
  return probe.raw * probe.raw * std::pow(probe.samples / samples, exponent);
}

double denoised_square(const DenoisingProbe& probe, Sampler sampler, double samples) {
  const double share =
      std::clamp(probe.denoised * probe.denoised / (probe.raw * probe.raw), 1e-6, 1 - 1e-6);
  const double odds = share / (1 - share) * std::pow(samples / probe.samples, share_exponent);
  return raw_square(probe, sampler, samples) * odds / (1 + odds);
}

/// Returns the samples per pixel with which a denoised picture meets a target error.
double samples_for(const DenoisingProbe& probe, Sampler sampler, double target) {
  double few = 2;
  double many = 1 << 24;
  for (int step = 0; step < 60; ++step) {
    const double middle = std::sqrt(few * many);
    (denoised_square(probe, sampler, middle) > target * target ? few : many) = middle;
  }
  return many;
}

RenderSettings part_settings(const RenderSettings& whole, const PartOfPicture& part) {
  constexpr std::uint32_t samples = 16;
  RenderSettings settings = whole;
  settings.width = part.width();
  settings.height = part.height();
  settings.samples_per_pixel = std::min(whole.samples_per_pixel, samples) / 2 * 2;
  settings.adaptive = settings.target_denoised = settings.progressive = false;
  settings.target_error = settings.target_half_width = settings.time_limit = 0;
  return settings;
}

struct Probed {
  DenoisingProbe probe;
  double seconds_a_sample = 0;  ///< time of one sample of every pixel of the picture
};

/// Traces and denoises a part of the picture. Returns nothing if tracing takes longer than 1/20 of
/// the time limit, or without a limit longer than a second.
std::optional<Probed> probe_part(const PathTracer& tracer, const Scene& scene,
                                 const RenderSettings& whole, int threads, std::uint64_t pixels) {
  constexpr PartOfPicture::Tile tile{32, 32};
  const PartOfPicture part(tracer, whole.width, whole.height, pixels, tile);
  const auto steady = steady_tracer(tracer, scene, whole);
  const PartOfPicture steady_part(*steady, whole.width, whole.height, pixels, tile);
  const RenderSettings settings = part_settings(whole, part);
  const double longest = whole.time_limit > 0 ? whole.time_limit / 20 : 1;
  const double end = effort_now().wall + longest;
  const StopPoller late([end] { return effort_now().wall > end; });
  const auto traced = render_directly(part, scene, settings, threads, late.stop());
  if (!traced) return {};
  const Effort began = effort_now();
  const Features features =
      trace_features(part, steady_part, scene, settings, settings.samples_per_pixel, threads);
  const Denoised denoised = denoise::denoise(replicates_of(traced->state()), features, threads);
  const double took = (effort_now() - began).wall;
  const double samples = settings.samples_per_pixel;
  const double times = static_cast<double>(pixel_count(whole)) / part.pixels();
  const double a_sample = std::max(traced->seconds, 1e-6) / samples;
  return Probed{{samples, estimate_rmse(traced->state()).rmse, denoised.rmse, took / a_sample},
                a_sample * times};
}

}  // namespace

DenoisingWorth foresee_denoising(const DenoisingProbe& probe, const RenderSettings& settings,
                                 double limit_samples) {
  double samples = settings.samples_per_pixel;
  if (settings.target_error > 0) {
    samples = std::min(samples, samples_for(probe, settings.sampler, settings.target_error));
  }
  if (limit_samples > 0) samples = std::min(samples, limit_samples - probe.samples_instead);
  samples = std::max(samples, 2.0);
  const double instead = samples + probe.samples_instead;
  return {samples, std::sqrt(denoised_square(probe, settings.sampler, samples)),
          probe.samples_instead, std::sqrt(raw_square(probe, settings.sampler, instead))};
}

std::optional<DenoisingWorth> denoising_worth(const PathTracer& tracer, const Scene& scene,
                                              const RenderSettings& settings, int threads) {
  constexpr std::uint64_t most_pixels = 24576;
  constexpr std::uint64_t least_pixels = 4096;
  const std::uint64_t pixels =
      std::min(std::uint64_t{settings.width} * settings.height / 5, most_pixels);
  if (pixels < least_pixels || !settings.passes.empty() || settings.samples_per_pixel < 2) {
    return {};
  }
  const auto probed = probe_part(tracer, scene, settings, threads, pixels);
  if (!probed || !(probed->probe.raw > 0)) return {};
  return foresee_denoising(probed->probe, settings, settings.time_limit / probed->seconds_a_sample);
}

std::string denoising_does_not_pay(const DenoisingWorth& worth) {
  return "--denoise is not expected to pay: " + number_cell(std::round(worth.samples)) +
         " samples per pixel, denoised, have an error of about " +
         formatted("%.2g", worth.denoised) + "; in the same time " +
         number_cell(std::round(worth.samples + worth.more_samples)) +
         " samples without --denoise have " + formatted("%.2g", worth.undenoised);
}

}  // namespace parray::plan
