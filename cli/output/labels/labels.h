#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/input/color/legend.h"
#include "cli/input/particles/particles.h"
#include "cli/input/scene_file/label_settings.h"
#include "cli/input/view/free_area.h"
#include "cli/output/labels/block.h"
#include "cli/output/labels/cell_lines.h"
#include "common/image/image.h"
#include "common/scene/scene.h"

namespace parray::labels {

/// The content of labels.
struct LabelContent {
  LabelSettings settings;
  std::vector<Legend> legends{};
  std::optional<ParticleCell> cell{};
  bool solid_cell = false;   ///< the scene itself shows the edges of the cell
  std::string time_stamp{};  ///< number of the frame, and its time or step; empty: unknown
  std::string unit{};        ///< unit of length; empty: unknown
  Camera camera{};           ///< valid
  std::uint32_t width = 0;   ///< of the picture, in pixels
  std::uint32_t height = 0;
  std::uint32_t scenery = 0;  ///< number of the scene's first spheres that are ground and lights
};

/// Returns the pixels per inch for a picture of width `width`: from `settings`, otherwise for a
/// print 120 mm wide, but at least 96 as on a screen.
double dots_per_inch(const LabelSettings& settings, double width);

/// Returns whether a legend is a colour bar of positions or radii.
bool shows_lengths(const Legend& legend);

/// If the settings have a legend_title, gives it to a legend of colours, and removes the unit of
/// the legend, because the title contains the unit. Otherwise gives a legend of positions or radii
/// the unit of the settings, if they have one. A blank unit means no unit.
void set_title(Legend& legend, const LabelSettings& settings);

/// The labels of a picture with their places. They are made before tracing, so that errors come
/// early. They are drawn after tracing.
class Labels {
 public:
  /// Needs `content.settings.any()`. Throws InputError, which names the option, if the scene lacks
  /// what a label shows, the font lacks a character, or labels do not fit. Throws RunError if the
  /// font is missing.
  explicit Labels(LabelContent content);

  /// Returns the places that labels of `content` need, with gaps. The camera may still move away
  /// after this call: the place of the scale bar suffices for cameras that show the scene up to ten
  /// times smaller. Throws InputError and RunError as the constructor does.
  static LabelPlaces places(const LabelContent& content);

  /// Returns the places of all labels except the names of the cell's edges, in pixels.
  [[nodiscard]] std::vector<Box> boxes() const;

  /// Draws the labels on the picture, linear RGB, premultiplied by `alpha` (empty: opaque). Uses
  /// `map` only if the settings ask for the cell: to hide parts of its edges, and to place the
  /// names of the edges beside the particles.
  void draw(Image& image, std::vector<float>& alpha, const DepthMap& map) const;

 private:
  void make_blocks();
  void add_legends();
  void add_scale_bar();
  [[nodiscard]] double longest_bar() const;
  [[nodiscard]] Block scale_bar(double length, double pixels) const;
  [[nodiscard]] double widest_bar() const;
  [[nodiscard]] std::string unit() const;
  [[nodiscard]] Point place_of(const EdgeName& edge, const DepthMap& map) const;

  LabelContent content_;
  double width_, height_;
  double dpi_;
  Font font_;
  double line_;
  CameraFilm film_;
  double margin_;
  BlockStyle style_;
  std::vector<Block> blocks_;
  std::vector<Placed> placed_;
};

}  // namespace parray::labels
