#pragma once

#include <cstdint>
#include <vector>

#include "common/rooms.h"

/// Shapes as the share of each pixel that they cover. Pixel (x, y) reaches from x to x + 1 and from
/// y to y + 1; x to the right, y downwards.
namespace parray::labels {

struct Point {
  double x = 0;
  double y = 0;

  friend Point operator+(const Point& a, const Point& b) { return {a.x + b.x, a.y + b.y}; }
  friend Point operator-(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y}; }
  friend Point operator*(double s, const Point& a) { return {s * a.x, s * a.y}; }
};

struct Box {
  double x = 0;
  double y = 0;
  double width = 0;
  double height = 0;

  [[nodiscard]] Box grown(double by) const {
    return {x - by, y - by, width + 2 * by, height + 2 * by};
  }
};

/// Of the pixels of a part of a picture; what lies outside is left out.
class Coverage {
 public:
  /// The whole pixels that `box` touches.
  explicit Coverage(const Box& box);

  // Of the part, in the picture's pixels.
  [[nodiscard]] int left() const { return left_; }
  [[nodiscard]] int top() const { return top_; }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }

  /// In [0, 1]; 0 outside.
  [[nodiscard]] float at(int x, int y) const { return inside(x, y) ? values_[index(x, y)] : 0; }
  /// Of shapes that do not overlap, shares of a pixel add up.
  void add(int x, int y, float share);

  /// A rectangle, to the fraction of a pixel.
  void add(const Box& rectangle);
  /// A line with square ends, `width` pixels wide.
  void add_line(const Point& from, const Point& to, double width);

  /// The same, grown by `radius` pixels to all sides.
  [[nodiscard]] Coverage grown(double radius) const;

  /// The sum of all shares: the area, in pixels.
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

/// How much of a line of that width covers a pixel whose centre is `distance` away from its middle.
double line_share(double distance, double width);

}  // namespace parray::labels
