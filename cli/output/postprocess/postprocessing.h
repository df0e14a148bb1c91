#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "cli/output/picture/picture.h"
#include "common/image/image.h"

/// Postprocessing: steps after tracing, for files to look at: all except EXR. EXR files,
/// `image_sha256` and the picture itself keep the traced values.
namespace parray::postprocess {

/// A copy of the traced picture for postprocessing.
struct ShownPicture {
  Image image;  ///< linear RGB; premultiplied by alpha, if any ("associated")
  /// The covered share of each pixel, in [0, 1]. Empty: opaque.
  std::vector<float> alpha{};
  const Channels* written = nullptr;  ///< extra channels of the picture; null: none
  const Channels* traced = nullptr;   ///< channels only for the steps

  /// Returns the values of a channel of floats, such as "Z". Empty: no such channel.
  [[nodiscard]] std::span<const float> floats(const std::string& name) const;
  /// Returns the values of a channel of integers, such as "sphere". Empty: no such channel.
  [[nodiscard]] std::span<const std::uint32_t> wholes(const std::string& name) const;
};

/// One step of postprocessing.
struct PostprocessStep {
  std::string name;  ///< for the file's metadata: "outline", "legend"
  Aovs needs{};      ///< channels that it needs; traced even if no file has them
  std::function<void(ShownPicture&)> apply;
};

/// Steps in order: background, depth cue, outline, labels.
using PostprocessSteps = std::vector<PostprocessStep>;

/// Returns the channels that all steps need.
Aovs needs_of(const PostprocessSteps& finishing);

/// Returns the names of the steps, separated by commas.
std::string names_of(const PostprocessSteps& finishing);

/// Applies all steps to a copy of the picture. The result refers to the channels of `picture`.
ShownPicture finished_picture(const Picture& picture, const PostprocessSteps& finishing);

/// Pictures in rows, from the top left. The last row may have fewer.
struct SheetLayout {
  std::uint32_t columns = 1;
  std::uint32_t rows = 1;
  std::uint32_t gap = 0;  ///< pixels between two pictures
};

/// Returns the layout of `count` pictures (> 0) of `width` x `height` pixels. The number of columns
/// is a compromise between a sheet twice as wide as high and few empty places. Gaps are 1/200 of a
/// picture's height, at least 2 pixels.
SheetLayout sheet_layout(std::size_t count, std::uint32_t width, std::uint32_t height);

/// Return the size of a sheet in pixels, which may exceed 32 bits. `width`, `height`: of a picture.
std::uint64_t sheet_width(const SheetLayout& layout, std::uint32_t width);
std::uint64_t sheet_height(const SheetLayout& layout, std::uint32_t height);

/// Joins pictures of the same size. The gaps, empty places and transparent pixels are white.
Image sheet_of(const std::vector<ShownPicture>& pictures, const SheetLayout& layout);

}  // namespace parray::postprocess
