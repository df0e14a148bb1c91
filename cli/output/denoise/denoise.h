#pragma once

#include <functional>
#include <vector>

#include "cli/output/denoise/features.h"
#include "common/image/replicates.h"
#include "common/scene/settings.h"

/// A picture with less noise than its samples have, and the error that it has all the same.
///
/// Both halves A and B of a picture's samples are filtered, each by itself, and the mean of the two
/// is the picture. The filter fits the radiance around a pixel by its features (features.h), by a
/// linear regression in which pixels count by how alike the patches around them are (Buades, Coll
/// and Morel, "A non-local algorithm for image denoising", 2005; Bitterli et al., "Nonlinearly
/// weighted first-order regression for denoising Monte Carlo renderings", 2016), and takes what the
/// fit says with the features as they are instead of as the half's few samples have them: radiance
/// and features of a half have their noise in common, and this takes it away (control variates).
/// It does so with two degrees of smoothing. Of these and of the half as it is, the mixture that
/// came closest to the other half around a pixel, but not in it, is taken: where a filter would
/// hurt, the pixel stays.
///
/// So what becomes of A in a pixel, F, does not depend on what B is in that pixel: not F but the
/// noise of B decides the mean of (F - m)(B - m), m being the truth, and that is 0. With G made of
/// B and D = (F + G) / 2,
///   |F - B|^2 / 2 + |G - A|^2 / 2 - |A - B|^2 / 2 - |F - G|^2 / 4
///     = |D - m|^2 - (F - m)(B - m) - (G - m)(A - m) + (A - m)(B - m):
/// the square error of D, the bias of the filter included, and three terms whose mean is 0. (Of one
/// factor in the noise, which all pixels decide together, that is true but for one part in their
/// number.)
namespace parray::denoise {

struct Denoised {
  std::vector<float> rgb;  ///< linear radiance, 3 values a pixel, by image row
  /// Root mean square error over pixels and channels, and the interval that it lies in 95 % of the
  /// time; 0 where the estimate of its square is below.
  double rmse = 0;
  double low = 0;
  double high = 0;
};

/// `replicates` and `features` are of the same picture. `isa` is one that this machine has, or
/// automatic. The same bits for any `threads` and any `isa`. `between_bands`, if set, is called
/// several times a second; what it throws ends the work. Memory: about 200 bytes a pixel, features
/// included.
Denoised denoise(const Replicates& replicates, const Features& features, int threads,
                 Isa isa = Isa::automatic, const std::function<void()>& between_bands = {});

}  // namespace parray::denoise
