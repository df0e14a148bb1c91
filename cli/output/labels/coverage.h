#pragma once

#include <vector>

#include "common/rooms.h"

/// Shapes as the covered share of each pixel. Pixel (x, y) extends from x to x + 1 and from y to y
/// + 1; x to the right, y down.
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

/// The coverage of a part of a picture. Shapes outside that part change nothing.
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

}  // namespace parray::labels
