#include "common/trace/kernel.h"

#include <algorithm>
#include <cmath>

#include "common/trace/bvh.h"
#include "common/trace/linear.h"
#include "common/trace/octree.h"
#include "common/trace/path.h"

namespace parray {
namespace {

/// Spheres that some point of the lens may lie inside of; each sample then decides for itself.
std::vector<std::uint32_t> spheres_around_lens(const Scene& scene) {
  std::vector<std::uint32_t> around;
  const double lens = scene.camera.aperture / 2;
  for (std::uint32_t i = 0; i < scene.spheres.size(); ++i) {
    const Sphere& sphere = scene.spheres[i];
    const double distance = length(scene.camera.look_from - sphere.center);
    // Twice the single-precision rounding of what is compared later: a candidate costs little.
    const double slack = 0x1p-20 * (length(scene.camera.look_from) + length(sphere.center));
    if (distance - lens - slack < sphere.radius) {
      around.push_back(i);
    }
  }
  return around;
}

template <typename Real>
TraceScene<Real> make_trace_scene(const Scene& scene, const RenderSettings& settings) {
  TraceScene<Real> result{{},
                          {},
                          {},
                          SkyGradient<Real>(scene.sky),
                          View<Real>(scene.camera, settings.width, settings.height),
                          spheres_around_lens(scene),
                          settings.max_depth};
  result.spheres.reserve(scene.spheres.size());
  result.material_of.reserve(scene.spheres.size());
  for (const Sphere& sphere : scene.spheres) {
    result.spheres.push_back({vec_cast<Real>(sphere.center), static_cast<Real>(sphere.radius)});
    result.material_of.push_back(sphere.material);
  }
  for (const Material& material : scene.materials) {
    result.surfaces.emplace_back(material);
  }
  return result;
}

template <typename Real, Accelerator<Real> A>
class TemplateKernel final : public Kernel {
 public:
  TemplateKernel(const Scene& scene, const RenderSettings& settings)
      : scene_(make_trace_scene<Real>(scene, settings)),
        accelerator_(scene_.spheres),
        scale_(largest_radiance(scene)),
        width_(settings.width),
        seed_(settings.seed) {}

  void trace(const PixelRun& run, const SampleRange& samples, std::span<PixelSums> sums,
             TraceCounts& counts) const override {
    Sides<Real> sides;
    for (std::uint32_t x = run.x_begin; x < run.x_end; ++x) {
      PixelSums pixel;
      for (std::uint32_t s = samples.begin; s < samples.end; ++s) {
        const SampleRandom random(seed_, run.y * width_ + x, s);
        const Vec3<Real> radiance =
            trace_sample(scene_, accelerator_, x, run.y, random, sides, counts.rays);
        add(radiance, pixel, counts);
      }
      sums[x - run.x_begin] += pixel;
    }
  }

  [[nodiscard]] std::size_t accelerator_bytes() const override { return accelerator_.bytes(); }
  [[nodiscard]] std::string_view isa() const override { return "scalar"; }

 private:
  void add(const Vec3<Real>& radiance, PixelSums& pixel, TraceCounts& counts) const {
    const Vec3d value = vec_cast<double>(radiance);
    ++counts.samples;
    if (!std::isfinite(value.x) || !std::isfinite(value.y) || !std::isfinite(value.z)) {
      ++counts.nonfinite;
      return;
    }
    pixel.add({scale_.to_fixed(value.x), scale_.to_fixed(value.y), scale_.to_fixed(value.z)});
  }

  TraceScene<Real> scene_;
  A accelerator_;
  RadianceScale scale_;
  std::uint32_t width_;
  std::uint64_t seed_;
};

template <typename Real>
std::unique_ptr<Kernel> make_kernel_of(const Scene& scene, const RenderSettings& settings) {
  if (settings.accelerator == AcceleratorKind::linear) {
    return std::make_unique<TemplateKernel<Real, Linear<Real>>>(scene, settings);
  }
  if (settings.accelerator == AcceleratorKind::octree) {
    return std::make_unique<TemplateKernel<Real, Octree<Real>>>(scene, settings);
  }
  return std::make_unique<TemplateKernel<Real, Bvh<Real>>>(scene, settings);
}

}  // namespace

std::unique_ptr<Kernel> make_kernel(const Scene& scene, const RenderSettings& settings) {
  return settings.precision == Precision::f64 ? make_kernel_of<double>(scene, settings)
                                              : make_kernel_of<float>(scene, settings);
}

double largest_radiance(const Scene& scene) {
  const Vec3d& a = scene.sky.horizon;
  const Vec3d& b = scene.sky.zenith;
  return std::max({a.x, a.y, a.z, b.x, b.y, b.z});
}

}  // namespace parray
