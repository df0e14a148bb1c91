#pragma once

#include <memory>
#include <vector>

#include "common/scene/origin.h"
#include "common/trace/kernel.h"
#include "common/trace/path.h"

namespace parray {

/// Spheres as a kernel stores them, relative to `origin`.
template <typename Store>
std::vector<SphereShape<Store>> stored_shapes(const Scene& scene, const Vec3d& origin) {
  std::vector<SphereShape<Store>> shapes;
  shapes.reserve(scene.spheres.size());
  for (const Sphere& sphere : scene.spheres) {
    shapes.push_back({vec_cast<Store>(sphere.center - origin), static_cast<Store>(sphere.radius)});
  }
  return shapes;
}

/// The camera relative to `origin`.
template <typename Real>
View<Real> make_view(const Scene& scene, const RenderSettings& settings, const Vec3d& origin) {
  Camera camera = scene.camera;
  camera.look_from = camera.look_from - origin;
  camera.look_at = camera.look_at - origin;
  return View<Real>(camera, settings.width, settings.height);
}

/// Spheres that some point of the lens may lie inside of; each sample then decides for itself.
std::vector<std::uint32_t> spheres_around_lens(const Scene& scene);

/// `sphere` is the one of `hit`, the first along a camera ray.
template <typename Real>
FirstHit first_hit(const Ray<Real>& ray, const Hit<Real>& hit, const SphereShape<Real>& sphere) {
  const Vec3<Real> outward = normal_at(ray, sphere, hit.leaving);
  return {hit.sphere, static_cast<double>(hit.t), vec_cast<double>(ray.direction),
          vec_cast<double>(hit.leaving ? -outward : outward)};
}

/// The kernel of a scalar accelerator: one path after the other, any accelerator of
/// accelerator.h. What it computes is what every other kernel has to compute, to the bit.
/// `Store` is the type that positions are rounded to: float, with Real double, is precision mixed.
template <typename Real, typename Store, Accelerator<Real> A>
class ScalarKernel final : public Kernel {
 public:
  ScalarKernel(const Scene& scene, const RenderSettings& settings)
      : ScalarKernel(scene, settings, scene_origin(scene)) {}

  void trace_run(const PixelRun& run, const RunSamples& samples, std::span<PixelSums> sums,
                 TraceCounts& counts) const override {
    Sides<Real> sides;
    for (std::uint32_t x = run.x_begin; x < run.x_end; ++x) {
      const SampleRange range = samples[x - run.x_begin];
      for (std::uint32_t s = range.begin; s < range.end; ++s) {
        const Vec3<Real> radiance =
            trace_sample(scene_, accelerator_, x, run.y, random(x, run.y, s), sides, counts);
        add_sample(vec_cast<double>(radiance), scale_, s, sums[x - run.x_begin], counts);
      }
    }
  }

  void first_hits(const PixelRun& run, const SampleRange& samples,
                  std::span<FirstHit> hits) const override {
    Sides<Real> sides;
    for (std::size_t i = 0; i < hits.size(); ++i) {
      const std::uint32_t x = run.x_begin + static_cast<std::uint32_t>(i / samples.count());
      const std::uint32_t s = samples.begin + static_cast<std::uint32_t>(i % samples.count());
      const Ray<Real> ray = scene_.view.template ray<Real>(x, run.y, random(x, run.y, s));
      start_sides(scene_, ray.origin, sides);
      const Hit<Real> hit = first_crossing(scene_, accelerator_, ray, sides);
      hits[i] =
          hit.sphere == no_sphere ? FirstHit{} : first_hit(ray, hit, scene_.spheres[hit.sphere]);
    }
  }

  [[nodiscard]] std::size_t accelerator_bytes() const override { return accelerator_.bytes(); }
  [[nodiscard]] std::string_view isa() const override { return name_of(Isa::scalar); }

 private:
  ScalarKernel(const Scene& scene, const RenderSettings& settings, const Vec3d& origin)
      : scene_{{},
               {},
               {},
               SkyGradient<Real>(scene.sky),
               make_view<Real>(scene, settings, origin),
               spheres_around_lens(scene),
               settings.max_depth},
        accelerator_(fill(scene, origin)),
        scale_(largest_radiance(scene)),
        width_(settings.width),
        seed_(settings.seed),
        sampler_(settings.sampler) {}

  [[nodiscard]] SampleRandom random(std::uint32_t x, std::uint32_t y, std::uint32_t sample) const {
    return {seed_, y * width_ + x, sample, sampler_};
  }

  /// Returns the spheres, which the accelerator is made from.
  const std::vector<SphereShape<Real>>& fill(const Scene& scene, const Vec3d& origin) {
    for (const SphereShape<Store>& shape : stored_shapes<Store>(scene, origin)) {
      scene_.spheres.push_back({vec_cast<Real>(shape.center), static_cast<Real>(shape.radius)});
    }
    for (const Sphere& sphere : scene.spheres) {
      scene_.material_of.push_back(sphere.material);
    }
    for (const Material& material : scene.materials) {
      scene_.surfaces.emplace_back(material);
    }
    return scene_.spheres;
  }

  TraceScene<Real> scene_;
  A accelerator_;
  RadianceScale scale_;
  std::uint32_t width_;
  std::uint64_t seed_;
  Sampler sampler_;
};

}  // namespace parray
