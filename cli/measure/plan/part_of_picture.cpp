#include "cli/measure/plan/part_of_picture.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace parray::plan {
namespace {

/// Returns `count` stretches of `side` places each, spread evenly over `size` places.
std::vector<std::uint32_t> stretches(std::uint32_t size, std::uint32_t side, std::uint32_t count) {
  std::vector<std::uint32_t> places;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t cell = std::uint64_t{size} * i / count;
    const std::uint64_t next = std::uint64_t{size} * (i + 1) / count;
    const std::uint64_t first = cell + (next - cell - side) / 2;
    for (std::uint64_t place = first; place < first + side; ++place) {
      places.push_back(static_cast<std::uint32_t>(place));
    }
  }
  return places;
}

std::vector<std::uint32_t> all_places(std::uint32_t size) {
  std::vector<std::uint32_t> places(size);
  std::iota(places.begin(), places.end(), 0U);
  return places;
}

/// Returns the number of tiles along a side: `wanted`, but at least 1 and at most `room`.
std::uint32_t tiles(double wanted, std::uint32_t room) {
  return static_cast<std::uint32_t>(std::clamp(std::round(wanted), 1.0, static_cast<double>(room)));
}

}  // namespace

PartOfPicture::PartOfPicture(const PathTracer& tracer, std::uint32_t width, std::uint32_t height,
                             std::uint64_t pixels, Tile tile)
    : PathTracer(tracer.accelerator()), tracer_(tracer) {
  const double all = static_cast<double>(width) * height;
  if (static_cast<double>(pixels) > 0.7 * all) {
    column_ = all_places(width);
    row_ = all_places(height);
    return;
  }
  const std::uint32_t wide = std::min(tile.width, width);
  const std::uint32_t high = std::min(tile.height, height);
  const double count = static_cast<double>(pixels) / wide / high;
  const std::uint32_t across =
      tiles(std::sqrt(count * high * width / (static_cast<double>(wide) * height)), width / wide);
  const std::uint32_t down = tiles(count / across, height / high);
  column_ = stretches(width, wide, across);
  row_ = stretches(height, high, down);
}

void PartOfPicture::for_stretches(const PixelRun& run, const auto& visit) const {
  for (std::uint32_t x = run.x_begin; x < run.x_end;) {
    std::uint32_t end = x + 1;  // of the columns that lie side by side in the picture
    while (end < run.x_end && column_[end] == column_[end - 1] + 1) ++end;
    visit(PixelRun{row_[run.y], column_[x], column_[x] + (end - x)}, x - run.x_begin);
    x = end;
  }
}

static RunSamples samples_of(const RunSamples& samples, std::size_t first, const PixelRun& run,
                             std::vector<SampleRange>& ranges) {
  ranges.clear();
  for (std::size_t i = 0; i < run.x_end - run.x_begin; ++i) ranges.push_back(samples[first + i]);
  return RunSamples(ranges);
}

void PartOfPicture::trace_run(const PixelRun& run, const RunSamples& samples,
                              std::span<PixelSums> sums, TraceCounts& counts) const {
  std::vector<SampleRange> ranges;
  for_stretches(run, [&](const PixelRun& there, std::size_t first) {
    tracer_.trace_run(there, samples_of(samples, first, there, ranges),
                      sums.subspan(first, there.x_end - there.x_begin), counts);
  });
}

void PartOfPicture::first_hits(const PixelRun& run, const SampleRange& samples,
                               std::span<FirstHit> hits) const {
  const std::size_t each = samples.count();
  for_stretches(run, [&](const PixelRun& there, std::size_t first) {
    tracer_.first_hits(there, samples,
                       hits.subspan(first * each, (there.x_end - there.x_begin) * each));
  });
}

void PartOfPicture::add_sky_samples(const PixelRun& run, const RunSamples& samples,
                                    std::span<SkySamples> sky) const {
  std::vector<SampleRange> ranges;
  for_stretches(run, [&](const PixelRun& there, std::size_t first) {
    tracer_.add_sky_samples(there, samples_of(samples, first, there, ranges),
                            sky.subspan(first, there.x_end - there.x_begin));
  });
}

}  // namespace parray::plan
