#include "common/trace/kernel.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "common/image/radiance_scale.h"
#include "common/trace/isa.h"
#include "common/trace/isa_kernels.h"
#include "common/trace/octree.h"
#include "common/trace/scalar_kernel.h"
#include "common/trace/sphere_tables.h"

namespace parray {
namespace {

KernelFeatures features_of(const Scene& scene, const std::vector<std::uint32_t>& around_lens) {
  KernelFeatures features{!around_lens.empty(), false};
  for (const Material& material : scene.materials) {
    features.sides = features.sides || material.type == MaterialType::dielectric;
    features.fuzz = features.fuzz || (material.type == MaterialType::metal && material.fuzz > 0);
  }
  return features;
}

template <typename Real, typename Store, int W>
class LaneKernel final : public Kernel {
 public:
  using Tables = KernelScene<Real, Store, W>;
  using Space = Workspace<Real, Store>;
  /// Of one instruction set: see isa_kernels.h.
  struct Functions {
    std::uint64_t (*trace)(const Tables&, const SampleBatch&, BatchRadiance&);
    void (*find)(const Tables&, Space&);
  };

  LaneKernel(const Scene& scene, const RenderSettings& settings, const KernelOptions& options,
             Isa isa, const Functions& functions)
      : origin_(scene_origin(scene)),
        spheres_(stored_shapes<Store>(scene, origin_),
                 settings.accelerator != AcceleratorKind::linear, options.build_threads),
        around_lens_(spheres_around_lens(scene)),
        tables_(make_view<Real>(scene, settings, origin_), SkyGradient<Real>(scene.sky)),
        isa_(isa),
        functions_(functions) {
    for (const Material& material : scene.materials) {
      surfaces_.emplace_back(material);
    }
    fill_material_of(scene);
    tables_.width = settings.width;
    tables_.max_depth = settings.max_depth;
    tables_.seed = settings.seed;
    tables_.sampler = settings.sampler;
    tables_.to_fixed = RadianceScale(largest_radiance(scene)).factor();
    tables_.features = options.general ? KernelFeatures{} : features_of(scene, around_lens_);
    tables_.surfaces = surfaces_.data();
    tables_.material_of = material_of_.data();
    tables_.input_index = spheres_.input_index();
    tables_.blocks = spheres_.blocks();
    tables_.open_spheres = spheres_.open_spheres();
    tables_.nodes = spheres_.nodes();
    tables_.node_count = spheres_.node_count();
    tables_.stack_size = spheres_.stack_size();
    tables_.prefetch = spheres_.bytes() > cache_bytes;
    place_around_lens();
  }

  void trace_run(const PixelRun& run, const RunSamples& samples, std::span<PixelSums> sums,
                 TraceCounts& counts) const override {
    SampleBatch batch;
    batch.y = run.y;
    BatchRadiance radiance;
    const auto trace_batch = [&] {
      counts.rays += functions_.trace(tables_, batch, radiance);
      add(radiance, batch, sums.data() - run.x_begin, counts);
      batch.count = 0;
    };
    for (std::uint32_t x = run.x_begin; x < run.x_end; ++x) {
      const SampleRange range = samples[x - run.x_begin];
      for (std::uint32_t s = range.begin; s < range.end; ++s) {
        batch.column[batch.count] = x;
        batch.sample[batch.count] = s;
        if (++batch.count == SampleBatch::most) {
          trace_batch();
        }
      }
    }
    if (batch.count > 0) {
      trace_batch();
    }
    counts.lost += radiance.lost;
  }

  void first_hits(const PixelRun& run, const SampleRange& samples,
                  std::span<FirstHit> hits) const override {
    Space space;
    for (std::size_t first = 0; first < hits.size(); first += SampleBatch::most) {
      const std::size_t count = std::min<std::size_t>(hits.size() - first, SampleBatch::most);
      begin_paths(run, samples, first, static_cast<std::uint32_t>(count), space);
      functions_.find(tables_, space);
      for (std::uint32_t i = 0; i < count; ++i) {
        hits[first + i] = found(space, i);
      }
    }
  }

  [[nodiscard]] std::size_t accelerator_bytes() const override {
    return spheres_.bytes() + material_of_.size() * sizeof(std::uint32_t);
  }
  [[nodiscard]] std::string_view isa() const override { return name_of(isa_); }

 private:
  /// Tables of this size stay in a core's own cache.
  static constexpr std::size_t cache_bytes = std::size_t{512} << 10;

  void fill_material_of(const Scene& scene) {
    material_of_.resize(spheres_.slot_count());
    for (std::uint32_t slot = 0; slot < spheres_.slot_count(); ++slot) {
      const std::uint32_t index = spheres_.input_index()[slot];
      if (index != no_sphere) {
        const std::uint32_t material = scene.spheres[index].material;
        const auto type = static_cast<std::uint32_t>(scene.materials[material].type);
        material_of_[slot] = material | type << MaterialRef::type_bit;
      }
    }
  }

  /// From input indices to slots.
  void place_around_lens() {
    if (!around_lens_.empty()) {
      std::vector<std::uint32_t> slots;
      for (std::uint32_t slot = 0; slot < spheres_.slot_count(); ++slot) {
        if (std::binary_search(around_lens_.begin(), around_lens_.end(),
                               spheres_.input_index()[slot])) {
          slots.push_back(slot);
        }
      }
      around_lens_ = std::move(slots);
    }
    tables_.around_lens = around_lens_.data();
    tables_.around_lens_count = static_cast<std::uint32_t>(around_lens_.size());
  }

  /// `pixels` are those of the whole row.
  static void add(const BatchRadiance& radiance, const SampleBatch& batch, PixelSums* pixels,
                  TraceCounts& counts) {
    for (std::uint32_t i = 0; i < batch.count;) {
      const std::uint32_t x = batch.column[i];
      PixelSums pixel;  // in registers
      for (; i < batch.count && batch.column[i] == x; ++i) {
        add_fixed({radiance.channel[0][i], radiance.channel[1][i], radiance.channel[2][i]},
                  batch.sample[i], pixel, counts);
      }
      pixels[x] += pixel;
    }
  }

  /// Camera rays of samples [first, first + count) of the run's, pixel after pixel.
  void begin_paths(const PixelRun& run, const SampleRange& samples, std::size_t first,
                   std::uint32_t count, Space& space) const {
    Paths<Real>& paths = space.paths;
    paths.count = count;
    space.inside.clear();
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto x = run.x_begin + static_cast<std::uint32_t>((first + i) / samples.count());
      const auto s = samples.begin + static_cast<std::uint32_t>((first + i) % samples.count());
      const SampleRandom random(tables_.seed, run.y * tables_.width + x, s, tables_.sampler);
      const Ray<Real> ray = tables_.view.template ray<Real>(x, run.y, random);
      paths.origin.set(i, ray.origin);
      paths.direction.set(i, ray.direction);
      paths.surface[i] = no_sphere;
      paths.inside[i] = inside_at(tables_, ray.origin, space.inside);
    }
  }

  /// What find() has found for a path.
  FirstHit found(const Space& space, std::uint32_t i) const {
    const std::uint32_t slot = space.queries.slot[i];
    if (slot == no_sphere) {
      return {};
    }
    const Ray<Real> ray(space.paths.origin[i], space.paths.direction[i],
                        space.queries.inverse_square[i]);
    const Hit<Real> hit{space.queries.t[i], spheres_.input_index()[slot],
                        space.queries.leaving[i] != 0};
    return first_hit(ray, hit, sphere_at<Real>(spheres_.blocks(), slot));
  }

  Vec3d origin_;
  SphereTables<Store, W> spheres_;
  std::vector<std::uint32_t> around_lens_;  ///< slots
  std::vector<Surface<Real>> surfaces_;
  std::vector<std::uint32_t> material_of_;  ///< by slot
  Tables tables_;
  Isa isa_;
  Functions functions_;
};

template <int FloatWidth, int DoubleWidth>
std::unique_ptr<Kernel> kernel_of(
    const Scene& scene, const RenderSettings& settings, const KernelOptions& options, Isa isa,
    typename LaneKernel<float, float, FloatWidth>::Functions single,
    typename LaneKernel<double, float, FloatWidth>::Functions mixed,
    typename LaneKernel<double, double, DoubleWidth>::Functions full) {
  switch (settings.precision) {
    case Precision::f64:
      return std::make_unique<LaneKernel<double, double, DoubleWidth>>(scene, settings, options,
                                                                       isa, full);
    case Precision::mixed:
      return std::make_unique<LaneKernel<double, float, FloatWidth>>(scene, settings, options, isa,
                                                                     mixed);
    default:
      return std::make_unique<LaneKernel<float, float, FloatWidth>>(scene, settings, options, isa,
                                                                    single);
  }
}

std::unique_ptr<Kernel> octree_kernel(const Scene& scene, const RenderSettings& settings) {
  switch (settings.precision) {
    case Precision::f64:
      return std::make_unique<ScalarKernel<double, double, Octree<double>>>(scene, settings);
    case Precision::mixed:
      return std::make_unique<ScalarKernel<double, float, Octree<double>>>(scene, settings);
    default:
      return std::make_unique<ScalarKernel<float, float, Octree<float>>>(scene, settings);
  }
}

}  // namespace

std::vector<std::uint32_t> spheres_around_lens(const Scene& scene) {
  std::vector<std::uint32_t> around;
  const double lens = scene.camera.aperture / 2;
  for (std::uint32_t i = 0; i < scene.spheres.size(); ++i) {
    const Sphere& sphere = scene.spheres[i];
    const double distance = length(scene.camera.look_from - sphere.center);
    // Above the single-precision rounding of what is compared later: a candidate costs little.
    const double slack = 16.0 * RealTraits<float>::unit_roundoff *
                         (length(scene.camera.look_from) + length(sphere.center));
    if (distance - lens - slack < sphere.radius) {
      around.push_back(i);
    }
  }
  return around;
}

#define PARRAY_KERNELS_OF(isa)                                                                     \
  kernel_of<isa::float_width, isa::double_width>(scene, settings, options, Isa::isa,               \
                                                 {isa::trace, isa::find}, {isa::trace, isa::find}, \
                                                 {isa::trace, isa::find})

std::unique_ptr<Kernel> make_kernel(const Scene& scene, const RenderSettings& settings,
                                    const KernelOptions& options) {
  if (settings.accelerator == AcceleratorKind::octree) {
    return octree_kernel(scene, settings);
  }
  const Isa isa = runs_on_this_machine(settings.isa) && settings.isa != Isa::automatic
                      ? settings.isa
                      : best_isa();
  switch (isa) {
#if defined(__x86_64__)
    case Isa::avx512:
      return PARRAY_KERNELS_OF(avx512);
    case Isa::avx2:
      return PARRAY_KERNELS_OF(avx2);
#endif
    default:
      return PARRAY_KERNELS_OF(scalar);
  }
}

double largest_radiance(const Scene& scene) {
  const Vec3d& a = scene.sky.horizon;
  const Vec3d& b = scene.sky.zenith;
  return std::max({a.x, a.y, a.z, b.x, b.y, b.z});
}

}  // namespace parray
