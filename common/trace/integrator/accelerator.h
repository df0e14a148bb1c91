#pragma once

#include <cstddef>
#include <memory>

#include "common/scene/scene.h"
#include "common/scene/setting_choices.h"
#include "common/scene/settings_fwd.h"

namespace parray::trace {

class PathTracer;

/// Options that change how an accelerator is built, but not the bits of its pictures.
struct BuildOptions {
  int threads = 1;  ///< threads that build, at least 1
};

/// The shapes of a scene in searchable form for one precision, kind and instruction set, with the
/// scene's materials and sky. It holds everything that takes time and memory in proportion to the
/// number of shapes. Other code needs no variant for each precision, kind and instruction set.
/// make_accelerator() makes one (common/trace/tracer.h).
///
/// Immutable; any number of tracers and threads may share it. It refers to no memory of the scene.
class Accelerator {
 public:
  virtual ~Accelerator() = default;
  Accelerator& operator=(Accelerator&&) = delete;

  [[nodiscard]] Precision precision() const { return precision_; }
  [[nodiscard]] AcceleratorKind kind() const { return kind_; }
  [[nodiscard]] Isa isa() const { return isa_; }
  [[nodiscard]] const Sky& sky() const { return sky_; }
  /// Returns the origin of all positions: scene_origin() of the scene, which depends on its camera,
  /// too. Tracers with other cameras use the same origin.
  [[nodiscard]] const Vec3d& origin() const { return origin_; }
  /// Returns the bytes of memory of the search structure and of all shapes: positions, radii and
  /// indices of materials. Does not count the materials and the sky.
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
  /// Makes a tracer. `self` owns this object. `general`: see make_general_path_tracer().
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
