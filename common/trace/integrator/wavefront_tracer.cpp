#include "common/trace/integrator/wavefront_tracer.h"

#include <algorithm>
#include <bit>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "common/base/arrays.h"
#include "common/base/bands.h"
#include "common/image/radiance_scale.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/picture_settings.h"
#include "common/trace/bvh/wide_bvh.h"
#include "common/trace/integrator/isa_kernels.h"
#include "common/trace/integrator/scene_parts.h"
#include "common/trace/integrator/start_shapes.h"
#include "common/trace/isa.h"

namespace parray::trace {
namespace {

/// Returns the features that the materials alone need.
KernelFeatures features_of(const Scene& scene) {
  KernelFeatures features{false, false, !scene.capsules.empty()};
  for (const Material& material : scene.materials) {
    features.sides = features.sides || material.type == MaterialType::dielectric;
    features.fuzz = features.fuzz || (material.type == MaterialType::metal && material.fuzz > 0);
  }
  return features;
}

/// Makes the MaterialRef of each shape as one array, because consecutive slots of a tree hold
/// shapes that lie far apart in the input.
AlignedArray<std::uint32_t> references_of(const Scene& scene, const auto& shapes, int threads) {
  AlignedArray<std::uint32_t> references(shapes.size());
  Bands(references.size(), threads).run([&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t material = shapes[i].material;
      const auto type = static_cast<std::uint32_t>(scene.materials[material].type);
      references[i] = material << MaterialRef::type_bits | type;
    }
  });
  return references;
}

template <typename Real, typename Store, int W>
class WavefrontTracer;

template <typename Real, typename Store, int W>
class WavefrontAccelerator final : public Accelerator {
 public:
  WavefrontAccelerator(const Scene& scene, Precision precision, AcceleratorKind kind, Isa isa,
                       int threads, const Kernels<Real, Store, W>& kernels)
      : Accelerator(scene, precision, kind, isa, threads),
        spheres_(
            scene.spheres.size(),
            [&](std::size_t i) { return stored_shape<Store>(scene.spheres[i], this->origin()); },
            kind != AcceleratorKind::linear, threads),
        sphere_count_(static_cast<std::uint32_t>(scene.spheres.size())),
        surfaces_(stored_materials<Real>(scene)),
        features_(features_of(scene)),
        kernels_(kernels) {
    if (!scene.capsules.empty()) {
      capsules_.emplace(
          scene.capsules.size(),
          [&](std::size_t i) { return stored_shape<Store>(scene.capsules[i], this->origin()); },
          true, threads);
    }
    const auto bits = static_cast<int>(std::bit_width(scene.materials.size()));
    if (capsules_ || bits + MaterialRef::type_bits > spheres_.tag_bits()) {
      material_of_.resize(slot_count());
    }
    note_materials(references_of(scene, scene.spheres, threads), spheres_, 0, threads);
    if (capsules_) {
      note_materials(references_of(scene, scene.capsules, threads), *capsules_,
                     spheres_.slot_count(), threads);
    }
  }

  [[nodiscard]] std::size_t bytes() const override {
    return spheres_.bytes() + (capsules_ ? capsules_->bytes() : 0) +
           material_of_.size() * sizeof(std::uint32_t);
  }

 private:
  friend class WavefrontTracer<Real, Store, W>;

  [[nodiscard]] std::unique_ptr<PathTracer> tracer(std::shared_ptr<const Accelerator> self,
                                                   const Camera& camera,
                                                   const PictureSettings& picture,
                                                   bool general) const override {
    return std::make_unique<WavefrontTracer<Real, Store, W>>(
        std::move(self), *this, moved(camera, origin()), picture, general);
  }

  /// Slots of capsules are numbered after those of spheres.
  [[nodiscard]] std::uint32_t slot_count() const {
    return spheres_.slot_count() + (capsules_ ? capsules_->slot_count() : 0);
  }

  /// Returns the slots of shapes that can contain the start of a camera ray.
  [[nodiscard]] StartShapes start_shapes(const RayStarts& starts) const {
    const std::uint32_t first_capsule = spheres_.slot_count();
    return {starts, slot_count(), [&](std::uint32_t slot) {
              return slot < first_capsule ? starts.inside(shape_at<Store>(spheres_.blocks(), slot))
                                          : starts.inside(shape_at<Store>(capsules_->blocks(),
                                                                          slot - first_capsule));
            }};
  }

  /// Stores the materials by slot, those of `shapes` from `first_slot` on. `references` holds the
  /// MaterialRef of each shape of the input.
  void note_materials(const AlignedArray<std::uint32_t>& references, auto& shapes,
                      std::uint32_t first_slot, int threads) {
#pragma omp parallel for num_threads(threads) if (threads > 1) schedule(static)
    for (std::uint32_t slot = 0; slot < shapes.slot_count(); ++slot) {
      const std::uint32_t index = shapes.input_index(slot);
      if (index == no_shape) continue;
      if (material_of_.empty()) {
        shapes.set_tag(slot, references[index]);
      } else {
        material_of_[first_slot + slot] = references[index];
      }
    }
  }

  WideBvh<Store, W> spheres_;
  std::optional<WideBvh<Store, W, CapsuleBlock>> capsules_;  ///< nullopt: the scene has none
  std::uint32_t sphere_count_;
  std::vector<MaterialParameters<Real>> surfaces_;
  /// MaterialRef of each slot; empty if the tags of the slots have enough bits.
  std::vector<std::uint32_t> material_of_;
  KernelFeatures features_;
  Kernels<Real, Store, W> kernels_;
};

template <typename Real, typename Store, int W>
class WavefrontTracer final : public PathTracer {
 public:
  using Space = Workspace<Real, Store>;

  /// `camera` must be relative to the accelerator's origin; `self` owns the accelerator.
  WavefrontTracer(std::shared_ptr<const Accelerator> self,
                  const WavefrontAccelerator<Real, Store, W>& scene, const Camera& camera,
                  const PictureSettings& picture, bool general)
      : PathTracer(std::move(self)),
        start_(scene.start_shapes(RayStarts(camera, picture.width, picture.height))),
        tables_(CameraRays<Real>(camera, picture.width, picture.height),
                SkyGradient<Real>(scene.sky())),
        kernels_(scene.kernels_),
        scale_(largest_radiance(scene.sky())),
        sphere_count_(scene.sphere_count_) {
    tables_.width = picture.width;
    tables_.max_depth = picture.max_depth;
    tables_.seed = picture.seed;
    tables_.sampler = picture.sampler;
    tables_.to_fixed = scale_.factor();
    if (!general) {
      tables_.features = scene.features_;
      tables_.features.sides = tables_.features.sides || !start_.empty();
    }
    tables_.bvh = scene.spheres_.view();
    if (scene.capsules_) tables_.capsules = scene.capsules_->view();
    tables_.capsules.first_slot = scene.spheres_.slot_count();
    tables_.capsules.end_slot = scene.slot_count();
    tables_.surfaces = scene.surfaces_.data();
    const bool apart = !scene.material_of_.empty();
    tables_.material_of = apart ? scene.material_of_.data() : tables_.bvh.labels.at;
    tables_.material_bit = apart ? 0 : 32 - scene.spheres_.tag_bits();
    tables_.start = start_.table();
  }

  void trace_run(const PixelRun& run, const RunSamples& samples, std::span<PixelSums> sums,
                 TraceCounts& counts) const override {
    for_batches(run, samples, [&](const SampleBatch& batch) {
      kernels_.trace(tables_, batch, sums.data() - run.x_begin, counts);
    });
  }

  void add_sky_samples(const PixelRun& run, const RunSamples& samples,
                       std::span<SkySamples> sky) const override {
    Space space;
    for_batches(run, samples, [&](const SampleBatch& batch) {
      kernels_.begin(tables_, batch, space);
      kernels_.find(tables_, space);
      for (std::uint32_t i = 0; i < batch.count; ++i) {
        if (space.queries.slot[i] != no_shape) continue;
        add_sky_sample(tables_.sky.radiance(space.paths.direction.y[i]), scale_,
                       sky[batch.column[i] - run.x_begin]);
      }
    });
  }

  void first_hits(const PixelRun& run, const SampleRange& samples,
                  std::span<FirstHit> hits) const override {
    Space space;
    auto first = hits.begin();
    for_batches(run, RunSamples(samples), [&](const SampleBatch& batch) {
      kernels_.begin(tables_, batch, space);
      kernels_.find(tables_, space);
      for (std::uint32_t i = 0; i < batch.count; ++i) set_found(space, i, *first++);
    });
  }

 private:
  /// Calls visit(batch) for batches that together contain all samples of the run.
  static void for_batches(const PixelRun& run, const RunSamples& samples, const auto& visit) {
    SampleBatch batch;
    batch.y = run.y;
    for (std::uint32_t x = run.x_begin; x < run.x_end; ++x) {
      const SampleRange range = samples[x - run.x_begin];
      for (std::uint32_t s = range.begin; s < range.end; ++s) {
        batch.column[batch.count] = x;
        batch.sample[batch.count] = s;
        if (++batch.count == SampleBatch::most) {
          visit(batch);
          batch.count = 0;
        }
      }
    }
    if (batch.count > 0) visit(batch);
  }

  /// Returns the result of find() for a path.
  void set_found(const Space& space, std::uint32_t i, FirstHit& first) const {
    const std::uint32_t slot = space.queries.slot[i];
    const Ray<Real> ray(space.paths.origin[i], space.paths.direction[i],
                        space.queries.inverse_square[i]);
    if (slot == no_shape) return set_sky(ray, first);
    const bool leaving = space.queries.leaving[i] != 0;
    const std::uint32_t first_capsule = tables_.capsules.first_slot;
    if (slot < first_capsule) {
      set_hit(ray, {space.queries.t[i], tables_.bvh.labels.index(slot), leaving},
              normal_at(ray, shape_at<Real>(tables_.bvh.blocks, slot), leaving), first);
    } else {
      const std::uint32_t number = tables_.capsules.labels.index(slot - first_capsule);
      set_hit(ray, {space.queries.t[i], sphere_count_ + number, leaving},
              surface_point(ray, tables_.capsule_at(slot), leaving).normal, first);
    }
  }

  StartShapes start_;
  KernelScene<Real, Store, W> tables_;
  Kernels<Real, Store, W> kernels_;
  RadianceScale scale_;
  std::uint32_t sphere_count_;  ///< number of the first capsule
};

template <typename Real, typename Store, int W>
std::shared_ptr<const Accelerator> accelerator_of(const Scene& scene, Precision precision,
                                                  AcceleratorKind kind, Isa isa, int threads,
                                                  const Kernels<Real, Store, W>& kernels) {
  return std::make_shared<const WavefrontAccelerator<Real, Store, W>>(scene, precision, kind, isa,
                                                                      threads, kernels);
}

}  // namespace

std::shared_ptr<const Accelerator> make_wavefront_accelerator(const Scene& scene,
                                                              Precision precision,
                                                              AcceleratorKind kind, Isa isa,
                                                              int threads) {
  switch (isa) {
#define PARRAY_ACCELERATOR_OF(isa)                                      \
  case Isa::isa:                                                        \
    return with_types(precision, [&]<typename Real, typename Store>() { \
      return accelerator_of(scene, precision, kind, Isa::isa, threads,  \
                            isa::kernels<Real, Store>());               \
    });
    PARRAY_FOR_EACH_ISA(PARRAY_ACCELERATOR_OF)
#undef PARRAY_ACCELERATOR_OF
    default: throw std::logic_error("this build has no kernels for the instruction set");
  }
}

}  // namespace parray::trace
