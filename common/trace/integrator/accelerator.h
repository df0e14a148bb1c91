#pragma once

#include <cstddef>
#include <memory>

#include "common/scene/scene.h"
#include "common/scene/settings.h"

namespace parray::trace {

class PathTracer;

/// What changes how an accelerator is made, but not what it is.
struct BuildOptions {
  int threads = 1;
};

/// A scene's spheres, stored for one precision and instruction set and made ready to be searched,
/// with its materials and its sky: all that takes time and memory in proportion to the number of
/// spheres. The seam behind which these choices are made, once.
///
/// Immutable; shared by any number of tracers and threads. Refers to nothing of the scene's.
class Accelerator {
 public:
  virtual ~Accelerator() = default;
  Accelerator(const Accelerator&) = delete;
  Accelerator& operator=(const Accelerator&) = delete;

  [[nodiscard]] Precision precision() const { return precision_; }
  [[nodiscard]] AcceleratorKind kind() const { return kind_; }
  [[nodiscard]] Isa isa() const { return isa_; }
  [[nodiscard]] const Sky& sky() const { return sky_; }
  /// What positions are measured from: scene_origin() of the scene, its camera included.
  [[nodiscard]] const Vec3d& origin() const { return origin_; }
  /// Memory, positions and radii included.
  [[nodiscard]] virtual std::size_t bytes() const = 0;

 protected:
  Accelerator(const Scene& scene, Precision precision, AcceleratorKind kind, Isa isa,
              const BuildOptions& options = {});

 private:
  friend std::unique_ptr<PathTracer> make_path_tracer(std::shared_ptr<const Accelerator>,
                                                      const Camera&, const PictureSettings&);
  friend std::unique_ptr<PathTracer> make_general_path_tracer(std::shared_ptr<const Accelerator>,
                                                              const Camera&,
                                                              const PictureSettings&);
  /// `self` owns this; `general`: see make_general_path_tracer().
  [[nodiscard]] virtual std::unique_ptr<PathTracer> tracer(std::shared_ptr<const Accelerator> self,
                                                           const Camera& camera,
                                                           const PictureSettings& picture,
                                                           bool general) const = 0;

  Precision precision_;
  AcceleratorKind kind_;
  Isa isa_;
  Sky sky_;
  Vec3d origin_;
};

}  // namespace parray::trace
