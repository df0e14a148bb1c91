#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/input/color/legend.h"
#include "cli/input/particles/particles.h"
#include "cli/input/scene_file/label_settings.h"
#include "cli/output/labels/cell_lines.h"
#include "common/image/image.h"
#include "common/scene/scene.h"

namespace parray::labels {

/// All that labels are made from.
struct LabelContent {
  LabelSettings settings;
  std::vector<Legend> legends{};
  std::optional<ParticleCell> cell{};
  std::string time_stamp{};  ///< what the file says of the frame; empty: nothing
  std::string unit{};        ///< of lengths; empty: not known
  Camera camera{};           ///< has passed the reader's checks
  std::uint32_t width = 0;   ///< of the picture, in pixels
  std::uint32_t height = 0;
  std::uint32_t staging = 0;  ///< so many of the scene's first spheres are ground and lights
};

/// Pixels an inch that sizes of a picture so wide are worked out with: of `settings`, or else as if
/// it was printed 120 mm wide, but no fewer than a screen has, 96.
double dots_per_inch(const LabelSettings& settings, double width);

/// The length of a scale bar that takes at most `most_pixels` where a unit takes so many: the
/// largest round one.
double scale_bar_length(double pixels_per_unit, double most_pixels);

/// The labels of a picture, each in its place. Drawn after tracing; made before it, so that what is
/// impossible is told before any work.
class Labels {
 public:
  /// `content.settings.any()`. Throws InputError, naming the option, for what the scene does not
  /// have, text that the font lacks and labels that do not fit; RunError when the font is not
  /// there.
  explicit Labels(LabelContent content);
  ~Labels();
  Labels(Labels&&) noexcept;

  /// Draws them over the picture, linear RGB; `alpha` (empty: opaque) is what it is premultiplied
  /// by. Only with `cell` are depths looked at.
  void draw(Image& image, std::vector<float>& alpha, const DepthMap& map) const;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

}  // namespace parray::labels
