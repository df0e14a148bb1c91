#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "cli/measure/tradeoff/analysis.h"
#include "cli/measure/tradeoff/bench.h"

/// Systematic errors from pairs of renders with the same random numbers. Both have nearly the same
/// noise, so it does not hide the difference.
namespace parray::tradeoff {

/// Collects the differences of pairs of pictures. Each pair has its own seed.
class PairedDifference {
 public:
  void add(const std::vector<float>& picture, const std::vector<float>& from);
  /// Returns the mean square of the mean difference. It is unbiased because it uses only products
  /// of different pairs. Precondition: at least two pairs.
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

/// `samples`: per pixel of each render. Calls `next` after each render with the completed share.
PairedBiases measure_pairs(Bench& bench, const RenderSettings& base, std::uint32_t samples,
                           const std::function<void(double)>& next);
/// Returns the number of renders that measure_pairs() makes.
std::size_t paired_renders(const RenderSettings& base);

nlohmann::json to_json(const PairedBiases& biases);
/// The inverse of to_json(). Throws nlohmann::json::exception or InputError for any other value.
PairedBiases paired_biases_from(const nlohmann::json& map);

}  // namespace parray::tradeoff
