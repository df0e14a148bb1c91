#include "cli/measure/tradeoff/reference.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "cli/measure/tradeoff/variant.h"
#include "cli/output/picture/image_file.h"
#include "cli/output/picture/srgb.h"
#include "common/adaptive/error_estimate.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/image/image.h"
#include "common/image/radiance_scale.h"
#include "common/scene/settings.h"

namespace parray::tradeoff {
namespace {

constexpr const char* samples_name = "parray:reference_samples";
constexpr const char* chunks_name = "parray:reference_chunks";

/// Linear light of the 256 codes, and the borders between adjacent codes.
struct Codes {
  std::array<double, 256> light{};
  std::array<double, 255> border{};

  Codes() {
    for (std::size_t i = 0; i < light.size(); ++i) {
      light.at(i) = srgb_decode(static_cast<double>(i) / 255);
    }
    for (std::size_t i = 0; i < border.size(); ++i) {
      border.at(i) = srgb_decode((static_cast<double>(i) + 0.5) / 255);
    }
  }
};

double number_in(const ImageMetadata& metadata, const std::string& name, const std::string& file) {
  const double number = real_in(metadata, name).value_or(0);
  if (number > 0 && number < 1e15) return number;
  throw InputError(file + ": " + name + " is missing: start again with --restart");
}

}  // namespace

double through_8bit(double value) {
  static const Codes codes;
  const auto code = std::ranges::upper_bound(codes.border, value);
  return codes.light.at(static_cast<std::size_t>(code - codes.border.begin()));
}

Reference::Reference(std::uint32_t width, std::uint32_t height)
    : width_(width), height_(height), square_(std::size_t{width} * height * 3) {
  half_.fill(square_);
}

RenderSettings Reference::settings_of(const RenderSettings& base) {
  RenderSettings settings = base;
  settings.sampler = Sampler::independent;
  settings.precision = Precision::f64;
  settings.max_depth = reference_depth(base.max_depth);
  return settings;
}

void Reference::add(const DirectRender& chunk) {
  const std::size_t half = chunks_ % 2;
  const double samples = chunk.samples_per_pixel();
  const Image image = resolve_image(chunk.framebuffer, chunk.largest_radiance);
  const RadianceScale scale(chunk.largest_radiance);
  const FramebufferView state = chunk.state();
  const double of_half = samples / (samples_[half] + samples);
  const double of_all = samples / (this->samples() + samples);
  for (std::size_t i = 0; i < square_.size(); ++i) {
    const std::uint32_t count = state.counts[i / 3];
    const double square = scale.mean_square(state.pixels[i / 3].sum_of_squares[i % 3], count);
    half_[half][i] += of_half * (static_cast<double>(image.rgb[i]) - half_[half][i]);
    square_[i] += of_all * (square - square_[i]);
  }
  samples_[half] += samples;
  ++chunks_;
}

double Reference::rmse() const {
  double sum = 0;
  for (std::size_t i = 0; i < square_.size(); ++i) {
    const double half_difference = (half_[0][i] - half_[1][i]) / 2;
    sum += half_difference * half_difference;
  }
  return std::sqrt(sum / static_cast<double>(square_.size()));
}

double Reference::variance(std::size_t i) const {
  return std::max(square_[i] - mean(i) * mean(i), 0.0) / samples();
}

Run Reference::errors_of(const std::vector<float>& picture) const {
  Run run;
  double scatter = 0;
  for (std::size_t i = 0; i < square_.size(); ++i) {
    const double value = picture[i];
    const double coded = through_8bit(value);
    const double first = half_[0][i];
    const double second = half_[1][i];
    run.mse += (value - first) * (value - second);
    run.mse_8bit += (coded - first) * (coded - second);
    run.quantisation += (coded - value) * (coded - value);
    run.bias += value - mean(i);
    // Variance of (e - u)(e - w): with v the variance of the mean, u + w has the variance 4 v, and
    // u w has 4 v^2.
    const double square = std::max((value - first) * (value - second), 0.0);
    scatter += 4 * (square + variance(i)) * variance(i);
  }
  const auto values = static_cast<double>(square_.size());
  for (double* sum : {&run.mse, &run.mse_8bit, &run.quantisation, &run.bias}) *sum /= values;
  run.mse_scatter = std::sqrt(3 * scatter) / values;  // as if all channels had the same noise
  return run;
}

ByLevel Reference::coverage_of(const std::vector<float>& picture, const ErrorEstimate& estimate,
                               const ErrorIntervals& intervals) const {
  ByLevel hold{};
  double asked = 0;
  for (std::size_t i = 0; i < square_.size(); ++i) {
    // Leaves out values that differ only in the last bit of a float: they have no noise.
    if (variance(i) * samples() <= 1e-12 * mean(i) * mean(i)) continue;
    const double error = std::max(std::abs(picture[i] - mean(i)) - 1e-6 * mean(i), 0.0);
    ++asked;
    for (std::size_t level = 0; level < hold.size(); ++level) {
      const double doubt = normal_half_widths.at(level) * std::sqrt(variance(i));
      const double half_width = intervals.scale(level) * estimate.half_width[i];
      hold.at(level) += error <= std::hypot(half_width, doubt) ? 1 : 0;
    }
  }
  for (double& share : hold) share = asked > 0 ? share / asked : 1;
  return hold;
}

Run Reference::compare(const DirectRender& picture) const {
  const Image image = resolve_image(picture.framebuffer, picture.largest_radiance);
  const ErrorEstimate estimate = estimate_error(picture.state());
  Run run = errors_of(image.rgb);
  if (!estimate.known()) return run;
  const ErrorIntervals intervals(picture.state(), estimate);
  run.coverage = coverage_of(image.rgb, estimate, intervals);
  run.claimed = estimate.rmse;
  run.low = estimate.low;
  run.high = estimate.high;
  for (std::size_t level = 0; level < run.claims.size(); ++level) {
    const auto [low, high] = intervals.rmse(level);
    run.claims.at(level) = claim_holds(run, low, high, level) ? 1 : 0;
  }
  return run;
}

Run Reference::compare(const Denoised& picture) const {
  Run run = errors_of(picture.rgb);
  run.claimed = picture.rmse;
  run.low = picture.low;
  run.high = picture.high;
  // Works with squares, because the stated interval is symmetric in them.
  const double square = picture.rmse * picture.rmse;
  const double half_width = picture.high * picture.high - square;
  for (std::size_t level = 0; level < run.claims.size(); ++level) {
    const double scaled =
        half_width * normal_half_widths.at(level) / normal_half_widths[stated_level];
    const double low = std::sqrt(std::max(square - scaled, 0.0));
    run.claims.at(level) = claim_holds(run, low, std::sqrt(square + scaled), level) ? 1 : 0;
  }
  return run;
}

void Reference::save(const std::filesystem::path& path) const {
  Image picture{width_, height_, std::vector<float>(square_.size())};
  std::vector<double> variance(square_.size());
  for (std::size_t i = 0; i < square_.size(); ++i) {
    picture.rgb[i] = static_cast<float>(mean(i));
    variance[i] = std::max(square_[i] - mean(i) * mean(i), 0.0);
  }
  Channels channels;
  add_rgb(channels, "first.", half_[0]);
  add_rgb(channels, "second.", half_[1]);
  add_rgb(channels, "variance.", variance);
  write_image(
      path, picture,
      {{"Software", "ParRay " PARRAY_VERSION}, {samples_name, samples_[0]}, {chunks_name, chunks_}},
      channels);
}

void Reference::load(const std::filesystem::path& path) {
  const std::string file = printable(path.string(), 4096);
  const ImageFile read = read_image(path);
  if (read.image.width != width_ || read.image.height != height_) {
    throw InputError(file + ": has another size than the measurements: start again with --restart");
  }
  samples_.fill(number_in(read.metadata, samples_name, file));
  chunks_ = static_cast<std::uint64_t>(number_in(read.metadata, chunks_name, file));
  const std::size_t pixels = square_.size() / 3;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto channel = [&](const std::string& prefix) -> const std::vector<float>& {
      const auto* const values = values_in<float>(read.channels, prefix + "RGB"[c]);
      if (values != nullptr && values->size() == pixels) return *values;
      throw InputError(file + ": channel " + prefix + "RGB"[c] +
                       " is missing: start again with --restart");
    };
    const auto& first = channel("first.");
    const auto& second = channel("second.");
    const auto& variance = channel("variance.");
    for (std::size_t i = 0; i < pixels; ++i) {
      const std::size_t value = 3 * i + c;
      half_[0][value] = first[i];
      half_[1][value] = second[i];
      square_[value] = variance[i] + mean(value) * mean(value);
    }
  }
}

}  // namespace parray::tradeoff
