#include "cli/output/channel_tracing.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "common/math/float_mode.h"
#include "common/scene/settings.h"

namespace parray::output {
namespace {

/// Depth of pixels whose rays meet no surface.
constexpr double no_surface = std::numeric_limits<double>::infinity();

/// The channels of a picture. Pixels are independent: threads share no pixel.
class ChannelPlanes {
 public:
  /// Allocates the wanted channels for `pixels` pixels.
  ChannelPlanes(const PathTracer& tracer, const Scene& scene, const RenderSettings& settings,
                const Aovs& wanted, std::size_t pixels)
      : tracer_(tracer),
        scene_(scene),
        samples_{0, std::min(settings.samples_per_pixel, channel_samples)},
        forward_(normalize(scene.camera.look_at - scene.camera.look_from)) {
    if (wanted.contains(Aov::depth)) depth_ = added<float>("Z", pixels);
    if (wanted.contains(Aov::normal)) normal_ = added_vector({"N.X", "N.Y", "N.Z"}, pixels);
    if (wanted.contains(Aov::albedo)) {
      albedo_ = added_vector({"albedo.R", "albedo.G", "albedo.B"}, pixels);
    }
    if (wanted.contains(Aov::sphere)) sphere_ = added<std::uint32_t>("sphere", pixels);
    if (wanted.contains(Aov::cost)) cost_ = added<float>("cost", pixels);
  }

  [[nodiscard]] std::uint32_t samples() const { return samples_.count(); }

  /// Computes the values of the pixels of `run` and stores them from place `first` on. `scratch`
  /// belongs to the calling thread.
  void fill(const PixelRun& run, std::size_t first, std::vector<FirstHit>& scratch) {
    const std::uint32_t count = run.x_end - run.x_begin;
    if (depth_ != nullptr || normal_[0] != nullptr || albedo_[0] != nullptr || sphere_ != nullptr) {
      scratch.resize(std::size_t{count} * samples());
      tracer_.first_hits(run, samples_, scratch);
      for (std::uint32_t i = 0; i < count; ++i) {
        fill_pixel(first + i, std::span(scratch).subspan(std::size_t{i} * samples(), samples()));
      }
    }
    for (std::uint32_t i = 0; cost_ != nullptr && i < count; ++i) {
      fill_cost(first + i, {run.y, run.x_begin + i, run.x_begin + i + 1});
    }
  }

  Channels take() { return std::move(channels_); }

 private:
  using VectorPlanes = std::array<float*, 3>;

  /// Adds a channel. Returns its values, which stay where they are.
  template <typename Value>
  Value* added(const char* name, std::size_t pixels) {
    channels_.push_back({name, std::vector<Value>(pixels)});
    return std::get<std::vector<Value>>(channels_.back().values).data();
  }
  VectorPlanes added_vector(const std::array<const char*, 3>& names, std::size_t pixels) {
    return {added<float>(names[0], pixels), added<float>(names[1], pixels),
            added<float>(names[2], pixels)};
  }

  static void set(const VectorPlanes& planes, std::size_t pixel, const Vec3d& v) {
    if (planes[0] == nullptr) return;
    planes[0][pixel] = static_cast<float>(v.x);
    planes[1][pixel] = static_cast<float>(v.y);
    planes[2][pixel] = static_cast<float>(v.z);
  }

  void fill_pixel(std::size_t pixel, std::span<const FirstHit> hits) {
    double depth = 0;
    Vec3d normal{};
    Vec3d albedo{};
    int met = 0;
    for (const FirstHit& hit : hits) {
      if (hit.shape == no_shape) continue;
      ++met;
      depth += hit.distance * dot(hit.direction, forward_);
      normal = normal + hit.normal;
      albedo = albedo + scene_.material_of(hit.shape).albedo;
    }
    const double share = 1.0 / samples();
    if (depth_ != nullptr) depth_[pixel] = static_cast<float>(met > 0 ? depth / met : no_surface);
    set(normal_, pixel, share * normal);
    set(albedo_, pixel, share * albedo);
    if (sphere_ != nullptr) sphere_[pixel] = hits.front().shape;
  }

  void fill_cost(std::size_t pixel, const PixelRun& run) {
    PixelSums unused;
    TraceCounts counts;
    tracer_.trace(run, samples_, {&unused, 1}, counts);
    cost_[pixel] = static_cast<float>(static_cast<double>(counts.rays) / samples());
  }

  const PathTracer& tracer_;
  const Scene& scene_;
  SampleRange samples_;
  Vec3d forward_;
  Channels channels_;
  // The values of the channels; null: not wanted.
  float* depth_ = nullptr;
  VectorPlanes normal_{};
  VectorPlanes albedo_{};
  std::uint32_t* sphere_ = nullptr;
  float* cost_ = nullptr;
};

/// Samples of a piece of work, about a millisecond.
constexpr std::uint32_t piece_samples = 2048;
/// Samples between two calls of `between_bands`. The number is large enough that threads rarely
/// wait for each other.
constexpr std::uint32_t band_samples = 1U << 18;

/// Calls visit(run) for runs that cover the picture. `samples` is the mean number of samples per
/// pixel. Every thread has a copy of `visit`.
template <typename Visit>
void for_runs(const RenderSettings& settings, std::uint32_t samples, int threads,
              const std::function<void()>& between_bands, const Visit& visit) {
  const std::uint32_t width = settings.width;
  const std::uint32_t piece = std::clamp(piece_samples / samples, 1U, width);
  const std::uint32_t pieces_in_row = (width + piece - 1) / piece;
  const std::uint32_t rows = std::max(band_samples / samples / width, 1U);
  for (std::uint32_t y = 0; y < settings.height; y += rows) {
    if (between_bands) between_bands();
    const std::int64_t count = std::int64_t{std::min(rows, settings.height - y)} * pieces_in_row;
#pragma omp parallel num_threads(threads)
    {
      const FloatMode ieee;
      Visit own = visit;
#pragma omp for schedule(dynamic) nowait
      for (std::int64_t i = 0; i < count; ++i) {
        const auto row = static_cast<std::uint32_t>(i / pieces_in_row);
        const auto begin = static_cast<std::uint32_t>(i % pieces_in_row) * piece;
        own(PixelRun{y + row, begin, std::min(begin + piece, width)});
      }
    }
  }
}

}  // namespace

Channels trace_channels(const PathTracer& tracer, const Scene& scene,
                        const RenderSettings& settings, const Aovs& wanted, int threads,
                        const std::function<void()>& between_bands) {
  const std::size_t width = settings.width;
  ChannelPlanes planes(tracer, scene, settings, wanted, width * settings.height);
  for_runs(settings, planes.samples(), threads, between_bands,
           [&planes, width, scratch = std::vector<FirstHit>()](const PixelRun& run) mutable {
             planes.fill(run, run.y * width + run.x_begin, scratch);
           });
  return planes.take();
}

Channels trace_channels(const PathTracer& tracer, const Scene& scene,
                        const RenderSettings& settings, const Aovs& wanted,
                        std::span<const PixelRun> pixels, int threads) {
  ChannelPlanes planes(tracer, scene, settings, wanted, pixels.size());
#pragma omp parallel num_threads(threads)
  {
    const FloatMode ieee;
    std::vector<FirstHit> scratch;
#pragma omp for schedule(dynamic) nowait
    for (std::size_t i = 0; i < pixels.size(); ++i) planes.fill(pixels[i], i, scratch);
  }
  return planes.take();
}

std::vector<SkySamples> trace_sky_samples(const PathTracer& tracer, const RenderSettings& settings,
                                          std::span<const std::uint32_t> samples, int threads,
                                          const std::function<void()>& between_bands) {
  std::vector<SkySamples> sky(std::size_t{settings.width} * settings.height);
  const std::uint64_t mean =
      std::accumulate(samples.begin(), samples.end(), std::uint64_t{0}) / samples.size();
  const auto trace = [&, ranges = std::vector<SampleRange>()](const PixelRun& run) mutable {
    const std::size_t first = std::size_t{run.y} * settings.width + run.x_begin;
    ranges.clear();
    for (const std::uint32_t count : samples.subspan(first, run.x_end - run.x_begin)) {
      ranges.push_back({0, count});
    }
    tracer.add_sky_samples(run, RunSamples(ranges), std::span(sky).subspan(first, ranges.size()));
  };
  for_runs(settings, static_cast<std::uint32_t>(std::max(mean, std::uint64_t{1})), threads,
           between_bands, trace);
  return sky;
}

}  // namespace parray::output
