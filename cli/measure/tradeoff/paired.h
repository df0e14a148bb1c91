#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "cli/measure/tradeoff/analysis.h"
#include "cli/measure/tradeoff/bench.h"

/// Measures the systematic error of a path depth or a precision, from pairs of renders: one with
/// this value, one with a reference value. Both use the same random numbers and so have nearly the
/// same noise, which does not hide the difference.
namespace parray::tradeoff {

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

/// Number of pairs for each depth and each precision.
inline constexpr std::uint32_t pairs = 4;

/// Renders and compares the pairs. `base`: the scene's own settings. `samples`: per pixel of each
/// render. Calls `next` after each render with the share, 0 to 1, of all renders that are complete.
/// Throws Interrupted.
PairedBiases measure_pairs(Bench& bench, const RenderSettings& base, std::uint32_t samples,
                           const std::function<void(double)>& next);
/// Returns the number of renders that measure_pairs() makes.
std::size_t paired_renders(const RenderSettings& base);

nlohmann::json to_json(const PairedBiases& biases);
/// The inverse of to_json(). Throws nlohmann::json::exception or InputError for any other value.
PairedBiases paired_biases_from(const nlohmann::json& map);

}  // namespace parray::tradeoff
