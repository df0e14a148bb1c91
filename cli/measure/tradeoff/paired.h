#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "cli/measure/tradeoff/analysis.h"
#include "cli/measure/tradeoff/bench.h"

/// Systematic errors by pairs of renders with the same random numbers: what noise would hide is
/// seen, because both have the same.
namespace parray::tradeoff {

/// Collects differences of pictures, each pair with a seed of its own.
class PairedDifference {
 public:
  void add(const std::vector<float>& picture, const std::vector<float>& from);
  /// The mean square of the mean difference, unbiased: from products of different pairs alone.
  /// Precondition: two pairs or more.
  [[nodiscard]] PairedBias bias() const;

 private:
  std::vector<double> sum_;
  std::vector<double> squares_;
  double pairs_ = 0;
};

struct PairedBiases {
  std::map<std::uint32_t, PairedBias> depth;  ///< against reference_depth()
  std::map<Precision, PairedBias> precision;  ///< against f64
};

inline constexpr std::uint32_t pairs = 4;

/// `samples`: a pixel, of each render. `next` is called after each, with the share that is done.
PairedBiases measure_pairs(Bench& bench, const RenderSettings& base, std::uint32_t samples,
                           const std::function<void(double)>& next);
/// Renders that it takes.
std::size_t paired_renders(const RenderSettings& base);

nlohmann::json to_json(const PairedBiases& biases);
/// Throws nlohmann::json::exception or InputError when it is not what to_json() gives.
PairedBiases paired_biases_from(const nlohmann::json& map);

}  // namespace parray::tradeoff
