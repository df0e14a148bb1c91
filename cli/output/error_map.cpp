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

/// The legend below the map. Sizes are in pixels and depend on the size of the letters.
class MapLegend {
 public:
  explicit MapLegend(const Font& font) : font_(font) {}

  [[nodiscard]] double width() const {
    return 2 * margin() + font_.width(title) + 4 * gap() + em() + font_.width(unknown);
  }
  [[nodiscard]] double height() const { return values_baseline() + margin(); }

  /// Draws over the whole width, from row `top` on.
  void draw(Image& image, double top, const ErrorScale& scale) const {
    std::vector<float> opaque;
    Canvas canvas(image, opaque);
    const auto write = [&](double x, double baseline, std::string_view text) {
      Coverage letters(Box{x, top + baseline - em(), font_.width(text) + 1, 1.5 * em()}.grown(1));
      font_.draw(letters, {x, top + baseline}, text);
      canvas.paint(letters, vec_of(ink));
    };
    const auto fill = [&](Box box, const Colour& colour) {
      box.y += top;
      Coverage inside(box);
      inside.add(box);
      canvas.paint(inside, vec_of(colour));
    };
    const double left = margin();
    const double right = canvas.width() - left;
    write(left, title_baseline(), title);
    const double word = right - font_.width(unknown);
    write(word, title_baseline(), unknown);
    const double side = font_.cap_height();
    fill({word - gap() - side, title_baseline() - side, side, side}, unknown_colour);
    // Fills whole pixels, because two half-covered pixels would show the background.
    for (int column = static_cast<int>(std::floor(left)); column < right; ++column) {
      const double x = column;
      const double share = std::clamp((x - left) / (right - left), 0.0, 1.0);
      fill({x, bar_top(), 1, em()}, error_colour(share));
    }
    for (const double share : {0.0, 0.5, 1.0}) {
      const std::string value = formatted("%.2g", scale.at(share));
      write(left + share * (right - left - font_.width(value)), values_baseline(), value);
    }
  }

 private:
  [[nodiscard]] double em() const { return font_.size(); }
  [[nodiscard]] double margin() const { return 0.5 * em(); }
  [[nodiscard]] double gap() const { return 0.4 * em(); }
  [[nodiscard]] double title_baseline() const { return margin() + font_.cap_height(); }
  [[nodiscard]] double bar_top() const { return title_baseline() + gap(); }
  [[nodiscard]] double values_baseline() const {
    return bar_top() + em() + gap() + font_.cap_height();
  }

  const Font& font_;
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
  const MapLegend legend(font);
  const auto below = static_cast<std::size_t>(std::ceil(legend.height()));
  const auto total =
      std::max<std::size_t>(width, static_cast<std::size_t>(std::ceil(legend.width())));
  Image map = sheet(total, height + below, background);
  for (std::size_t i = 0; i < half_widths.size(); ++i) {
    const float value = half_widths[i];
    const Colour colour = value < 0 ? unknown_colour : error_colour(scale.share_of(value));
    const std::size_t at = i / width * total + i % width;
    std::ranges::copy(colour, map.rgb.begin() + static_cast<std::ptrdiff_t>(3 * at));
  }
  legend.draw(map, static_cast<double>(height), scale);
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
