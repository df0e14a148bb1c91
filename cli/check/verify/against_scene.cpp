#include "cli/check/verify/against_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>
#include <variant>

#include "cli/output/channel_tracing.h"
#include "common/adaptive/error_estimate.h"
#include "common/adaptive/pixel_noise.h"
#include "common/image/lattice.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"

namespace parray::verify {
namespace {

std::vector<RetracedPixel> choose_pixels(const VerifiedPicture& picture,
                                         const PixelChoice& choice) {
  const std::vector<std::uint32_t> counts = sample_counts(picture);
  const std::uint32_t width = picture.file.image.width;
  const std::uint64_t total = picture.pixels();
  std::vector<RetracedPixel> pixels;
  for (const std::uint64_t place : choose(choice.all ? total : choice.pixels, total, choice.seed)) {
    pixels.push_back({static_cast<std::uint32_t>(place % width),
                      static_cast<std::uint32_t>(place / width),
                      counts.empty() ? picture.recipe.settings->samples_per_pixel : counts[place]});
  }
  return pixels;
}

/// Returns the pixels that the colours of `pixels` come from: a pixel without samples has the
/// colour of its block's corner. The result is distinct and sorted.
std::vector<RetracedPixel> sources_of(const std::vector<RetracedPixel>& pixels,
                                      const std::vector<std::uint32_t>& counts,
                                      std::uint32_t width) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, RetracedPixel> sources;
  for (const RetracedPixel& pixel : pixels) {
    const BlockCorner corner = block_corner(counts, width, pixel.x, pixel.y);
    const std::uint32_t samples = counts[std::size_t{corner.y} * width + corner.x];
    sources.try_emplace({corner.y, corner.x}, RetracedPixel{corner.x, corner.y, samples});
  }
  std::vector<RetracedPixel> sorted;
  sorted.reserve(sources.size());
  for (const auto& [place, source] : sources) sorted.push_back(source);
  return sorted;
}

void retrace_sources(const PathTracer& tracer, const RadianceScale& scale,
                     const std::vector<std::uint32_t>& counts, std::uint32_t width,
                     std::vector<RetracedPixel>& pixels, int threads, bool transparent) {
  std::vector<RetracedPixel> sources = sources_of(pixels, counts, width);
  retrace(tracer, scale, sources, threads, transparent);
  for (RetracedPixel& pixel : pixels) {
    const BlockCorner corner = block_corner(counts, width, pixel.x, pixel.y);
    const auto source =
        std::ranges::lower_bound(sources, std::pair(corner.y, corner.x), {},
                                 [](const RetracedPixel& one) { return std::pair(one.y, one.x); });
    pixel.mean = source->mean;
    pixel.alpha = source->alpha;
  }
}

/// Traces all chosen pixels. Pixels without samples have the colour of another pixel.
void retrace_all(const PathTracer& tracer, const RadianceScale& scale,
                 const VerifiedPicture& picture, std::vector<RetracedPixel>& pixels, int threads) {
  const auto has_none = [](const RetracedPixel& pixel) { return pixel.samples == 0; };
  if (std::ranges::any_of(pixels, has_none)) {
    retrace_sources(tracer, scale, sample_counts(picture), picture.file.image.width, pixels,
                    threads, picture.transparent());
  } else {
    retrace(tracer, scale, pixels, threads, picture.transparent());
  }
}

// ---- Extra channels --------------------------------------------------------------------------

Aovs traced_aovs(const VerifiedPicture& picture) {
  constexpr std::array<std::pair<Aov, std::string_view>, 9> names = {{{Aov::depth, "Z"},
                                                                      {Aov::normal, "N.X"},
                                                                      {Aov::normal, "N.Y"},
                                                                      {Aov::normal, "N.Z"},
                                                                      {Aov::albedo, "albedo.R"},
                                                                      {Aov::albedo, "albedo.G"},
                                                                      {Aov::albedo, "albedo.B"},
                                                                      {Aov::sphere, "sphere"},
                                                                      {Aov::cost, "cost"}}};
  Aovs aovs;
  for (const auto& [aov, name] : names) {
    if (channel_of(picture, name) != nullptr) aovs.insert(aov);
  }
  return aovs;
}

std::uint32_t bits_at(const Channel& channel, std::size_t place) {
  return std::visit(
      [place](const auto& values) { return std::bit_cast<std::uint32_t>(values[place]); },
      channel.values);
}

void check_channels(const PathTracer& tracer, const Scene& scene, RenderSettings settings,
                    const VerifiedPicture& picture, const std::vector<RetracedPixel>& pixels,
                    int threads, VerificationResults& findings) {
  const Aovs aovs = traced_aovs(picture);
  if (aovs.empty() || picture.recipe.channel_samples == 0) return;
  settings.samples_per_pixel = picture.recipe.channel_samples;
  std::vector<PixelRun> places;
  places.reserve(pixels.size());
  for (const RetracedPixel& pixel : pixels) places.push_back({pixel.y, pixel.x, pixel.x + 1});
  for (const Channel& traced : trace_channels(tracer, scene, settings, aovs, places, threads)) {
    const Channel* kept = channel_of(picture, traced.name);
    if (kept == nullptr) continue;
    std::uint64_t& wrong = findings.channels[traced.name];
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const std::size_t place = std::size_t{pixels[i].y} * picture.file.image.width + pixels[i].x;
      const bool same = kept->values.index() == traced.values.index() &&
                        bits_at(*kept, place) == bits_at(traced, i);
      wrong += same ? 0 : 1;
    }
  }
}

// ---- The stated error ------------------------------------------------------------------------

/// Compares the channels half_width.R, .G and .B, if the file has them. Needs all pixels.
void check_half_widths(const VerifiedPicture& picture, const ErrorEstimate& error,
                       VerificationResults& findings) {
  for (const std::size_t c : {0U, 1U, 2U}) {
    const std::string name = std::string("half_width.") + "RGB"[c];
    const Channel* kept = channel_of(picture, name);
    const auto* values = kept == nullptr ? nullptr : std::get_if<std::vector<float>>(&kept->values);
    if (values == nullptr) continue;
    std::uint64_t& wrong = findings.channels[name];
    for (std::size_t i = 0; i < values->size(); ++i) {
      wrong += (*values)[i] == error.half_width[3 * i + c] ? 0 : 1;
    }
  }
}

/// Repeats the renderer's estimate from all pixels. The result must have the same bits.
void estimate_from_all(const std::vector<RetracedPixel>& pixels, const VerifiedPicture& picture,
                       double largest, ErrorCheck& check, VerificationResults& findings) {
  std::vector<PixelSums> sums;
  std::vector<std::uint32_t> counts;
  for (const RetracedPixel& pixel : pixels) {
    sums.push_back(pixel.sums);
    counts.push_back(pixel.samples);
  }
  const ErrorEstimate error =
      estimate_error({picture.file.image.width, picture.file.image.height, sums, counts, largest});
  const auto stated = [&](const char* name) {
    return real_in(picture.file.metadata, std::string("parray:error:") + name).value_or(-1);
  };
  check.traced = error.rmse;
  check.wrong =
      check.stated != error.rmse || stated("low") != error.low || stated("high") != error.high;
  check_half_widths(picture, error, findings);
}

/// Estimates the mean square error from some pixels, and its standard error. A result below the
/// stated error is no fault: a few pixels that were not chosen may have most of the error.
void estimate_from_some(const std::vector<RetracedPixel>& pixels, double largest,
                        ErrorCheck& check) {
  constexpr double many = 5;  // standard errors
  const RadianceScale scale(largest);
  double sum = 0;
  double sum_of_squares = 0;
  for (const RetracedPixel& pixel : pixels) {
    double square = 0;
    for (const double d : noise_of(pixel.sums, pixel.samples, scale).difference) {
      square += d * d / 3;
    }
    sum += square;
    sum_of_squares += square * square;
  }
  const auto count = static_cast<double>(pixels.size());
  const double mean = sum / count;
  const double deviation =
      std::sqrt(std::max(sum_of_squares / count - mean * mean, 0.0) / (count - 1));
  check.traced = std::sqrt(mean);
  check.uncertainty = mean > 0 ? deviation / (2 * check.traced) : 0;
  check.wrong = mean - check.stated * check.stated > many * deviation;
}

void check_error(const std::vector<RetracedPixel>& pixels, const VerifiedPicture& picture,
                 double largest, VerificationResults& findings) {
  constexpr std::size_t least_pixels = 30;
  const auto stated = real_in(picture.file.metadata, "parray:error:rmse");
  const bool all = pixels.size() == picture.pixels();
  const auto has_error = [](const RetracedPixel& pixel) { return pixel.samples >= 2; };
  if (!stated || !std::ranges::all_of(pixels, has_error) ||
      (!all && pixels.size() < least_pixels)) {
    return;
  }
  ErrorCheck& check = findings.error.emplace(ErrorCheck{.stated = *stated});
  if (all) {
    estimate_from_all(pixels, picture, largest, check, findings);
  } else {
    estimate_from_some(pixels, largest, check);
  }
}

}  // namespace

bool VerificationResults::right() const {
  return wrong.empty() && !(error && error->wrong) &&
         std::ranges::all_of(channels, [](const auto& channel) { return channel.second == 0; });
}

VerificationResults check_against_scene(const VerifiedPicture& picture, const Scene& scene,
                                        const RenderSettings& settings, const PixelChoice& choice,
                                        int threads) {
  std::vector<RetracedPixel> pixels = choose_pixels(picture, choice);
  const auto tracer = make_path_tracer(scene, settings, threads);
  const double largest = largest_radiance(scene);
  retrace_all(*tracer, RadianceScale(largest), picture, pixels, threads);
  VerificationResults findings;
  findings.traced = pixels.size();
  std::ranges::copy_if(pixels, std::back_inserter(findings.wrong),
                       [&](const RetracedPixel& pixel) { return !same_colour(picture, pixel); });
  check_channels(*tracer, scene, settings, picture, pixels, threads, findings);
  check_error(pixels, picture, largest, findings);
  return findings;
}

}  // namespace parray::verify
