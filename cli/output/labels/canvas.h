#pragma once

#include <functional>
#include <string_view>
#include <vector>

#include "cli/output/labels/font.h"
#include "common/image/image.h"
#include "common/math/vec.h"

namespace parray::labels {

/// A place in the picture, in pixels.
struct Point {
  double x = 0;
  double y = 0;

  friend Point operator+(const Point& a, const Point& b) { return {a.x + b.x, a.y + b.y}; }
  friend Point operator-(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y}; }
  friend Point operator*(double s, const Point& a) { return {s * a.x, s * a.y}; }
};

/// A rectangle in the picture, in pixels. (x, y) is its upper left corner.
struct Box {
  double x = 0;
  double y = 0;
  double width = 0;
  double height = 0;

  /// Returns the box with `by` more pixels on all sides.
  [[nodiscard]] Box grown(double by) const {
    return {x - by, y - by, width + 2 * by, height + 2 * by};
  }
};

/// Shapes as the covered share of each pixel, in a part of a picture. Shapes outside that part
/// change nothing. Pixel (x, y) extends from x to x + 1 and from y to y + 1; x to the right, y
/// down.
class Coverage {
 public:
  /// Makes an empty coverage of all pixels that `box` touches.
  explicit Coverage(const Box& box);

  // Bounds of the part, in the picture's pixels.
  [[nodiscard]] int left() const { return left_; }
  [[nodiscard]] int top() const { return top_; }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }

  /// Returns the covered share, in [0, 1]. Returns 0 outside the part.
  [[nodiscard]] float at(int x, int y) const { return inside(x, y) ? values_[index(x, y)] : 0; }
  /// Adds a share of a pixel. The sum is at most 1. Where two shapes overlap within a partly
  /// covered pixel, their shares count twice.
  void add(int x, int y, float share);

  /// Adds the shares that a rectangle covers, as add() does for one pixel.
  void add(const Box& rectangle);
  /// Adds a line, `width` pixels wide, that ends flat at `from` and `to`. Each pixel keeps the
  /// larger of its share and the line's, so that lines may overlap. A line without length adds
  /// nothing.
  void add_line(const Point& from, const Point& to, double width);

  /// Returns the shapes grown by `radius` pixels on all sides, cut off at the bounds of the part.
  [[nodiscard]] Coverage grown(double radius) const;

  /// Returns the covered area, in pixels.
  [[nodiscard]] double area() const;

 private:
  [[nodiscard]] bool inside(int x, int y) const {
    return x >= left_ && y >= top_ && x - left_ < width_ && y - top_ < height_;
  }
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y - top_) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x - left_);
  }

  int left_, top_, width_, height_;
  std::vector<float> values_;
};

/// Returns the covered share of a pixel whose centre is `distance` pixels from the middle of a line
/// that is `width` pixels wide.
double line_share(double distance, double width);

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

/// Collects the text and the shapes of one label, in the picture's pixels. draw_on() draws them:
/// black with a white halo on a light background, otherwise white with a black halo.
class Pen {
 public:
  /// `line` is the width of lines in pixels, `area` the area of the label: its background decides
  /// the colour of the ink, and shapes far outside it are cut off. `font` must outlive the pen.
  Pen(const Font& font, double line, const Box& area);

  [[nodiscard]] const Font& font() const { return font_; }
  [[nodiscard]] double line() const { return line_; }

  /// Writes text from (x, baseline) on.
  void text(double x, double baseline, std::string_view text) {
    font_.draw(ink_, {x, baseline}, text);
  }
  /// Writes text centred at `x`.
  void centered(double x, double baseline, std::string_view words) {
    text(x - font_.width(words) / 2, baseline, words);
  }
  /// Draws a line that is line() wide.
  void stroke(const Point& from, const Point& to) { ink_.add_line(from, to, line_); }
  /// Fills a box with ink.
  void bar(const Box& box) { ink_.add(box); }
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

}  // namespace parray::labels
