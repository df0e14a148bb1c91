#include "cli/check/verify/retrace.h"

#include <cmath>
#include <numeric>
#include <random>
#include <set>

#include "cli/output/picture/transparency.h"
#include "common/base/bands.h"
#include "common/image/image.h"
#include "common/math/float_mode.h"

namespace parray::verify {
namespace {

/// Number of samples in a piece of work, unless one pixel has more: about ten milliseconds.
constexpr std::uint64_t piece_samples = std::uint64_t{1} << 16;

/// Divides the pixels into pieces. A piece ends at the end of a row, or when it has enough samples.
std::vector<std::span<RetracedPixel>> pieces_of(std::span<RetracedPixel> pixels) {
  std::vector<std::span<RetracedPixel>> pieces;
  std::size_t begin = 0;
  std::uint64_t samples = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    samples += pixels[i].samples;
    const bool last = i + 1 == pixels.size();
    if (last || samples >= piece_samples || pixels[i + 1].y != pixels[i].y) {
      pieces.push_back(pixels.subspan(begin, i + 1 - begin));
      begin = i + 1;
      samples = 0;
    }
  }
  return pieces;
}

/// Removes the background from pixels of one row, whose samples are `ranges`.
void remove_sky(const PathTracer& tracer, const RadianceScale& scale, const PixelRun& run,
                std::span<const SampleRange> ranges, std::span<RetracedPixel> pixels) {
  std::vector<SkySamples> sky(ranges.size());
  tracer.add_sky_samples(run, RunSamples(ranges), sky);
  for (RetracedPixel& pixel : pixels) {
    const TransparentPixel out =
        without_sky(pixel.mean, sky[pixel.x - run.x_begin], pixel.samples, scale);
    pixel.mean = out.colour;
    pixel.alpha = out.alpha;
  }
}

/// Traces pixels of one row. The pixels between them get no samples.
void retrace_piece(const PathTracer& tracer, const RadianceScale& scale,
                   std::span<RetracedPixel> pixels, bool transparent) {
  const std::uint32_t first = pixels.front().x;
  const PixelRun run{pixels.front().y, first, pixels.back().x + 1};
  std::vector<SampleRange> ranges(run.x_end - run.x_begin);
  std::vector<PixelSums> sums(ranges.size());
  for (const RetracedPixel& pixel : pixels) ranges[pixel.x - first] = {0, pixel.samples};
  TraceCounts counts;
  tracer.trace_run(run, RunSamples(ranges), sums, counts);
  if (counts.nonfinite > 0 && pixels.size() > 1) {  // count these samples for each pixel
    for (RetracedPixel& pixel : pixels) retrace_piece(tracer, scale, {&pixel, 1}, transparent);
    return;
  }
  for (RetracedPixel& pixel : pixels) {
    const std::uint64_t finite = pixel.samples - counts.nonfinite;
    pixel.sums = sums[pixel.x - first];
    pixel.mean = mean_radiance(pixel.sums, static_cast<std::uint32_t>(finite), scale);
  }
  if (transparent) remove_sky(tracer, scale, run, ranges, pixels);
}

}  // namespace

// Source: Bentley and Floyd, "A sample of brilliance", Communications of the ACM 30 (1987).
std::vector<std::uint64_t> choose(std::uint64_t count, std::uint64_t total, std::uint64_t seed) {
  if (count >= total) {
    std::vector<std::uint64_t> all(total);
    std::iota(all.begin(), all.end(), std::uint64_t{0});
    return all;
  }
  std::mt19937_64 random(seed);
  std::set<std::uint64_t> chosen;
  for (std::uint64_t last = total - count; last < total; ++last) {
    if (!chosen.insert(random() % (last + 1)).second) chosen.insert(last);
  }
  return {chosen.begin(), chosen.end()};
}

void retrace(const PathTracer& tracer, const RadianceScale& scale, std::span<RetracedPixel> pixels,
             int threads, bool transparent) {
  const std::vector<std::span<RetracedPixel>> pieces = pieces_of(pixels);
  side_by_side(pieces.size(), threads, [&](std::size_t i) {
    const FloatMode ieee;
    retrace_piece(tracer, scale, pieces[i], transparent);
  });
}

double share_found(std::uint64_t count) {
  return 1 - std::pow(0.05, 1 / static_cast<double>(count));
}

}  // namespace parray::verify
