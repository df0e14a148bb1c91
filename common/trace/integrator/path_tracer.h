#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <utility>

#include "common/image/pixel_sums.h"
#include "common/image/radiance_scale.h"
#include "common/image/sample_range.h"
#include "common/scene/scene.h"
#include "common/scene/setting_choices.h"
#include "common/scene/settings_fwd.h"
#include "common/trace/integrator/add_sample.h"
#include "common/trace/ray.h"

namespace parray::trace {

class PathTracer;

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
              int threads = 1);

 private:
  friend std::unique_ptr<PathTracer> make_path_tracer(std::shared_ptr<const Accelerator>,
                                                      const Camera&, const PictureSettings&, bool);
  /// Makes a tracer. `self` owns this object. `general`: see make_path_tracer().
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

/// A horizontal run of pixels, columns [x_begin, x_end) of row y.
struct PixelRun {
  std::uint32_t y = 0;
  std::uint32_t x_begin = 0;
  std::uint32_t x_end = 0;
};

/// The first hit of a sample's camera ray.
struct FirstHit {
  std::uint32_t shape = no_shape;  ///< number in the scene (scene::Scene); no_shape: the sky
  double distance = 0;             ///< along the ray, from its start; 0 for the sky
  Vec3d direction{};               ///< direction of the ray; unit length except for rounding
  Vec3d normal{};                  ///< unit normal on the side of the ray's origin; 0: the sky

  friend bool operator==(const FirstHit&, const FirstHit&) = default;
};

/// Traces a picture of a scene. Immutable; any number of threads may call its functions at once.
class PathTracer {
 public:
  virtual ~PathTracer() = default;
  PathTracer& operator=(PathTracer&&) = delete;

  /// Traces samples [samples.begin, samples.end) of each pixel of `run` and adds them to `sums`
  /// (run.x_end - run.x_begin elements) and `counts`. Non-finite samples are counted, but not added
  /// to the sums.
  void trace(const PixelRun& run, const SampleRange& samples, std::span<PixelSums> sums,
             TraceCounts& counts) const {
    trace_run(run, RunSamples(samples), sums, counts);
  }

  /// Does the same with samples[i] as the range of the i-th pixel of `run`.
  virtual void trace_run(const PixelRun& run, const RunSamples& samples, std::span<PixelSums> sums,
                         TraceCounts& counts) const = 0;

  /// Finds the first hits of the camera rays of samples [samples.begin, samples.end) of each pixel
  /// of `run`. `hits` lists all samples of a pixel, then those of the next pixel. It has
  /// samples.count() elements for each pixel.
  virtual void first_hits(const PixelRun& run, const SampleRange& samples,
                          std::span<FirstHit> hits) const = 0;

  /// Adds the background samples among those that trace_run() would trace to `sky`, which has one
  /// element per pixel of `run`. The added radiance has exactly the bits that these samples add to
  /// the pixel's sums.
  virtual void add_sky_samples(const PixelRun& run, const RunSamples& samples,
                               std::span<SkySamples> sky) const = 0;

  [[nodiscard]] const std::shared_ptr<const Accelerator>& accelerator() const {
    return accelerator_;
  }
  /// Returns the instruction set in use, as reports name it.
  [[nodiscard]] std::string_view isa() const { return name_of(accelerator_->isa()); }

 protected:
  explicit PathTracer(std::shared_ptr<const Accelerator> accelerator)
      : accelerator_(std::move(accelerator)) {}

 private:
  std::shared_ptr<const Accelerator> accelerator_;
};

/// Makes the tracer of a picture from `camera`. The cost is small compared with building the
/// accelerator: one pass over the shapes finds those around the lens. `picture.precision` must be
/// the accelerator's. Positions are measured from accelerator->origin(). So the bits are those of a
/// new accelerator only if scene_origin() is the same with this camera as with the scene's.
/// `general`, for tests and benchmarks: the tracer's kernels contain the code of every feature
/// (KernelFeatures), even if the scene lacks the feature; the bits of its pictures are the same.
std::unique_ptr<PathTracer> make_path_tracer(std::shared_ptr<const Accelerator> accelerator,
                                             const Camera& camera, const PictureSettings& picture,
                                             bool general = false);

/// Adds a background sample with a finite radiance.
template <typename Real>
void add_sky_sample(const Vec3<Real>& radiance, const RadianceScale& scale, SkySamples& sky) {
  ++sky.count;
  sky.sum[0] += scale.to_fixed(static_cast<double>(radiance.x));
  sky.sum[1] += scale.to_fixed(static_cast<double>(radiance.y));
  sky.sum[2] += scale.to_fixed(static_cast<double>(radiance.z));
}

}  // namespace parray::trace
