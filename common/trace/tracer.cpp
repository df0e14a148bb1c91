#include "common/trace/tracer.h"

#include "common/scene/origin.h"
#include "common/scene/settings.h"
#include "common/trace/integrator/wavefront_tracer.h"
#include "common/trace/isa.h"
#include "common/trace/reference/octree.h"
#include "common/trace/reference/scalar_tracer.h"

namespace parray::trace {
namespace {

template <template <typename Real> typename Search>
std::shared_ptr<const Accelerator> make_scalar(const Scene& scene, Precision precision,
                                               AcceleratorKind kind) {
  return with_types(precision, [&]<typename Real, typename Store>() {
    return std::shared_ptr<const Accelerator>(
        std::make_shared<const ScalarAccelerator<Real, Store, Search<Real>>>(scene, precision,
                                                                             kind));
  });
}

std::uint64_t nonfinite_samples(const PathTracer& tracer, const PixelRun& pixel,
                                const SampleRange& samples) {
  PixelSums sums;
  TraceCounts counts;
  tracer.trace(pixel, samples, {&sums, 1}, counts);
  return counts.nonfinite;
}

}  // namespace

Accelerator::Accelerator(const Scene& scene, Precision precision, AcceleratorKind kind, Isa isa,
                         int threads)
    : precision_(precision),
      kind_(kind),
      isa_(isa),
      sky_(scene.sky),
      origin_(scene_origin(scene, threads)) {}

Isa isa_for(AcceleratorKind kind, Isa asked) {
  if (kind == AcceleratorKind::octree) return Isa::scalar;
  return asked != Isa::automatic && runs_on_this_machine(asked) ? asked : best_isa();
}

std::shared_ptr<const Accelerator> make_accelerator(const Scene& scene, Precision precision,
                                                    AcceleratorKind kind, Isa isa, int threads) {
  return kind == AcceleratorKind::octree
             ? make_scalar<Octree>(scene, precision, kind)
             : make_wavefront_accelerator(scene, precision, kind, isa_for(kind, isa), threads);
}

bool serves(const Accelerator& accelerator, const RenderSettings& settings) {
  return accelerator.precision() == settings.precision &&
         accelerator.kind() == settings.accelerator &&
         accelerator.isa() == isa_for(settings.accelerator, settings.isa);
}

std::unique_ptr<PathTracer> make_path_tracer(std::shared_ptr<const Accelerator> accelerator,
                                             const Camera& camera, const PictureSettings& picture,
                                             bool general) {
  const Accelerator& made = *accelerator;
  return made.tracer(std::move(accelerator), camera, picture, general);
}

std::unique_ptr<PathTracer> make_path_tracer(const Scene& scene, const RenderSettings& settings,
                                             int threads) {
  return make_path_tracer(
      make_accelerator(scene, settings.precision, settings.accelerator, settings.isa, threads),
      scene.camera, settings);
}

bool same_tracer(const RenderSettings& a, const RenderSettings& b) {
  return a.picture() == b.picture() && a.accelerator == b.accelerator && a.isa == b.isa;
}

std::unique_ptr<PathTracer> make_scalar_tracer(const Scene& scene, const RenderSettings& settings) {
  return make_path_tracer(make_scalar<Linear>(scene, settings.precision, AcceleratorKind::linear),
                          scene.camera, settings);
}

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
