#include "cli/check/compare/metrics.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

namespace parray::compare {
namespace {

struct Sums {
  double square = 0;
  double relative_square = 0;
  double symmetric = 0;
  double absolute = 0;
  double difference = 0;

  void add(double r, double f) {
    const double error = f - r;
    const double size = std::abs(error);
    square += error * error;
    relative_square += error * error / (r * r + relative_epsilon);
    symmetric += size / (std::abs(f) + std::abs(r) + relative_epsilon);
    absolute += size;
    difference += error;
  }
};

/// Returns the value of rank ceil(0.999 n), counted from 1 (nearest rank). Reorders `values`, which
/// must not be empty.
double percentile_999(std::vector<double>& values) {
  const std::size_t rank = values.size() - values.size() / 1000;
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(rank - 1);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

void set_means(const Sums& sums, double count, ErrorMetrics& metrics) {
  metrics.mse = sums.square / count;
  metrics.rmse = std::sqrt(metrics.mse);
  metrics.psnr = -10 * std::log10(metrics.mse);
  metrics.relative_mse = sums.relative_square / count;
  metrics.smape = sums.symmetric / count;
  metrics.mean_absolute = sums.absolute / count;
  metrics.bias = sums.difference / count;
}

void set_to_none(ErrorMetrics& metrics) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  set_means({none, none, none, none, none}, 1, metrics);
  metrics.absolute_999 = metrics.largest_absolute = none;
}

}  // namespace

bool finite_pixel(const Image& image, std::size_t index) {
  const float* rgb = image.rgb.data() + index * 3;
  return std::isfinite(rgb[0]) && std::isfinite(rgb[1]) && std::isfinite(rgb[2]);
}

bool same_bits(const Image& a, const Image& b) {
  return a.width == b.width && a.height == b.height &&
         std::memcmp(a.rgb.data(), b.rgb.data(), a.rgb.size() * sizeof(float)) == 0;
}

ErrorMetrics error_metrics(const Image& reference, const Image& image) {
  ErrorMetrics metrics;
  Sums sums;
  std::vector<double> errors;
  errors.reserve(reference.rgb.size());
  std::size_t worst = 0;
  for (std::size_t pixel = 0; pixel < reference.rgb.size() / 3; ++pixel) {
    const bool r_finite = finite_pixel(reference, pixel);
    const bool f_finite = finite_pixel(image, pixel);
    metrics.nonfinite_in_reference += r_finite ? 0 : 1;
    metrics.nonfinite_in_image += f_finite ? 0 : 1;
    if (!r_finite || !f_finite) {
      ++metrics.excluded;
      continue;
    }
    ++metrics.compared;
    for (std::size_t i = pixel * 3; i < pixel * 3 + 3; ++i) {
      const double r = reference.rgb[i];
      const double f = image.rgb[i];
      sums.add(r, f);
      errors.push_back(std::abs(f - r));
      if (errors.back() > metrics.largest_absolute || errors.size() == 1) {
        metrics.largest_absolute = errors.back();
        worst = pixel;
      }
    }
  }
  if (!metrics.any()) {
    set_to_none(metrics);
    return metrics;
  }
  set_means(sums, static_cast<double>(errors.size()), metrics);
  metrics.absolute_999 = percentile_999(errors);
  metrics.worst_x = static_cast<std::uint32_t>(worst % reference.width);
  metrics.worst_y = static_cast<std::uint32_t>(worst / reference.width);
  return metrics;
}

DifferenceImage::DifferenceImage(const Image& reference)
    : reference_(reference),
      sum_{reference.width, reference.height, std::vector<float>(reference.rgb.size())} {}

void DifferenceImage::add(const Image& image) {
  for (std::size_t i = 0; i < sum_.rgb.size(); ++i) {
    const float r = reference_.rgb[i];
    const float f = image.rgb[i];
    if (r == f || (std::isnan(r) && std::isnan(f))) continue;
    const float difference = std::abs(r - f);
    sum_.rgb[i] += std::isnan(difference) ? 1 : difference;
  }
}

float DifferenceImage::largest() const { return *std::ranges::max_element(sum_.rgb); }

Image DifferenceImage::drawn() const {
  Image picture = sum_;
  for (float& value : picture.rgb) value = std::max(0.0F, 1 - value);
  return picture;
}

}  // namespace parray::compare
