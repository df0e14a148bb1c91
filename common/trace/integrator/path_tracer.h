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
#include "common/trace/integrator/accelerator.h"
#include "common/trace/ray.h"

namespace parray::trace {

/// A horizontal run of pixels, columns [x_begin, x_end) of row y.
struct PixelRun {
  std::uint32_t y = 0;
  std::uint32_t x_begin = 0;
  std::uint32_t x_end = 0;
};

/// What the camera ray of a sample meets.
struct FirstHit {
  std::uint32_t sphere = no_sphere;  ///< place in Scene::spheres; no_sphere: the sky
  double distance = 0;               ///< along the ray, from the lens
  Vec3d direction{};                 ///< of the ray; unit length but for rounding
  Vec3d normal{};                    ///< unit, on the side that the ray comes from; 0: the sky

  friend bool operator==(const FirstHit&, const FirstHit&) = default;
};

/// A picture of a scene, ready to be traced. Immutable; its functions may be called by any number
/// of threads at once.
class PathTracer {
 public:
  virtual ~PathTracer() = default;
  PathTracer(const PathTracer&) = delete;
  PathTracer& operator=(const PathTracer&) = delete;

  /// Traces samples [samples.begin, samples.end) of each pixel of `run` and adds them to `sums`
  /// (run.x_end - run.x_begin elements) and `counts`. Non-finite samples are left out of the sums
  /// and counted.
  void trace(const PixelRun& run, const SampleRange& samples, std::span<PixelSums> sums,
             TraceCounts& counts) const {
    trace_run(run, RunSamples(samples), sums, counts);
  }

  /// The same with a range of samples for each pixel.
  virtual void trace_run(const PixelRun& run, const RunSamples& samples, std::span<PixelSums> sums,
                         TraceCounts& counts) const = 0;

  /// What the camera rays of the same samples meet: of all samples of a pixel, then of the next.
  /// `hits` has samples.count() elements for each pixel of `run`.
  virtual void first_hits(const PixelRun& run, const SampleRange& samples,
                          std::span<FirstHit> hits) const = 0;

  /// Of the same samples as trace_run() would trace, those that are background, added to `sky`, one
  /// for each pixel of `run`: their radiance is what they add to the pixel's sums, to the bit.
  virtual void add_sky_samples(const PixelRun& run, const RunSamples& samples,
                               std::span<SkySamples> sky) const = 0;

  [[nodiscard]] const std::shared_ptr<const Accelerator>& accelerator() const {
    return accelerator_;
  }
  /// Instruction set that it uses, as the report names it.
  [[nodiscard]] std::string_view isa() const { return name_of(accelerator_->isa()); }

 protected:
  explicit PathTracer(std::shared_ptr<const Accelerator> accelerator)
      : accelerator_(std::move(accelerator)) {}

 private:
  std::shared_ptr<const Accelerator> accelerator_;
};

/// The tracer of a picture as `camera` sees it: cheap beside the accelerator, whose spheres are
/// looked through once, for those around the lens. `picture.precision` is the accelerator's. The
/// bits are those of an accelerator of its own as long as scene_origin() is the same with this
/// camera as with the scene's: positions are measured from accelerator->origin().
std::unique_ptr<PathTracer> make_path_tracer(std::shared_ptr<const Accelerator> accelerator,
                                             const Camera& camera, const PictureSettings& picture);

/// Adds sample number `sample` to a pixel, from the numbers that RadianceScale::fixed_of() takes:
/// unless one is NaN, for a radiance that is not finite; then the sample is only counted.
inline void add_fixed(const Vec3d& shifted, std::uint32_t sample, PixelSums& pixel,
                      TraceCounts& counts) {
  ++counts.samples;
  if (const double sum = shifted.x + shifted.y + shifted.z; sum != sum) {
    ++counts.nonfinite;
    return;
  }
  pixel.add({RadianceScale::fixed_of(shifted.x), RadianceScale::fixed_of(shifted.y),
             RadianceScale::fixed_of(shifted.z)},
            sample);
}

/// Adds a sample that is background, of that radiance, which is finite.
template <typename Real>
void add_sky_sample(const Vec3<Real>& radiance, const RadianceScale& scale, SkySamples& sky) {
  ++sky.count;
  sky.sum[0] += scale.to_fixed(static_cast<double>(radiance.x));
  sky.sum[1] += scale.to_fixed(static_cast<double>(radiance.y));
  sky.sum[2] += scale.to_fixed(static_cast<double>(radiance.z));
}

/// The same as add_fixed() from its radiance.
inline void add_sample(const Vec3d& radiance, const RadianceScale& scale, std::uint32_t sample,
                       PixelSums& pixel, TraceCounts& counts) {
  // x - x is 0 for finite x alone.
  const auto shifted = [&scale](double value) {
    return static_cast<double>(scale.to_fixed(value)) + RadianceScale::shift + (value - value);
  };
  add_fixed({shifted(radiance.x), shifted(radiance.y), shifted(radiance.z)}, sample, pixel, counts);
}

}  // namespace parray::trace
