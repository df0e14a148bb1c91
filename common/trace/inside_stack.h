#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "common/trace/ray.h"

namespace parray::trace {

/// Up to `Most` numbers without memory from the heap, for code that cannot allocate. Has all
/// functions of std::vector that InsideStack calls.
template <std::uint32_t Most>
class ShortList {
 public:
  void clear() {
    count_ = 0;
    overflowed_ = false;
  }
  /// Adds a number. If the list is full, leaves it as it is and sets overflowed().
  void push_back(std::uint32_t number) {
    overflowed_ = overflowed_ || count_ == Most;
    if (!overflowed_) at_[count_++] = number;
  }
  void erase(const std::uint32_t* place) {
    for (std::uint32_t i = static_cast<std::uint32_t>(place - at_) + 1; i < count_; ++i) {
      at_[i - 1] = at_[i];
    }
    --count_;
  }
  [[nodiscard]] const std::uint32_t* begin() const { return at_; }
  [[nodiscard]] const std::uint32_t* end() const { return at_ + count_; }
  /// Returns whether a number found no room since the last clear().
  [[nodiscard]] bool overflowed() const { return overflowed_; }

 private:
  std::uint32_t at_[Most > 0 ? Most : 1];
  std::uint32_t count_ = 0;
  bool overflowed_ = false;
};

/// Tracks on which side of every shape a path is: the shapes that the path is inside of, and the
/// shape on whose surface it stands.
///
/// A path changes sides only where it crosses a surface: by refraction, or straight on inside one
/// body of glass (see below). The sign of a computed distance never changes a side. So rounding can
/// neither make a path hit the surface that it leaves nor let it leak out of a closed shape. Serves
/// one path at a time; not thread-safe.
///
/// Bodies (shapes) of the same glass (the same dielectric material) that overlap are one body: a
/// path goes straight on through a surface that lies inside another body of its own material. Up to
/// most_crossings such crossings in a row do not count towards max_depth; the next one does, and a
/// new row begins. So tracing ends even if thousands of bodies overlap. TraceCounts::rays counts
/// all of them.
///
/// `List` stores the shapes that a path is inside of: a vector, or a ShortList.
template <typename Real, typename List = std::vector<std::uint32_t>>
class InsideStack {
 public:
  /// Begins a path that stands on no surface and is inside of no shape.
  void start() {
    inside_.clear();
    surface_ = no_shape;
  }

  /// Puts the path on a shape's surface, at the point with this outward unit normal. Does not
  /// change the shapes that the path is inside of.
  void stand_on(std::uint32_t shape, const Vec3<Real>& normal) {
    surface_ = shape;
    normal_ = normal;
  }

  /// Moves the path through the surface of `shape`: out of it if `leaving`, otherwise into it. A
  /// path that leaves must be inside of the shape.
  void cross(std::uint32_t shape, bool leaving) {
    if (leaving) {
      inside_.erase(std::find(inside_.begin(), inside_.end(), shape));
    } else {
      inside_.push_back(shape);
    }
  }

  /// Returns the shapes that the path is inside of, in the order in which it entered them.
  [[nodiscard]] const List& inside() const { return inside_; }
  /// Returns whether the path has entered more shapes than `List` holds. It must not go on then.
  [[nodiscard]] bool overflowed() const {
    if constexpr (requires { inside_.overflowed(); }) {
      return inside_.overflowed();
    } else {
      return false;
    }
  }
  [[nodiscard]] bool stands_on(std::uint32_t shape) const { return shape == surface_; }
  /// Returns the normal of the last stand_on(). Has no meaning before that.
  [[nodiscard]] const Vec3<Real>& normal() const { return normal_; }

  /// Returns whether the path cannot enter a shape. That is so if the path is inside already, or
  /// stands on its outside: a ray that leaves a convex body cannot meet it again.
  [[nodiscard]] bool cannot_enter(std::uint32_t shape) const {
    return shape == surface_ || std::find(inside_.begin(), inside_.end(), shape) != inside_.end();
  }

 private:
  List inside_;
  std::uint32_t surface_ = no_shape;
  Vec3<Real> normal_{};
};

}  // namespace parray::trace
