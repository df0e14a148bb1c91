#pragma once

#include "common/image/image.h"

namespace parray::compare {

/// The sum of the differences between pictures F and a reference picture R: V = sum of |R - F|, for
/// each channel of each pixel in linear RGB. It is the verification picture (equation 1, figure 11)
/// in the report of the seed program. ParRay started from that program.
///
/// Equal infinities, and NaN in both R and F, count as 0. NaN in one of them counts as 1. Other
/// infinite differences make V infinite.
class DifferenceImage {
 public:
  /// `reference` is R; it must outlive this object.
  explicit DifferenceImage(const Image& reference);

  /// Adds a picture F, which must have the size of R.
  void add(const Image& image);

  /// Returns the largest value of V: 0 if all pictures equal R.
  [[nodiscard]] float largest() const;

  /// Returns the picture max(0, 1 - V) in linear RGB: 1 where all pictures equal R, darker for
  /// larger differences, black where V is 1 or more. V is not scaled, so two such pictures can be
  /// compared.
  [[nodiscard]] Image drawn() const;

 private:
  const Image& reference_;
  Image sum_;
};

}  // namespace parray::compare
