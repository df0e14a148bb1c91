#include "cli/check/compare/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <utility>

#include "cli/check/compare/metrics.h"
#include "common/base/bands.h"

namespace parray::compare {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double pixels_per_degree = 0.7 * (3840 / 0.7) * pi / 180;

/// One number per pixel, row by row.
struct Plane {
  std::ptrdiff_t width;
  std::ptrdiff_t height;
  std::vector<float> values;

  Plane(std::ptrdiff_t w, std::ptrdiff_t h)
      : width(w), height(h), values(static_cast<std::size_t>(w * h)) {}
  float* row(std::ptrdiff_t y) { return values.data() + y * width; }
  [[nodiscard]] const float* row(std::ptrdiff_t y) const { return values.data() + y * width; }
};

// ---- Filters ---------------------------------------------------------------------------------

/// Weights of a filter at -radius to radius.
using Filter = std::vector<float>;

std::vector<double> sampled(int radius, const auto& function) {
  std::vector<double> weights;
  for (int i = -radius; i <= radius; ++i) weights.push_back(function(i));
  return weights;
}

double sum_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum;
}

/// Divides positive weights by `positive` and negative ones by `negative`.
Filter scaled(const std::vector<double>& weights, double positive, double negative) {
  Filter filter;
  for (const double w : weights) {
    filter.push_back(static_cast<float>(w / (w > 0 ? positive : negative)));
  }
  return filter;
}

/// Filters that blur the three opponent channels as an eye does at that distance (the paper's
/// 4.1.1, after Johnson and Fairchild, 2003). They are Gaussians of the distance in degrees: the
/// transform exp(-pi^2 x^2 / b) sqrt(pi / b) a of the eye's contrast sensitivity. The filter for
/// blue-yellow is a sum of two Gaussians; each is separable, and their sum is normalised.
struct EyeFilters {
  Filter luminance;
  Filter red_green;
  std::array<Filter, 2> blue_yellow;
};

/// Returns the filter in one dimension. Its product with itself is the two-dimensional Gaussian.
std::vector<double> eye_gaussian(double a, double b) {
  constexpr double widest = 0.04;  // the largest b
  const int radius =
      static_cast<int>(std::ceil(3 * std::sqrt(widest / (2 * pi * pi)) * pixels_per_degree));
  return sampled(radius, [a, b](int i) {
    const double x = i / pixels_per_degree;
    return std::sqrt(a * std::sqrt(pi / b)) * std::exp(-pi * pi * x * x / b);
  });
}

EyeFilters eye_filters() {
  const auto alone = [](double a, double b) {
    const std::vector<double> weights = eye_gaussian(a, b);
    return scaled(weights, sum_of(weights), 1);
  };
  const std::vector<double> narrow = eye_gaussian(34.1, 0.04);
  const std::vector<double> wide = eye_gaussian(13.5, 0.025);
  const double together = std::hypot(sum_of(narrow), sum_of(wide));
  return {
      alone(1, 0.0047), alone(1, 0.0053), {scaled(narrow, together, 1), scaled(wide, together, 1)}};
}

/// Detectors of edges and points (the paper's 4.2.1): a Gaussian as wide as a clearly visible edge,
/// and its derivatives. Their positive weights add up to 1, their negative ones to -1.
struct FeatureFilters {
  Filter gaussian;
  Filter first;
  Filter second;
};

FeatureFilters feature_filters() {
  constexpr double edge_width = 0.082;  // degrees
  const double sigma = edge_width / 2 * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  const auto gaussian = [sigma](int i) { return std::exp(-i * i / (2 * sigma * sigma)); };
  const auto balanced = [](const std::vector<double>& weights) {
    double positive = 0;
    double negative = 0;
    for (const double w : weights) (w > 0 ? positive : negative) += std::abs(w);
    return scaled(weights, positive, negative);
  };
  const std::vector<double> smooth = sampled(radius, gaussian);
  return {scaled(smooth, sum_of(smooth), 1),
          balanced(sampled(radius, [&](int i) { return -i * gaussian(i); })),
          balanced(
              sampled(radius, [&](int i) { return (i * i / (sigma * sigma) - 1) * gaussian(i); }))};
}

void add_weighted(float weight, const float* values, std::ptrdiff_t count, float* sum) {
  for (std::ptrdiff_t x = 0; x < count; ++x) sum[x] += weight * values[x];
}

/// Filters the rows. Beyond the picture, its border pixels repeat.
Plane filtered_across(const Plane& in, const Filter& filter) {
  const auto radius = static_cast<std::ptrdiff_t>(filter.size() / 2);
  Plane out(in.width, in.height);
  for (std::ptrdiff_t y = 0; y < in.height; ++y) {
    const float* row = in.row(y);
    std::vector<float> padded(static_cast<std::size_t>(in.width + 2 * radius), row[in.width - 1]);
    std::fill_n(padded.begin(), radius, row[0]);
    std::copy_n(row, in.width, padded.begin() + radius);
    for (std::size_t k = 0; k < filter.size(); ++k) {
      add_weighted(filter[k], padded.data() + k, in.width, out.row(y));
    }
  }
  return out;
}

void add_filtered_down(const Plane& in, const Filter& filter, Plane& out) {
  const auto size = static_cast<std::ptrdiff_t>(filter.size());
  for (std::ptrdiff_t y = 0; y < in.height; ++y) {
    for (std::ptrdiff_t k = 0; k < size; ++k) {
      const std::ptrdiff_t from = std::clamp<std::ptrdiff_t>(y + k - size / 2, 0, in.height - 1);
      add_weighted(filter[static_cast<std::size_t>(k)], in.row(from), in.width, out.row(y));
    }
  }
}

Plane filtered(const Plane& in, const Filter& across, const Filter& down) {
  Plane out(in.width, in.height);
  add_filtered_down(filtered_across(in, across), down, out);
  return out;
}

// ---- Colours ---------------------------------------------------------------------------------

using Colour = std::array<float, 3>;
using Matrix = std::array<Colour, 3>;

/// Converts linear RGB with sRGB's primaries to CIE XYZ, divided by the XYZ of white (D65: x
/// 0.31271, y 0.32902).
constexpr Matrix xyz_of_rgb = {{{0.433895389F, 0.376242373F, 0.189862239F},
                                {0.212636822F, 0.715182982F, 0.072180196F},
                                {0.017752423F, 0.109465629F, 0.872781948F}}};
constexpr Matrix rgb_of_xyz = {{{3.080341988F, -1.537398969F, -0.542943019F},
                                {-0.921178396F, 1.875929984F, 0.045248412F},
                                {0.052881293F, -0.204011206F, 1.151129913F}}};

Colour product(const Matrix& m, const Colour& v) {
  Colour result{};
  for (std::size_t i = 0; i < 3; ++i) result[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
  return result;
}

/// CIELAB's compression of a response relative to white.
float lab_response(float t) {
  constexpr float delta = 6.0F / 29;
  return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0F / 29;
}

/// CIELAB with Hunt's effect: darker colours are less colourful. (The paper's 4.1.2.)
Colour perceived(const Colour& rgb) {
  const Colour xyz = product(xyz_of_rgb, rgb);
  const Colour f = {lab_response(xyz[0]), lab_response(xyz[1]), lab_response(xyz[2])};
  const float lightness = 116 * f[1] - 16;
  const float hunt = 0.01F * lightness;
  return {lightness, hunt * 500 * (f[0] - f[1]), hunt * 200 * (f[1] - f[2])};
}

/// Returns the distance HyAB (Abasi et al., 2020) to the power qc = 0.7.
float colour_distance(const Colour& a, const Colour& b) {
  const float red_green = a[1] - b[1];
  const float blue_yellow = a[2] - b[2];
  return std::pow(
      std::abs(a[0] - b[0]) + std::sqrt(red_green * red_green + blue_yellow * blue_yellow), 0.7F);
}

/// Divides a distance by the largest one, that of green and blue. Maps its first 0.4 (pc) to 0.95
/// (pt) of [0, 1]. (The paper's equation 7.)
float bent(float distance) {
  constexpr float knee = 0.4F;
  constexpr float level = 0.95F;
  static const float largest = colour_distance(perceived({0, 1, 0}), perceived({0, 0, 1}));
  const float d = distance / largest;
  return d < knee ? d * level / knee : level + (d - knee) / (1 - knee) * (1 - level);
}

// ---- The visible features of a picture -------------------------------------------------------

/// The opponent channels of the paper's YCxCz: Y (luminance), X - Y and Y - Z of XYZ relative to
/// white. The paper's constant factors cancel and are left out.
std::array<Plane, 3> opponent_channels(const Image& image) {
  const std::ptrdiff_t width = image.width;
  const std::ptrdiff_t height = image.height;
  std::array<Plane, 3> planes = {Plane(width, height), Plane(width, height), Plane(width, height)};
  for (std::size_t i = 0; i < planes[0].values.size(); ++i) {
    const float* rgb = image.rgb.data() + i * 3;
    const Colour xyz = product(xyz_of_rgb, {rgb[0], rgb[1], rgb[2]});
    planes[0].values[i] = xyz[1];
    planes[1].values[i] = xyz[0] - xyz[1];
    planes[2].values[i] = xyz[1] - xyz[2];
  }
  return planes;
}

struct Seen {
  std::vector<Colour> colours;
  std::vector<float> edges;
  std::vector<float> points;
};

std::vector<Colour> seen_colours(const std::array<Plane, 3>& channels) {
  static const EyeFilters eye = eye_filters();
  const Plane y = filtered(channels[0], eye.luminance, eye.luminance);
  const Plane red_green = filtered(channels[1], eye.red_green, eye.red_green);
  Plane blue_yellow(y.width, y.height);
  for (const Filter& filter : eye.blue_yellow) {
    add_filtered_down(filtered_across(channels[2], filter), filter, blue_yellow);
  }
  std::vector<Colour> colours(y.values.size());
  for (std::size_t i = 0; i < colours.size(); ++i) {
    const float luminance = y.values[i];
    Colour rgb = product(rgb_of_xyz, {luminance + red_green.values[i], luminance,
                                      luminance - blue_yellow.values[i]});
    for (float& value : rgb) value = std::clamp(value, 0.0F, 1.0F);
    colours[i] = perceived(rgb);
  }
  return colours;
}

/// Returns the length of the gradient that a derivative's filter detects.
std::vector<float> seen_features(const Plane& y, const Filter& derivative, const Filter& gaussian) {
  Plane across = filtered(y, derivative, gaussian);
  const Plane down = filtered(y, gaussian, derivative);
  for (std::size_t i = 0; i < across.values.size(); ++i) {
    const float dx = across.values[i];
    const float dy = down.values[i];
    across.values[i] = std::sqrt(dx * dx + dy * dy);
  }
  return std::move(across.values);
}

/// Returns the visible features of `image`, whose values are in [0, 1].
Seen seen(const Image& image) {
  static const FeatureFilters features = feature_filters();
  const std::array<Plane, 3> channels = opponent_channels(image);
  return {seen_colours(channels), seen_features(channels[0], features.first, features.gaussian),
          seen_features(channels[0], features.second, features.gaussian)};
}

/// Returns the difference of colours, increased by the difference of features. (The paper's 4.2.2
/// and 4.3.)
FlipMap difference(const Seen& r, const Seen& f) {
  FlipMap map(r.colours.size());
  for (std::size_t i = 0; i < map.size(); ++i) {
    const float colour = bent(colour_distance(r.colours[i], f.colours[i]));
    const float feature =
        std::max(std::abs(r.edges[i] - f.edges[i]), std::abs(r.points[i] - f.points[i]));
    // The power qf = 0.5. Rounding must not leave [0, 1].
    const float raised = std::min(std::sqrt(feature / std::numbers::sqrt2_v<float>), 1.0F);
    map[i] = std::min(std::pow(colour, 1 - raised), 1.0F);
  }
  return map;
}

// ---- Pixels that are not finite --------------------------------------------------------------

struct Pair {
  Image reference;
  Image image;
};

/// Both pictures. A pixel that is not finite in one of them is black in both; negative values are
/// 0.
Pair cleaned(const Image& reference, const Image& image) {
  Pair pair{reference, image};
  for (std::size_t i = 0; i < image.rgb.size(); ++i) {
    const bool finite = finite_pixel(reference, i / 3) && finite_pixel(image, i / 3);
    for (float* value : {&pair.reference.rgb[i], &pair.image.rgb[i]}) {
      *value = finite ? std::max(*value, 0.0F) : 0.0F;
    }
  }
  return pair;
}

FlipMap without_nonfinite(FlipMap map, const Image& reference, const Image& image) {
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (!finite_pixel(reference, i) || !finite_pixel(image, i)) {
      map[i] = std::numeric_limits<float>::quiet_NaN();
    }
  }
  return map;
}

// ---- Exposures -------------------------------------------------------------------------------

/// Narkowicz's fit of the ACES tone mapper (2015) without its built-in exposure of 0.6:
/// x (a x + b) / (x (c x + d) + e).
struct ToneMapper {
  double a = 0.6 * 0.6 * 2.51;
  double b = 0.6 * 0.03;
  double c = 0.6 * 0.6 * 2.43;
  double d = 0.6 * 0.59;
  double e = 0.14;

  [[nodiscard]] double operator()(double x) const {
    return x * (a * x + b) / (x * (c * x + d) + e);
  }
  /// Returns the positive value that is mapped to `level`, which is between b / d and a / c.
  [[nodiscard]] double inverse(double level) const {
    const double half = (b - level * d) / (a - level * c) / 2;
    return -half + std::sqrt(half * half + level * e / (a - level * c));
  }
};

/// Returns `image` at an exposure of `stops`, tone-mapped to [0, 1].
Image photographed(const Image& image, double stops) {
  const ToneMapper tone;
  const double factor = std::exp2(stops);
  Image result = image;
  for (std::size_t i = 0; i < result.rgb.size(); ++i) {
    result.rgb[i] = static_cast<float>(std::min(tone(factor * image.rgb[i]), 1.0));
  }
  return result;
}

/// Returns the exposures for a reference without negative values. A median or maximum of 0 counts
/// as float's epsilon.
HdrFlip exposures_for(const Image& reference) {
  std::vector<float> luminances;
  for (std::size_t i = 0; i < reference.rgb.size(); i += 3) {
    const float* rgb = reference.rgb.data() + i;
    luminances.push_back(static_cast<float>(0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]));
  }
  const auto middle = luminances.begin() + static_cast<std::ptrdiff_t>(luminances.size() / 2);
  std::nth_element(luminances.begin(), middle, luminances.end());
  const float median = std::max(*middle, std::numeric_limits<float>::epsilon());
  const float largest = std::max(*std::max_element(middle, luminances.end()), median);
  const double shown = ToneMapper().inverse(0.85);
  HdrFlip result;
  result.start_exposure = std::log2(shown / largest);
  result.stop_exposure = std::log2(shown / median);
  const double stops = result.stop_exposure - result.start_exposure;
  result.exposures = std::max(2, static_cast<int>(std::ceil(stops)));
  return result;
}

/// Returns FLIP of both pictures after `show`, with one thread for each picture. With smaller tasks
/// the threads would wait for each other hundreds of times.
FlipMap flip_of(const Pair& pair, const auto& show) {
  const std::array<const Image*, 2> pictures = {&pair.reference, &pair.image};
  std::array<Seen, 2> both;
  base::side_by_side(2, 2, [&](std::size_t i) { both.at(i) = seen(show(*pictures.at(i))); });
  return difference(both[0], both[1]);
}

/// Clamps a picture to [0, 1], as a screen does.
Image clamped(const Image& image) {
  Image result = image;
  for (float& value : result.rgb) value = std::min(value, 1.0F);
  return result;
}

}  // namespace

FlipMap flip(const Image& reference, const Image& image) {
  return without_nonfinite(flip_of(cleaned(reference, image), clamped), reference, image);
}

HdrFlip hdr_flip(const Image& reference, const Image& image) {
  const Pair pair = cleaned(reference, image);
  HdrFlip result = exposures_for(pair.reference);
  result.map.resize(reference.rgb.size() / 3);
  const double step = (result.stop_exposure - result.start_exposure) / (result.exposures - 1);
  for (int i = 0; i < result.exposures; ++i) {
    const double stops = result.start_exposure + i * step;
    const FlipMap map =
        flip_of(pair, [stops](const Image& one) { return photographed(one, stops); });
    for (std::size_t p = 0; p < map.size(); ++p) result.map[p] = std::max(result.map[p], map[p]);
  }
  result.map = without_nonfinite(std::move(result.map), reference, image);
  return result;
}

double mean_of(const FlipMap& map) {
  double sum = 0;
  std::size_t count = 0;
  for (const float value : map) {
    if (std::isnan(value)) continue;
    sum += value;
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace parray::compare
