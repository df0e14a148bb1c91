#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "cli/output/picture/picture.h"
#include "common/image/image.h"

/// What is done to a picture after it was traced, in files that are looked at (PNG). EXR files keep
/// what was traced, and so do `image_sha256` and the picture itself.
namespace parray::postprocess {

/// A picture to be drawn on: a copy of what was traced.
struct ShownPicture {
  Image image;  ///< linear RGB; where there is alpha, premultiplied by it ("associated")
  /// Of each pixel the share that is covered, in [0, 1]; empty: everything is.
  std::vector<float> alpha{};
  const Channels* written = nullptr;  ///< extra channels of the picture; null: none
  const Channels* traced = nullptr;   ///< those that steps have asked for beside

  /// Values of a channel of floats, as "Z"; empty: it is not there.
  [[nodiscard]] std::span<const float> floats(const std::string& name) const;
  /// Of a channel of whole numbers, as "sphere".
  [[nodiscard]] std::span<const std::uint32_t> wholes(const std::string& name) const;
};

/// One thing that is done.
struct FinishingStep {
  std::string name;  ///< for the file's metadata: "outline", "legend"
  Aovs needs{};      ///< channels that it looks at: traced for it, whether they are written or not
  std::function<void(ShownPicture&)> apply;
};

/// Applied in order: what belongs to the scene (depth cue, outline) before what is written on top.
using Finishing = std::vector<FinishingStep>;

/// What all steps need.
Aovs needs_of(const Finishing& finishing);

/// Their names, for people, with commas between.
std::string names_of(const Finishing& finishing);

/// The picture with all steps applied; without steps as it was traced.
ShownPicture finished_picture(const Picture& picture, const Finishing& finishing);

}  // namespace parray::postprocess
