#include <algorithm>
#include <cmath>
#include <memory>
#include <span>

#include "cli/output/denoise/denoise.h"
#include "common/math/float_mode.h"
#include "common/scene/picture_settings.h"

namespace parray::denoise {
namespace {

/// Smallest depth, relative to the distance between the eye and its target. Smaller depths count as
/// equal.
constexpr double nearest = 1e-6;

/// Value instead of a sphere's number: the samples met several spheres.
constexpr std::uint32_t several_spheres = no_shape - 1;

using Values = std::array<double, feature_count>;

FeaturePlanes planes_of(const PictureSettings& settings) {
  return {feature_count, Plane(settings.width, settings.height)};
}

/// Computes the features of a picture. Rows are independent: threads share no row.
class FeatureRows {
 public:
  FeatureRows(const PathTracer& tracer, const PathTracer& steady, const Scene& scene,
              const PictureSettings& settings, std::uint32_t samples)
      : tracer_(tracer),
        steady_tracer_(steady),
        scene_(scene),
        width_(settings.width),
        samples_(std::min(samples, own_feature_samples) / 2 * 2),
        forward_(normalize(scene.camera.look_at - scene.camera.look_from)),
        length_(length(scene.camera.look_at - scene.camera.look_from)),
        begin_(scene.camera.projection == Projection::orthographic ? 1 : 0),
        spheres_(std::size_t{settings.width} * settings.height),
        features_{{planes_of(settings), planes_of(settings)},
                  planes_of(settings),
                  std::vector<char>(spheres_.size())} {}

  /// Computes a row of the features. `hits` belongs to the calling thread.
  void fill(std::uint32_t y, std::vector<FirstHit>& hits) {
    const SampleRange own{0, samples_};
    look(tracer_, {y, 0, width_}, own, hits);
    for (std::uint32_t x = 0; x < width_; ++x) {
      const auto pixel = std::span(hits).subspan(std::size_t{x} * own.count(), own.count());
      put(features_.own[0], y, x, mean_of(pixel, 0, 2));
      put(features_.own[1], y, x, mean_of(pixel, 1, 2));
    }
    look_few(y, hits);
  }

  /// Adds steady samples to a row where needed. Call it after fill() for all rows.
  void refine(std::uint32_t y, std::vector<FirstHit>& hits) {
    const SampleRange more{few_steady_samples, many_steady_samples};
    for (std::uint32_t begin = 0; begin < width_;) {
      std::uint32_t end = begin;
      while (end < width_ && !one_sphere(y, end)) ++end;
      if (end < width_) {
        const std::size_t pixel = std::size_t{y} * width_ + end;
        features_.plain_sky[pixel] = spheres_[pixel] == no_shape ? 1 : 0;
      }
      if (begin < end) look(steady_tracer_, {y, begin, end}, more, hits);
      for (std::uint32_t x = begin; x < end; ++x) {
        refine_pixel(y, x,
                     std::span(hits).subspan(std::size_t{x - begin} * more.count(), more.count()));
      }
      begin = end + 1;
    }
  }

  Features take() {
    scale_depth();
    auto& [even, odd] = features_.own;
    for (FeaturePlanes* planes : {&even, &odd, &features_.steady}) {
      for (Plane& plane : *planes) plane.repeat_border();
    }
    return std::move(features_);
  }

 private:
  static void look(const PathTracer& tracer, const PixelRun& run, const SampleRange& samples,
                   std::vector<FirstHit>& hits) {
    hits.resize(std::size_t{run.x_end - run.x_begin} * samples.count());
    tracer.first_hits(run, samples, hits);
  }

  [[nodiscard]] Values values_of(const FirstHit& hit) const {
    const Vec3d& towards = hit.direction;
    if (hit.shape == no_shape) return {0, 0, 0, -towards.x, -towards.y, -towards.z, 0};
    const Vec3d& albedo = scene_.material_of(hit.shape).albedo;
    const double depth = begin_ + hit.distance * dot(hit.direction, forward_) / length_;
    return {albedo.x,
            albedo.y,
            albedo.z,
            hit.normal.x,
            hit.normal.y,
            hit.normal.z,
            depth > nearest ? 1 / depth : 1 / nearest};
  }

  /// Returns the mean of the hits first, first + step and so on.
  [[nodiscard]] Values mean_of(std::span<const FirstHit> hits, std::size_t first,
                               std::size_t step) const {
    Values sum{};
    std::size_t count = 0;
    for (std::size_t i = first; i < hits.size(); i += step, ++count) {
      const Values values = values_of(hits[i]);
      for (std::size_t j = 0; j < feature_count; ++j) sum[j] += values[j];
    }
    for (double& value : sum) value /= static_cast<double>(count);
    return sum;
  }

  static void put(FeaturePlanes& planes, std::uint32_t y, std::uint32_t x, const Values& values) {
    for (std::size_t j = 0; j < feature_count; ++j) {
      planes[j].row(y)[x] = static_cast<float>(values[j]);
    }
  }

  void look_few(std::uint32_t y, std::vector<FirstHit>& hits) {
    const SampleRange few{0, few_steady_samples};
    look(steady_tracer_, {y, 0, width_}, few, hits);
    for (std::uint32_t x = 0; x < width_; ++x) {
      const auto pixel = std::span(hits).subspan(std::size_t{x} * few.count(), few.count());
      const bool one = std::ranges::all_of(
          pixel, [&](const FirstHit& hit) { return hit.shape == pixel.front().shape; });
      spheres_[std::size_t{y} * width_ + x] = one ? pixel.front().shape : several_spheres;
      put(features_.steady, y, x, mean_of(pixel, 0, 1));
    }
  }

  /// Updates a pixel with `hits`, the samples after the few steady ones.
  void refine_pixel(std::uint32_t y, std::uint32_t x, std::span<const FirstHit> hits) {
    const Values more = mean_of(hits, 0, 1);
    constexpr double share = static_cast<double>(few_steady_samples) / many_steady_samples;
    for (std::size_t j = 0; j < feature_count; ++j) {
      float& value = features_.steady[j].row(y)[x];
      value = static_cast<float>(share * value + (1 - share) * more[j]);
    }
    const std::size_t pixel = std::size_t{y} * width_ + x;
    const bool sky =
        spheres_[pixel] == no_shape &&
        std::ranges::all_of(hits, [](const FirstHit& hit) { return hit.shape == no_shape; });
    features_.plain_sky[pixel] = sky ? 1 : 0;
  }

  /// Returns whether all samples of a pixel and of its neighbours met the same sphere.
  [[nodiscard]] bool one_sphere(std::uint32_t y, std::uint32_t x) const {
    const std::uint32_t sphere = spheres_[std::size_t{y} * width_ + x];
    const std::uint32_t bottom = std::min(y + 1, features_.steady[0].height() - 1);
    const std::uint32_t right = std::min(x + 1, width_ - 1);
    for (std::uint32_t j = y - std::min(y, 1U); j <= bottom; ++j) {
      for (std::uint32_t i = x - std::min(x, 1U); i <= right; ++i) {
        if (spheres_[std::size_t{j} * width_ + i] != sphere) return false;
      }
    }
    return sphere != several_spheres;
  }

  /// Scales depth to a standard deviation of 1 over the steady features.
  void scale_depth() {
    Plane& steady = features_.steady.back();
    const double pixels = static_cast<double>(width_) * steady.height();
    double sum = 0;
    for (std::uint32_t y = 0; y < steady.height(); ++y) {
      for (std::uint32_t x = 0; x < width_; ++x) sum += steady.row(y)[x];
    }
    const double mean = sum / pixels;
    double squares = 0;
    for (std::uint32_t y = 0; y < steady.height(); ++y) {
      for (std::uint32_t x = 0; x < width_; ++x) {
        const double off = steady.row(y)[x] - mean;
        squares += off * off;
      }
    }
    const double factor = squares > 0 ? 1 / std::sqrt(squares / pixels) : 1;
    for (Plane* plane : {&features_.own[0].back(), &features_.own[1].back(), &steady}) {
      for (std::uint32_t y = 0; y < plane->height(); ++y) {
        float* const row = plane->row(y);
        for (std::uint32_t x = 0; x < width_; ++x) row[x] = static_cast<float>(row[x] * factor);
      }
    }
  }

  const PathTracer& tracer_;
  const PathTracer& steady_tracer_;
  const Scene& scene_;
  std::uint32_t width_;
  std::uint32_t samples_;
  Vec3d forward_;
  double length_;
  /// Depth at which rays begin. Parallel rays may begin at surfaces that look large. The reciprocal
  /// of their depth must not dominate all others.
  double begin_;
  /// The sphere that all of the few steady samples of a pixel met.
  std::vector<std::uint32_t> spheres_;
  Features features_;
};

/// Calls visit(y, hits) for all rows. Each thread has its own `hits`.
void for_rows(const PictureSettings& settings, int threads,
              const std::function<void()>& between_bands, auto&& visit) {
  constexpr std::uint32_t band_samples = 1U << 18;
  const std::uint32_t band =
      std::max(band_samples / (own_feature_samples + many_steady_samples) / settings.width,
               static_cast<std::uint32_t>(threads));
  for (std::uint32_t begin = 0; begin < settings.height; begin += band) {
    if (between_bands) between_bands();
    const std::uint32_t end = std::min(begin + band, settings.height);
#pragma omp parallel num_threads(threads)
    {
      const FloatMode ieee;
      std::vector<FirstHit> hits;
#pragma omp for schedule(dynamic) nowait
      for (std::uint32_t y = begin; y < end; ++y) visit(y, hits);
    }
  }
}

}  // namespace

std::unique_ptr<PathTracer> steady_tracer(const PathTracer& tracer, const Scene& scene,
                                          const PictureSettings& settings) {
  PictureSettings other = settings;
  other.seed = ~settings.seed;
  return make_path_tracer(tracer.accelerator(), scene.camera, other);
}

Features trace_features(const PathTracer& tracer, const PathTracer& steady, const Scene& scene,
                        const PictureSettings& settings, std::uint32_t samples, int threads,
                        const std::function<void()>& between_bands) {
  FeatureRows rows(tracer, steady, scene, settings, samples);
  const auto fill = [&](std::uint32_t y, std::vector<FirstHit>& hits) { rows.fill(y, hits); };
  const auto refine = [&](std::uint32_t y, std::vector<FirstHit>& hits) { rows.refine(y, hits); };
  for_rows(settings, threads, between_bands, fill);
  for_rows(settings, threads, between_bands, refine);
  return rows.take();
}

void Plane::repeat_border() {
  for (std::size_t y = 0; y < height_; ++y) {
    float* const first = row(y);
    std::fill(first - margin, first, first[0]);
    std::fill(first + width_, first - margin + stride_, first[width_ - 1]);
  }
  const auto row_size = static_cast<std::ptrdiff_t>(stride_);
  const auto top = values_.begin() + static_cast<std::ptrdiff_t>(margin) * row_size;
  const auto bottom = top + (static_cast<std::ptrdiff_t>(height_) - 1) * row_size;
  for (auto to = values_.begin(); to != top; to += row_size) std::copy(top, top + row_size, to);
  for (auto to = bottom + row_size; to != values_.end(); to += row_size) {
    std::copy(bottom, bottom + row_size, to);
  }
}

}  // namespace parray::denoise
