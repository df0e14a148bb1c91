#include "common/trace/integrator/nonfinite.h"

namespace parray::trace {
namespace {

std::uint64_t nonfinite_samples(const PathTracer& tracer, const PixelRun& pixel,
                                const SampleRange& samples) {
  PixelSums sums;
  TraceCounts counts;
  tracer.trace(pixel, samples, {&sums, 1}, counts);
  return counts.nonfinite;
}

}  // namespace

std::vector<ExcludedSamples> locate_nonfinite(const PathTracer& tracer, const PixelRun& run,
                                              std::span<const SampleRange> samples) {
  std::vector<ExcludedSamples> found;
  for (std::uint32_t x = run.x_begin; x < run.x_end; ++x) {
    const PixelRun pixel{run.y, x, x + 1};
    const SampleRange range = samples[x - run.x_begin];
    const std::uint64_t count = nonfinite_samples(tracer, pixel, range);
    if (count == 0) continue;
    std::uint32_t first = range.begin;
    while (nonfinite_samples(tracer, pixel, {first, first + 1}) == 0) ++first;
    found.push_back({run.y, x, first, static_cast<std::uint32_t>(count)});
  }
  return found;
}

}  // namespace parray::trace
