#include "cli/output/error_map.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "cli/output/labels/canvas.h"
#include "cli/output/labels/font.h"
#include "cli/output/labels/round_numbers.h"
#include "cli/output/picture/color_map.h"
#include "cli/output/picture/image_file.h"
#include "cli/output/text.h"
#include "common/process/stop_signal.h"

namespace parray::output {
namespace {

using Colour = std::array<float, 3>;

constexpr Colour background = {0.01F, 0.01F, 0.01F};
constexpr Colour ink = {0.8F, 0.8F, 0.8F};

constexpr std::string_view title = "95 % half-width";
constexpr std::string_view unknown = "unknown";

Vec3d vec_of(const Colour& colour) { return {colour[0], colour[1], colour[2]}; }

/// Layout of the legend below the map, in pixels. Sizes depend on the size of the letters.
struct LegendPlaces {
  explicit LegendPlaces(const Font& font) : em(font.size()) {
    const double line = font.cap_height();
    title_baseline = margin() + line;
    bar_top = title_baseline + gap();
    values_baseline = bar_top + bar_height() + gap() + line;
    height = values_baseline + margin();
    width = 2 * margin() + font.width(title) + 4 * gap() + em + font.width(unknown);
  }
  [[nodiscard]] double margin() const { return 0.5 * em; }
  [[nodiscard]] double gap() const { return 0.4 * em; }
  [[nodiscard]] double bar_height() const { return em; }

  double em;
  double title_baseline, bar_top, values_baseline;
  double width, height;
};

/// Draws the legend over the whole width, from row `top` on.
class LegendDrawing {
 public:
  LegendDrawing(Image& image, const Font& font, const LegendPlaces& places, double top)
      : canvas_(image, opaque_), font_(font), places_(places), top_(top) {}

  void draw(const ErrorScale& scale) {
    const double left = places_.margin();
    const double right = canvas_.width() - left;
    write(left, places_.title_baseline, title);
    const double word = right - font_.width(unknown);
    write(word, places_.title_baseline, unknown);
    const double side = font_.cap_height();
    fill({word - places_.gap() - side, places_.title_baseline - side, side, side}, unknown_colour);
    // Fills whole pixels, because two half-covered pixels would show the background.
    for (int column = static_cast<int>(std::floor(left)); column < right; ++column) {
      const double x = column;
      const double share = std::clamp((x - left) / (right - left), 0.0, 1.0);
      fill({x, places_.bar_top, 1, places_.bar_height()}, error_colour(share));
    }
    for (const double share : {0.0, 0.5, 1.0}) {
      const std::string value = formatted("%.2g", scale.at(share));
      write(left + share * (right - left - font_.width(value)), places_.values_baseline, value);
    }
  }

 private:
  void write(double x, double baseline, std::string_view text) {
    Coverage letters(
        Box{x, top_ + baseline - font_.size(), font_.width(text) + 1, 1.5 * font_.size()}.grown(1));
    font_.draw(letters, {x, top_ + baseline}, text);
    canvas_.paint(letters, vec_of(ink));
  }
  void fill(Box box, const Colour& colour) {
    box.y += top_;
    Coverage inside(box);
    inside.add(box);
    canvas_.paint(inside, vec_of(colour));
  }

  std::vector<float> opaque_;
  Canvas canvas_;
  const Font& font_;
  const LegendPlaces& places_;
  double top_;
};

/// Returns an image of one colour.
Image sheet(std::size_t width, std::size_t height, const Colour& colour) {
  Image image{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height),
              std::vector<float>(3 * width * height)};
  for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = colour[i % 3];
  return image;
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
  const double high = round_above(static_cast<double>(*std::max_element(least, half_widths.end())));
  return {round_below(std::min<double>(*least, high / 10)), high};
}

Colour error_colour(double share) {
  const Vec3d colour = color_at(ColorMap::violet_yellow, share);
  return {static_cast<float>(colour.x), static_cast<float>(colour.y), static_cast<float>(colour.z)};
}

Image error_map(std::span<const float> half_widths, std::uint32_t width, const ErrorScale& scale) {
  const std::size_t height = half_widths.size() / width;
  const Font font(error_map_letters(width));
  const LegendPlaces places(font);
  const auto below = static_cast<std::size_t>(std::ceil(places.height));
  const auto total =
      std::max<std::size_t>(width, static_cast<std::size_t>(std::ceil(places.width)));
  Image map = sheet(total, height + below, background);
  for (std::size_t i = 0; i < half_widths.size(); ++i) {
    const float value = half_widths[i];
    const Colour colour = value < 0 ? unknown_colour : error_colour(scale.share_of(value));
    const std::size_t at = i / width * total + i % width;
    std::ranges::copy(colour, map.rgb.begin() + static_cast<std::ptrdiff_t>(3 * at));
  }
  LegendDrawing(map, font, places, static_cast<double>(height)).draw(scale);
  return map;
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

}  // namespace parray::output
