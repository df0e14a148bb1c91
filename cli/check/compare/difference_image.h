#pragma once

#include <cstddef>

#include "common/image/image.h"

namespace parray::compare {

/// The verification picture of the seed program's report (its equation 1 and figure 11):
/// V = sum of |R - F| over pictures F, for each channel of each pixel of linear RGB.
///
/// Equal non-finite values in both count as no difference; a NaN in one of them counts as 1.
class DifferenceImage {
 public:
  /// `reference` is R; it must outlive this object.
  explicit DifferenceImage(const Image& reference);

  /// Adds a picture F of the size of R.
  void add(const Image& image);

  /// Largest value of V: 0 if all pictures are equal.
  [[nodiscard]] float largest() const;

  /// Returns white minus V in linear RGB: 1 where all pictures are equal, darker for larger
  /// differences, black where V is 1 or more. V is not scaled, so two such pictures can be
  /// compared.
  [[nodiscard]] Image drawn() const;

 private:
  const Image& reference_;
  Image sum_;
};

}  // namespace parray::compare
