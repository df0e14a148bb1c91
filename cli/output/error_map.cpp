#include "cli/output/error_map.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "cli/output/bitmap_font.h"
#include "cli/output/text.h"
#include "common/image/color_map.h"
#include "common/image/image_file.h"
#include "common/process/stop_signal.h"

namespace parray {
namespace {

using Colour = std::array<float, 3>;

constexpr Colour background = {0.01F, 0.01F, 0.01F};
constexpr Colour ink = {0.8F, 0.8F, 0.8F};

/// The largest number of 1, 2 or 5 times a power of ten that is not above `value` (> 0); `upwards`:
/// the least that is not below it.
double round_number(double value, bool upwards) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  constexpr std::array<double, 4> steps = {1, 2, 5, 10};
  constexpr double slack = 1e-6;  // a float of 0.1 is 0.1
  if (upwards) {
    return power * *std::find_if(steps.begin(), std::prev(steps.end()),
                                 [&](double step) { return step * power >= value * (1 - slack); });
  }
  return power * *std::find_if(steps.rbegin(), std::prev(steps.rend()),
                               [&](double step) { return step * power <= value * (1 + slack); });
}

/// A picture that is drawn on in dots: squares of `scale` pixels.
class Canvas {
 public:
  Canvas(std::uint32_t width, std::uint32_t height)
      : image_{width, height, std::vector<float>(std::size_t{3} * width * height)} {
    fill(0, 0, width, height, background);
  }

  void set(std::size_t x, std::size_t y, const Colour& colour) {
    std::copy(colour.begin(), colour.end(),
              image_.rgb.begin() + static_cast<std::ptrdiff_t>(3 * (y * image_.width + x)));
  }
  void fill(std::size_t x, std::size_t y, std::size_t width, std::size_t height,
            const Colour& colour) {
    for (std::size_t row = y; row < y + height; ++row) {
      for (std::size_t column = x; column < x + width; ++column) set(column, row, colour);
    }
  }
  void write(std::size_t x, std::size_t y, std::string_view text, std::size_t scale) {
    each_dot(text, [&](std::size_t dot_x, std::size_t dot_y) {
      fill(x + dot_x * scale, y + dot_y * scale, scale, scale, ink);
    });
  }
  Image take() { return std::move(image_); }

 private:
  Image image_;
};

constexpr std::string_view title = "95% half-width";
constexpr std::string_view unknown = "unknown";
// In dots.
constexpr std::size_t margin = 4;
constexpr std::size_t gap = 3;
constexpr std::size_t bar_height = 9;
constexpr std::size_t legend_height = 2 * margin + 2 * glyph_height + bar_height + 2 * gap;
constexpr std::size_t legend_width =
    2 * margin + text_width(title) + 4 * gap + glyph_height + text_width(unknown);

/// From row `top` on; `dot`: pixels of a dot's side.
void draw_legend(Canvas& canvas, std::size_t width, std::size_t top, std::size_t dot,
                 const ErrorScale& scale) {
  const std::size_t left = margin * dot;
  const std::size_t right = width - left;
  std::size_t y = top + margin * dot;
  canvas.write(left, y, title, dot);
  const std::size_t word = right - text_width(unknown) * dot;
  canvas.write(word, y, unknown, dot);
  canvas.fill(word - (gap + glyph_height) * dot, y, glyph_height * dot, glyph_height * dot,
              unknown_colour);
  y += (glyph_height + gap) * dot;
  for (std::size_t x = left; x < right; ++x) {
    const auto share = static_cast<double>(x - left) / static_cast<double>(right - left - 1);
    canvas.fill(x, y, 1, bar_height * dot, error_colour(share));
  }
  y += (bar_height + gap) * dot;
  for (const double share : {0.0, 0.5, 1.0}) {
    const std::string value = formatted("%.2g", scale.at(share));
    const auto room = static_cast<double>(right - left - text_width(value) * dot);
    canvas.write(left + static_cast<std::size_t>(share * room), y, value, dot);
  }
}

}  // namespace

double ErrorScale::share_of(double half_width) const {
  return half_width <= low ? 0 : std::min(std::log(half_width / low) / std::log(high / low), 1.0);
}

double ErrorScale::at(double share) const { return low * std::pow(high / low, share); }

std::vector<float> half_widths_of(const PictureStatistics& statistics, std::size_t pixels) {
  std::vector<float> largest(pixels, -1);
  const std::vector<float>& all = statistics.half_width;
  for (std::size_t i = 0; i < std::min(pixels, all.size() / 3); ++i) {
    const float value = std::max({all[3 * i], all[3 * i + 1], all[3 * i + 2]});
    const bool sampled = i >= statistics.samples.size() || statistics.samples[i] >= 2;
    if (sampled && std::isfinite(value)) largest[i] = value;
  }
  return largest;
}

ErrorScale error_scale(std::vector<float> half_widths) {
  std::erase_if(half_widths, [](float value) { return !(value > 0); });
  if (half_widths.empty()) return {};
  const auto least = half_widths.begin() + static_cast<std::ptrdiff_t>(half_widths.size() / 100);
  std::nth_element(half_widths.begin(), least, half_widths.end());
  const double high =
      round_number(static_cast<double>(*std::max_element(least, half_widths.end())), true);
  return {round_number(std::min<double>(*least, high / 10), false), high};
}

Colour error_colour(double share) {
  const Vec3d colour = color_at(ColorMap::violet_yellow, share);
  return {static_cast<float>(colour.x), static_cast<float>(colour.y), static_cast<float>(colour.z)};
}

Image error_map(std::span<const float> half_widths, std::uint32_t width, const ErrorScale& scale) {
  const std::size_t height = half_widths.size() / width;
  constexpr std::uint32_t width_for_a_dot = 480;
  const std::size_t dot = std::max<std::uint32_t>(width / width_for_a_dot, 1);
  const std::size_t total = std::max<std::size_t>(width, legend_width * dot);
  Canvas canvas(static_cast<std::uint32_t>(total),
                static_cast<std::uint32_t>(height + legend_height * dot));
  for (std::size_t i = 0; i < half_widths.size(); ++i) {
    const float value = half_widths[i];
    canvas.set(i % width, i / width,
               value < 0 ? unknown_colour : error_colour(scale.share_of(value)));
  }
  draw_legend(canvas, total, height, dot, scale);
  return canvas.take();
}

void write_error_map(const std::filesystem::path& file, const Picture& picture) {
  const Image& image = picture.image;
  const std::vector<float> half_widths =
      half_widths_of(picture.statistics, std::size_t{image.width} * image.height);
  const ErrorScale scale = error_scale(half_widths);
  write_image(file, error_map(half_widths, image.width, scale),
              {{"Software", "ParRay " + picture.report.value("version", "")},
               {"parray:error_map", "largest 95 % half-width of R, G and B, logarithmic"},
               {"parray:error_map_low", scale.low},
               {"parray:error_map_high", scale.high},
               {"parray:error_map_of", picture.report.value("image_sha256", "")}},
              {}, check_interrupted);
}

}  // namespace parray
