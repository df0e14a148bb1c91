#include "tests/support/coverage.h"

#include <algorithm>
#include <cmath>

#include "common/adaptive/pixel_noise.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/settings.h"
#include "tests/support/rooms.h"

namespace parray::test {
namespace {

constexpr std::uint64_t reference_seed = 1'000'003;
constexpr std::size_t by_mean = 4;
constexpr std::size_t by_variance = 5;

}  // namespace

Reference trace_reference(const NoisyScene& scene, std::uint32_t samples) {
  RenderSettings settings = scene.settings;
  settings.seed = reference_seed;
  settings.sampler = Sampler::independent;
  GrowingPicture picture(settings, largest_radiance(scene.scene));
  picture.trace(*make_path_tracer(scene.scene, settings),
                std::vector<std::uint32_t>(picture.counts.size(), samples));
  Reference reference{picture.means(), {}, static_cast<double>(samples)};
  const RadianceScale scale(picture.largest_radiance);
  for (const PixelSums& pixel : picture.pixels) {
    for (const double variance : noise_of(pixel, samples, scale).variance) {
      reference.variance.push_back(variance);
    }
  }
  return reference;
}

double true_rmse(const GrowingPicture& picture, const Reference& reference) {
  const std::vector<double> means = picture.means();
  double square = 0;
  for (std::size_t i = 0; i < means.size(); ++i) {
    const double error = means[i] - reference.mean[i];
    square += error * error - reference.variance[i] / reference.samples;
  }
  return std::sqrt(std::max(0.0, square / static_cast<double>(means.size())));
}

Coverage::Coverage(const std::vector<Reference>& references) : references_(references) {
  struct Value {
    double mean, variance;
    std::size_t scene, index;
  };
  std::vector<Value> values;
  for (std::size_t scene = 0; scene < references.size(); ++scene) {
    const Reference& reference = references[scene];
    stratum_of_.emplace_back(reference.mean.size());
    for (std::size_t i = 0; i < reference.mean.size(); ++i) {
      values.push_back({reference.mean[i], reference.variance[i], scene, i});
    }
  }
  const auto cut = [&](std::size_t part, std::size_t of, std::size_t first, std::size_t last) {
    return values.begin() + static_cast<std::ptrdiff_t>(first + (last - first) * part / of);
  };
  std::sort(values.begin(), values.end(),
            [](const Value& a, const Value& b) { return a.mean < b.mean; });
  for (std::size_t m = 0; m < by_mean; ++m) {
    const auto first = cut(m, by_mean, 0, values.size());
    const auto last = cut(m + 1, by_mean, 0, values.size());
    std::sort(first, last, [](const Value& a, const Value& b) { return a.variance < b.variance; });
    for (auto value = first; value != last; ++value) {
      const auto v = static_cast<std::size_t>(value - first) * by_variance /
                     static_cast<std::size_t>(last - first);
      stratum_of_[value->scene][value->index] = static_cast<std::uint8_t>(m * by_variance + v);
    }
  }
}

void Coverage::add(std::size_t scene, const GrowingPicture& picture, const ErrorEstimate& error) {
  const Reference& reference = references_[scene];
  const std::vector<double> means = picture.means();
  std::array<double, strata> errors{};
  for (std::size_t i = 0; i < means.size(); ++i) {
    const double off = means[i] - reference.mean[i];
    // Widens the interval by the error of the reference.
    const double widened = std::sqrt(error.half_width[i] * error.half_width[i] +
                                     3.8415 * reference.variance[i] / reference.samples);
    const std::uint8_t at = stratum_of_[scene][i];
    Stratum& stratum = strata_[at];
    stratum.intervals += 1;
    stratum.hold += std::abs(off) <= widened ? 1 : 0;
    stratum.mean += reference.mean[i];
    stratum.half_width += error.half_width[i];
    errors[at] += off;
  }
  for (std::size_t at = 0; at < strata; ++at) {
    strata_[at].pictures += 1;
    strata_[at].error += errors[at];
    strata_[at].squares += errors[at] * errors[at];
  }
  const double rmse = true_rmse(picture, reference);
  pictures_ += 1;
  pictures_hold_ += error.low <= rmse && rmse <= error.high ? 1 : 0;
  claimed_ += error.rmse * error.rmse;
  true_ += rmse * rmse;
}

double Coverage::pooled() const {
  double intervals = 0;
  double hold = 0;
  for (const Stratum& stratum : strata_) {
    intervals += stratum.intervals;
    hold += stratum.hold;
  }
  return hold / intervals;
}

double Coverage::of_stratum(std::size_t stratum) const {
  return strata_[stratum].hold / strata_[stratum].intervals;
}

double Coverage::least_of_strata() const {
  double least = 1;
  for (std::size_t at = 0; at < strata; ++at) least = std::min(least, of_stratum(at));
  return least;
}

double Coverage::pictures() const { return pictures_hold_ / pictures_; }

double Coverage::claimed_to_true() const { return std::sqrt(claimed_ / true_); }

Coverage::Bias Coverage::bias(std::size_t at) const {
  const Stratum& stratum = strata_[at];
  const double spread = stratum.squares - stratum.error * stratum.error / stratum.pictures;
  return {stratum.error / stratum.mean, std::sqrt(spread) / stratum.mean,
          stratum.error / stratum.half_width};
}

}  // namespace parray::test
