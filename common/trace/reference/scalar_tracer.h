#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "common/scene/largest_radiance.h"
#include "common/scene/settings.h"
#include "common/trace/integrator/path.h"
#include "common/trace/integrator/scene_parts.h"
#include "common/trace/integrator/start_shapes.h"
#include "common/trace/sphere_search.h"

namespace parray::trace {

/// Linear search: tests every sphere for every ray. The other accelerators must give its bits.
template <typename Real>
class Linear {
 public:
  explicit Linear(const std::vector<SphereShape<Real>>& spheres) : spheres_(spheres) {}

  void enter(const Ray<Real>& ray, const InsideStack<Real>& sides, Hit<Real>& best) const {
    for (std::uint32_t i = 0; i < spheres_.size(); ++i) try_shape(ray, spheres_[i], i, sides, best);
  }

  [[nodiscard]] std::size_t bytes() const { return spheres_.size() * sizeof(SphereShape<Real>); }

 private:
  std::vector<SphereShape<Real>> spheres_;
};

/// Everything that a path can meet: a PathScene. Positions are relative to scene_origin().
/// Immutable; all threads and all pictures of the scene share it.
template <typename Real>
struct TraceScene {
  std::vector<SphereShape<Real>> spheres;
  std::vector<CapsuleShape<Real>> capsules;  ///< numbered after the spheres
  std::vector<std::uint32_t> material_of;    ///< index in `surfaces`, per shape
  std::vector<MaterialParameters<Real>> surfaces;
  SkyGradient<Real> sky;

  [[nodiscard]] std::uint32_t shape_count() const {
    return static_cast<std::uint32_t>(spheres.size() + capsules.size());
  }
};

/// How the paths of a picture begin and end. Immutable; all threads share it.
template <typename Real>
struct PathEnds {
  CameraRays<Real> view;
  StartShapes start;            ///< numbers of shapes that paths may begin inside of; mostly empty
  std::uint32_t max_depth = 1;  ///< ray segments of the longest path
};

/// Adds the shapes of a scene, and the numbers of their materials, to `to`. `Store` is the type
/// that positions are rounded to, relative to `origin`.
template <typename Store, typename Real>
void add_shapes(const Scene& scene, const Vec3d& origin, TraceScene<Real>& to) {
  const auto add = [&](const auto& shape, auto& shapes) {
    shapes.push_back(shape_cast<Real>(stored_shape<Store>(shape, origin)));
    to.material_of.push_back(shape.material);
  };
  for (const Sphere& sphere : scene.spheres) add(sphere, to.spheres);
  for (const Capsule& capsule : scene.capsules) add(capsule, to.capsules);
}

/// Traces one path after the other with any search of sphere_search.h. Every other tracer must
/// compute the same, to the bit. `self` is the accelerator that owns the search and `scene`; the
/// tracer keeps it alive.
template <typename Real, SphereSearch<Real> S>
class ScalarTracer final : public PathTracer {
 public:
  ScalarTracer(std::shared_ptr<const Accelerator> self, const TraceScene<Real>& scene,
               const S& search, PathEnds<Real> ends, const PictureSettings& picture)
      : PathTracer(std::move(self)),
        scene_(scene),
        search_(search),
        ends_(std::move(ends)),
        scale_(largest_radiance(accelerator()->sky())),
        width_(picture.width),
        seed_(picture.seed),
        sampler_(picture.sampler) {}

  void trace_run(const PixelRun& run, const RunSamples& samples, std::span<PixelSums> sums,
                 TraceCounts& counts) const override {
    InsideStack<Real> sides;
    for (std::uint32_t x = run.x_begin; x < run.x_end; ++x) {
      const SampleRange range = samples[x - run.x_begin];
      for (std::uint32_t s = range.begin; s < range.end; ++s) {
        const Vec3<Real> radiance =
            trace_sample(scene_, ends_, search_, x, run.y, random(x, run.y, s), sides, counts);
        add_sample(vec_cast<double>(radiance), scale_, s, sums[x - run.x_begin], counts);
      }
    }
  }

  void first_hits(const PixelRun& run, const SampleRange& samples,
                  std::span<FirstHit> hits) const override {
    InsideStack<Real> sides;
    for (std::size_t i = 0; i < hits.size(); ++i) {
      const std::uint32_t x = run.x_begin + static_cast<std::uint32_t>(i / samples.count());
      const std::uint32_t s = samples.begin + static_cast<std::uint32_t>(i % samples.count());
      const Ray<Real> ray = camera_ray(x, run.y, s);
      const Hit<Real> hit = first_of(ray, x, run.y, sides);
      if (hit.shape == no_shape) {
        set_sky(ray, hits[i]);
      } else {
        set_hit(ray, hit, surface_point(scene_, ray, sides, hit).normal, hits[i]);
      }
    }
  }

  void add_sky_samples(const PixelRun& run, const RunSamples& samples,
                       std::span<SkySamples> sky) const override {
    InsideStack<Real> sides;
    for (std::uint32_t x = run.x_begin; x < run.x_end; ++x) {
      const SampleRange range = samples[x - run.x_begin];
      for (std::uint32_t s = range.begin; s < range.end; ++s) {
        const Ray<Real> ray = camera_ray(x, run.y, s);
        if (first_of(ray, x, run.y, sides).shape != no_shape) continue;
        add_sky_sample(scene_.sky.radiance(ray.direction.y), scale_, sky[x - run.x_begin]);
      }
    }
  }

 private:
  [[nodiscard]] Ray<Real> camera_ray(std::uint32_t x, std::uint32_t y, std::uint32_t sample) const {
    return ends_.view.template ray<Real>(x, y, random(x, y, sample));
  }
  /// Finds the first hit of a camera ray of pixel (x, y); `sides` is scratch memory.
  [[nodiscard]] Hit<Real> first_of(const Ray<Real>& ray, std::uint32_t x, std::uint32_t y,
                                   InsideStack<Real>& sides) const {
    start_sides(scene_, ends_, x, y, ray.origin, sides);
    return first_crossing(scene_, search_, ray, sides);
  }
  [[nodiscard]] SampleRandom random(std::uint32_t x, std::uint32_t y, std::uint32_t sample) const {
    return {seed_, y * width_ + x, sample, sampler_};
  }

  const TraceScene<Real>& scene_;
  const S& search_;
  PathEnds<Real> ends_;
  RadianceScale scale_;
  std::uint32_t width_;
  std::uint64_t seed_;
  Sampler sampler_;
};

/// `Store` is the type that positions are rounded to. float with Real double is precision mixed.
template <typename Real, typename Store, SphereSearch<Real> S>
class ScalarAccelerator final : public Accelerator {
 public:
  ScalarAccelerator(const Scene& scene, Precision precision, AcceleratorKind kind)
      : Accelerator(scene, precision, kind, Isa::scalar),
        scene_{{}, {}, {}, stored_materials<Real>(scene), SkyGradient<Real>(scene.sky)},
        search_(fill(scene)) {}

  /// Includes the shapes that paths look up; the search has its own copy of the spheres.
  [[nodiscard]] std::size_t bytes() const override {
    return search_.bytes() + scene_.spheres.size() * sizeof(SphereShape<Real>) +
           scene_.capsules.size() * sizeof(CapsuleShape<Real>) +
           scene_.material_of.size() * sizeof(std::uint32_t);
  }

 private:
  [[nodiscard]] std::unique_ptr<PathTracer> tracer(std::shared_ptr<const Accelerator> self,
                                                   const Camera& camera,
                                                   const PictureSettings& picture,
                                                   bool /*general*/) const override {
    const Camera here = moved(camera, origin());
    PathEnds<Real> ends{CameraRays<Real>(here, picture.width, picture.height),
                        start_shapes(RayStarts(here, picture.width, picture.height)),
                        picture.max_depth};
    return std::make_unique<ScalarTracer<Real, S>>(std::move(self), scene_, search_,
                                                   std::move(ends), picture);
  }

  [[nodiscard]] StartShapes start_shapes(const RayStarts& starts) const {
    return {starts, scene_.shape_count(), [this, &starts](std::uint32_t number) {
              return at_shape(scene_, number,
                              [&starts](const auto& shape) { return starts.inside(shape); });
            }};
  }

  /// Returns the spheres from which the search is built.
  const std::vector<SphereShape<Real>>& fill(const Scene& scene) {
    scene_.spheres.reserve(scene.spheres.size());  // so that bytes() counts all of their memory
    scene_.capsules.reserve(scene.capsules.size());
    scene_.material_of.reserve(scene.spheres.size() + scene.capsules.size());
    add_shapes<Store>(scene, origin(), scene_);
    return scene_.spheres;
  }

  TraceScene<Real> scene_;
  S search_;
};

}  // namespace parray::trace
