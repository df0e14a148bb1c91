#pragma once

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

}  // namespace parray::postprocess
