#include "cli/output/postprocess/postprocessing.h"

#include <algorithm>
#include <cmath>

#include "cli/output/picture/transparency.h"

namespace parray::postprocess {
namespace {

template <typename Value>
std::span<const Value> values_of(const ShownPicture& picture, const std::string& name) {
  for (const Channels* const channels : {picture.written, picture.traced}) {
    if (channels == nullptr) continue;
    if (const auto* const values = values_in<Value>(*channels, name)) return *values;
  }
  return {};
}

std::uint64_t side(std::uint32_t count, std::uint32_t pixels, std::uint32_t gap) {
  return std::uint64_t{count} * pixels + std::uint64_t{count - 1} * gap;
}

void place(const ShownPicture& picture, std::size_t left, std::size_t top, Image& sheet) {
  const Image& image = picture.image;
  for (std::size_t y = 0; y < image.height; ++y) {
    for (std::size_t x = 0; x < image.width; ++x) {
      const std::size_t from = y * image.width + x;
      const std::size_t to = (top + y) * sheet.width + left + x;
      const float white = picture.alpha.empty() ? 0 : 1 - picture.alpha[from];
      for (std::size_t c = 0; c < 3; ++c) sheet.rgb[3 * to + c] = image.rgb[3 * from + c] + white;
    }
  }
}

}  // namespace

std::span<const float> ShownPicture::floats(const std::string& name) const {
  return values_of<float>(*this, name);
}

std::span<const std::uint32_t> ShownPicture::wholes(const std::string& name) const {
  return values_of<std::uint32_t>(*this, name);
}

Aovs needs_of(const PostprocessSteps& finishing) {
  Aovs needs;
  for (const PostprocessStep& step : finishing) needs.insert(step.needs.begin(), step.needs.end());
  return needs;
}

std::string names_of(const PostprocessSteps& finishing) {
  std::string names;
  for (const PostprocessStep& step : finishing) names += (names.empty() ? "" : ", ") + step.name;
  return names;
}

ShownPicture finished_picture(const Picture& picture, const PostprocessSteps& finishing) {
  const std::span<const float> alpha = alpha_of(picture.channels);
  ShownPicture shown{
      picture.image, {alpha.begin(), alpha.end()}, &picture.channels, &picture.traced};
  for (const PostprocessStep& step : finishing) step.apply(shown);
  return shown;
}

SheetLayout sheet_layout(std::size_t count, std::uint32_t width, std::uint32_t height) {
  constexpr double wanted = 2;
  const auto all = static_cast<std::uint32_t>(count);
  SheetLayout best;
  double least = 0;
  for (std::uint32_t columns = 1; columns <= all; ++columns) {
    const std::uint32_t rows = (all + columns - 1) / columns;
    const double aspect =
        static_cast<double>(columns) * width / (static_cast<double>(rows) * height);
    const double empty = 3.0 * (columns * rows - all) / all;  // three views form one row
    const double cost = std::abs(std::log(aspect / wanted)) + empty;
    if (columns == 1 || cost < least) {
      least = cost;
      best = {columns, rows, std::max(2U, height / 200)};
    }
  }
  return best;
}

std::uint64_t sheet_width(const SheetLayout& layout, std::uint32_t width) {
  return side(layout.columns, width, layout.gap);
}

std::uint64_t sheet_height(const SheetLayout& layout, std::uint32_t height) {
  return side(layout.rows, height, layout.gap);
}

Image sheet_of(const std::vector<ShownPicture>& pictures, const SheetLayout& layout) {
  const Image& first = pictures.front().image;
  Image sheet;
  sheet.width = static_cast<std::uint32_t>(sheet_width(layout, first.width));
  sheet.height = static_cast<std::uint32_t>(sheet_height(layout, first.height));
  sheet.rgb.assign(std::size_t{sheet.width} * sheet.height * 3, 1.0F);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    place(pictures[i], i % layout.columns * (first.width + layout.gap),
          i / layout.columns * (first.height + layout.gap), sheet);
  }
  return sheet;
}

}  // namespace parray::postprocess
