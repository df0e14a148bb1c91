#include "common/trace/tracer.h"

#include "common/scene/settings.h"
#include "common/trace/integrator/wavefront_tracer.h"
#include "common/trace/isa.h"
#include "common/trace/reference/linear.h"
#include "common/trace/reference/octree.h"
#include "common/trace/reference/scalar_tracer.h"

namespace parray::trace {
namespace {

template <template <typename Real> typename Search>
std::shared_ptr<const Accelerator> make_scalar(const Scene& scene, Precision precision,
                                               AcceleratorKind kind) {
  switch (precision) {
    case Precision::f64:
      return std::make_shared<const ScalarAccelerator<double, double, Search<double>>>(
          scene, precision, kind);
    case Precision::mixed:
      return std::make_shared<const ScalarAccelerator<double, float, Search<double>>>(
          scene, precision, kind);
    default:
      return std::make_shared<const ScalarAccelerator<float, float, Search<float>>>(
          scene, precision, kind);
  }
}

}  // namespace

Isa isa_for(AcceleratorKind kind, Isa asked) {
  if (kind == AcceleratorKind::octree) return Isa::scalar;
  return asked != Isa::automatic && runs_on_this_machine(asked) ? asked : best_isa();
}

std::shared_ptr<const Accelerator> make_accelerator(const Scene& scene, Precision precision,
                                                    AcceleratorKind kind, Isa isa,
                                                    const BuildOptions& options) {
  return kind == AcceleratorKind::octree
             ? make_scalar<Octree>(scene, precision, kind)
             : make_wavefront_accelerator(scene, precision, kind, isa_for(kind, isa), options);
}

bool serves(const Accelerator& accelerator, const RenderSettings& settings) {
  return accelerator.precision() == settings.precision &&
         accelerator.kind() == settings.accelerator &&
         accelerator.isa() == isa_for(settings.accelerator, settings.isa);
}

std::shared_ptr<const Accelerator> make_accelerator(const Scene& scene,
                                                    const RenderSettings& settings,
                                                    const BuildOptions& options) {
  return make_accelerator(scene, settings.precision, settings.accelerator, settings.isa, options);
}

std::unique_ptr<PathTracer> make_path_tracer(const Scene& scene, const RenderSettings& settings,
                                             const BuildOptions& options) {
  return make_path_tracer(make_accelerator(scene, settings, options), scene.camera, settings);
}

std::unique_ptr<PathTracer> make_path_tracer(std::shared_ptr<const Accelerator> accelerator,
                                             const Camera& camera, const RenderSettings& settings) {
  return make_path_tracer(std::move(accelerator), camera, settings.picture());
}

bool same_tracer(const RenderSettings& a, const RenderSettings& b) {
  return a.picture() == b.picture() && a.accelerator == b.accelerator && a.isa == b.isa;
}

std::unique_ptr<PathTracer> make_scalar_tracer(const Scene& scene, const RenderSettings& settings) {
  return make_path_tracer(make_scalar<Linear>(scene, settings.precision, AcceleratorKind::linear),
                          scene.camera, settings);
}

}  // namespace parray::trace
