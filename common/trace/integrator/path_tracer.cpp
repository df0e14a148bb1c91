#include "common/trace/integrator/path_tracer.h"

#include "common/scene/origin.h"
#include "common/trace/integrator/wavefront_tracer.h"

namespace parray::trace {

Accelerator::Accelerator(const Scene& scene, Precision precision, AcceleratorKind kind, Isa isa,
                         const BuildOptions& options)
    : precision_(precision),
      kind_(kind),
      isa_(isa),
      sky_(scene.sky),
      origin_(scene_origin(scene, options.threads)) {}

std::unique_ptr<PathTracer> make_path_tracer(std::shared_ptr<const Accelerator> accelerator,
                                             const Camera& camera, const PictureSettings& picture) {
  const Accelerator& made = *accelerator;
  return made.tracer(std::move(accelerator), camera, picture, false);
}

std::unique_ptr<PathTracer> make_general_path_tracer(std::shared_ptr<const Accelerator> accelerator,
                                                     const Camera& camera,
                                                     const PictureSettings& picture) {
  const Accelerator& made = *accelerator;
  return made.tracer(std::move(accelerator), camera, picture, true);
}

}  // namespace parray::trace
