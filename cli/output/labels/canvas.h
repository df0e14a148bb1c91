#pragma once

#include <functional>
#include <string_view>
#include <vector>

#include "cli/output/labels/coverage.h"
#include "cli/output/labels/font.h"
#include "common/image/image.h"
#include "common/math/vec.h"

namespace parray::labels {

/// A background is light whose mean cube root of luminance, which is what CIE lightness goes by, is
/// above this: a lightness of 50.
inline constexpr double light_background = 0.57;

/// A picture that is drawn over, in linear light. With alpha, its colours are premultiplied by it,
/// and what is drawn covers.
class Canvas {
 public:
  /// `alpha`: one a pixel, or empty: opaque. Both must outlive the canvas.
  Canvas(Image& image, std::vector<float>& alpha) : image_(image), alpha_(alpha) {}

  [[nodiscard]] double width() const { return image_.width; }
  [[nodiscard]] double height() const { return image_.height; }

  /// Lays `color`, linear RGB, over it: `strength`, in [0, 1], of what is covered.
  void paint(const Coverage& coverage, const Vec3d& color, double strength = 1);
  /// One pixel; outside of the picture nothing.
  void paint(int x, int y, const Vec3d& color, double share);

  /// Whether dark ink is to be used in the box: what is there is, on average, light. Transparent
  /// pixels count as paper.
  [[nodiscard]] bool is_light(const Box& box) const;
  [[nodiscard]] double luminance(int x, int y) const;

 private:
  Image& image_;
  std::vector<float>& alpha_;
};

/// Black or white, and what it stands out from.
struct Ink {
  Vec3d color;
  Vec3d halo;
};
Ink ink_for(bool light_background);

/// What writes and draws one label: black with a white halo, or the other way round.
class Pen {
 public:
  /// `line`: width of its lines, in pixels; `area`: of the label.
  Pen(const Font& font, double line, const Box& area);

  [[nodiscard]] const Font& font() const { return font_; }
  [[nodiscard]] double line() const { return line_; }

  /// From (x, baseline) on.
  void text(double x, double baseline, std::string_view text);
  /// Around the middle `x`.
  void centered(double x, double baseline, std::string_view words);
  void stroke(const Point& from, const Point& to);
  void bar(const Box& box);
  /// A box of colours, by the share of the way from its bottom (0) to its top (1), in a frame.
  void colored(const Box& box, std::function<Vec3d(double)> color);

  /// Draws all of it.
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

/// How far halos reach around what is drawn, for an em of `size` pixels.
double halo_width(double size);

}  // namespace parray::labels
