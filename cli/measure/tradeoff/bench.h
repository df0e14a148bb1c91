#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "cli/farm/direct_render.h"
#include "cli/measure/plan/effort.h"
#include "cli/measure/tradeoff/analysis.h"
#include "cli/output/denoise/denoise.h"
#include "common/scene/scene.h"

namespace parray::tradeoff {

/// A denoised picture, and the time for tracing its features and filtering it.
struct DenoisedRender {
  Denoised picture;
  Effort effort;
};

/// Renders one scene with various settings, with `threads` > 0 threads. Not thread-safe. The scene
/// and `stop` must outlive this object.
class Bench {
 public:
  Bench(const Scene& scene, int threads, const std::atomic<bool>& stop)
      : scene_(scene), threads_(threads), stop_(stop) {}

  /// Renders the scene once. `settings` must be resolved: no value is `automatic`, except perhaps
  /// `isa`. Builds an accelerator for each combination of precision, kind and instruction set when
  /// it is first needed, outside the measured time, and keeps them all. Throws Interrupted if
  /// `stop` becomes true, or after an interrupt of the user.
  [[nodiscard]] DirectRender render(const RenderSettings& settings);

  /// Denoises `picture`, the result of render(settings). Throws InputError if a pixel has fewer
  /// than two samples, Interrupted after an interrupt of the user.
  [[nodiscard]] DenoisedRender denoise(const RenderSettings& settings, const DirectRender& picture);

  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] int threads() const { return threads_; }

 private:
  const std::shared_ptr<const Accelerator>& accelerator_for(const RenderSettings& settings);

  const Scene& scene_;
  const int threads_;
  std::vector<std::shared_ptr<const Accelerator>> accelerators_;
  const std::atomic<bool>& stop_;
};

/// Collects the differences of pairs of pictures. Both pictures of a pair must have the same seed,
/// and different pairs different seeds.
class PairedDifference {
 public:
  /// Adds the difference `picture` - `from` of a pair. The pictures are linear radiance, 3 values
  /// per pixel, and all have the same size.
  void add(const std::vector<float>& picture, const std::vector<float>& from);
  /// Returns the mean square, over all pixels, of the mean difference of all pairs. It is unbiased
  /// because it uses only products of different pairs. Precondition: at least two pairs.
  [[nodiscard]] PairedBias bias() const;

 private:
  std::vector<double> sum_;
  std::vector<double> squares_;
  double pairs_ = 0;
};

/// The systematic error of the path depths depths_of(), and of the precisions f32 and mixed.
struct PairedBiases {
  std::map<std::uint32_t, PairedBias> depth;  ///< by path depth; reference: reference_depth()
  std::map<Precision, PairedBias> precision;  ///< by precision; reference: f64
};

/// Measures the systematic error of each depth and precision, from pairs of renders: one with this
/// value, one with a reference value. Both use the same random numbers and so have nearly the same
/// noise, which does not hide the difference. `base`: the scene's own settings. `samples`: per
/// pixel of each render. Calls `next` after each render with the share, 0 to 1, of all renders that
/// are complete. Throws Interrupted.
PairedBiases measure_pairs(Bench& bench, const RenderSettings& base, std::uint32_t samples,
                           const std::function<void(double)>& next);
/// Returns the number of renders that measure_pairs() makes.
std::size_t paired_renders(const RenderSettings& base);

nlohmann::json to_json(const PairedBiases& biases);
/// The inverse of to_json(). Throws nlohmann::json::exception or InputError for any other value.
PairedBiases paired_biases_from(const nlohmann::json& map);

}  // namespace parray::tradeoff
