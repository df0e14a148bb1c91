#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/scene/largest_radiance.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "tests/support/lane_search.h"
#include "tests/support/reference_tracer.h"
#include "tests/support/rooms.h"

/// All tracers that can compute the sums of a scene.
namespace parray::test {

/// Traces the rows of a picture. The tracers take turns.
inline ReferenceSums sums_of(std::span<const PathTracer* const> tracers,
                             const RenderSettings& settings) {
  ReferenceSums result{std::vector<PixelSums>(std::size_t{settings.width} * settings.height), {}};
  for (std::uint32_t y = 0; y < settings.height; ++y) {
    tracers[y % tracers.size()]->trace(
        {y, 0, settings.width}, {0, settings.samples_per_pixel},
        std::span(result.pixels).subspan(std::size_t{y} * settings.width, settings.width),
        result.counts);
  }
  return result;
}
inline ReferenceSums sums_of(const PathTracer& tracer, const RenderSettings& settings) {
  return sums_of(std::array{&tracer}, settings);
}

struct Tracer {
  std::string name;
  std::function<ReferenceSums(const Scene&, const RenderSettings&)> sums;
};

/// Returns the scalar tracer, which defines pictures, and the kernels of every instruction set of
/// this machine, with linear search and with the tree.
inline std::vector<Tracer> tracers() {
  std::vector<Tracer> result{{"scalar paths", reference_sums}};
  for (const Isa isa : instruction_sets()) {
    for (const AcceleratorKind kind : {AcceleratorKind::linear, AcceleratorKind::bvh}) {
      result.push_back({std::string(name_of(isa)) + " lanes, " + std::string(name_of(kind)),
                        [isa, kind](const Scene& scene, RenderSettings settings) {
                          settings.isa = isa;
                          settings.accelerator = kind;
                          return sums_of(*make_path_tracer(scene, settings), settings);
                        }});
    }
  }
  return result;
}

/// Traces with the kernels of all instruction sets of this machine, which take turns.
inline ReferenceSums lane_sums(const Scene& scene, RenderSettings settings) {
  std::vector<std::unique_ptr<PathTracer>> kernels;
  std::vector<const PathTracer*> turns;
  for (const Isa isa : instruction_sets()) {
    settings.isa = isa;
    turns.push_back(kernels.emplace_back(make_path_tracer(scene, settings)).get());
  }
  return sums_of(turns, settings);
}

/// Returns the mean radiance of each channel of each pixel.
inline std::vector<double> means_of(const ReferenceSums& sums, const Scene& scene,
                                    const RenderSettings& settings) {
  const RadianceScale scale(largest_radiance(scene));
  std::vector<double> means;
  means.reserve(3 * sums.pixels.size());
  for (const PixelSums& pixel : sums.pixels) {
    for (const std::uint64_t sum : pixel.sum) {
      means.push_back(scale.mean(sum, settings.samples_per_pixel));
    }
  }
  return means;
}

/// Returns the mean of the differences of two pictures, or of their absolute values.
inline double mean_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] - b[i];
  return sum / static_cast<double>(a.size());
}
inline double mean_distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] < b[i] ? b[i] - a[i] : a[i] - b[i];
  return sum / static_cast<double>(a.size());
}

}  // namespace parray::test
