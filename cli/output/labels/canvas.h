#pragma once

#include <functional>
#include <string_view>
#include <vector>

#include "cli/output/labels/coverage.h"
#include "cli/output/labels/font.h"
#include "common/image/image.h"
#include "common/math/vec.h"

namespace parray::labels {

/// A background is light if the mean cube root of its luminance is above this: a CIE lightness of
/// 50.
inline constexpr double light_background = 0.57;

/// A picture that labels are drawn on, in linear light. With alpha, colours are premultiplied, and
/// drawn pixels become opaque.
class Canvas {
 public:
  /// `alpha`: one value per pixel, or empty for an opaque picture. `image` and `alpha` must outlive
  /// the canvas.
  Canvas(Image& image, std::vector<float>& alpha) : image_(image), alpha_(alpha) {}

  [[nodiscard]] double width() const { return image_.width; }
  [[nodiscard]] double height() const { return image_.height; }

  /// Mixes `color` (linear RGB) into the covered pixels, with `strength` in [0, 1].
  void paint(const Coverage& coverage, const Vec3d& color, double strength = 1);
  /// Mixes `color` into one pixel. Does nothing outside the picture.
  void paint(int x, int y, const Vec3d& color, double share);

  /// Returns whether to use dark ink in the box, because the picture is light there on average.
  /// Transparent pixels count as white paper.
  [[nodiscard]] bool is_light(const Box& box) const;
  /// Returns the relative luminance of a pixel of the picture, in [0, 1] (Rec. ITU-R BT.709).
  /// Transparent pixels count as white.
  [[nodiscard]] double luminance(int x, int y) const;

 private:
  Image& image_;
  std::vector<float>& alpha_;
};

/// Black or white ink, and the colour of its halo.
struct Ink {
  Vec3d color;
  Vec3d halo;
};
/// Returns black ink with a white halo for a light background, otherwise white ink with a black
/// halo.
Ink ink_for(bool light_background);

/// Collects the text and the shapes of one label, in the picture's pixels. draw_on() draws them,
/// black with a white halo or white with a black halo.
class Pen {
 public:
  /// `line` is the width of lines in pixels, `area` the area of the label: its background decides
  /// the colour of the ink, and shapes far outside it are cut off. `font` must outlive the pen.
  Pen(const Font& font, double line, const Box& area);

  [[nodiscard]] const Font& font() const { return font_; }
  [[nodiscard]] double line() const { return line_; }

  /// Writes text from (x, baseline) on.
  void text(double x, double baseline, std::string_view text);
  /// Writes text centred at `x`.
  void centered(double x, double baseline, std::string_view words);
  /// Draws a line that is line() wide.
  void stroke(const Point& from, const Point& to);
  /// Fills a box with ink.
  void bar(const Box& box);
  /// Draws a framed box whose colour (linear RGB) depends on the height: 0 at the bottom, 1 at the
  /// top.
  void colored(const Box& box, std::function<Vec3d(double)> color);

  /// Draws everything on the canvas.
  void draw_on(Canvas& canvas) const;

 private:
  struct Colored {
    Box box;
    std::function<Vec3d(double)> color;
  };

  const Font& font_;
  double line_;
  Box area_;
  Coverage ink_;
  std::vector<Colored> colored_;
};

/// Returns the width in pixels of the halo around letters of `size` pixels per em.
double halo_width(double size);

}  // namespace parray::labels
