#pragma once

#include <functional>
#include <vector>

#include "cli/output/denoise/features.h"
#include "common/image/picture_bytes.h"
#include "common/scene/setting_choices.h"

/// Denoising, and the remaining error.
///
/// The samples of a picture form two halves A and B: the even and the odd samples of each pixel.
/// The filter denoises each half, and the picture is the mean of the two. The filter fits the
/// radiance around a pixel to its features (features.h) by a weighted linear regression. The weight
/// of a neighbouring pixel depends on how similar the patches around the two pixels are (Buades,
/// Coll and Morel, "A non-local algorithm for image denoising", 2005; Bitterli et al., "Nonlinearly
/// weighted first-order regression for denoising Monte Carlo renderings", 2016). The fit is
/// evaluated at the steady features instead of the half's own features. Radiance and features of a
/// half share their noise, and this step removes it (control variates). The filter computes two
/// results, with less and with more smoothing. It mixes these and the unfiltered half so that,
/// around a pixel and without the pixel itself, the mixture is closest to the other half. So a
/// pixel that the filter would make worse stays as it is.
///
/// The filtered half F in a pixel does not depend on B in that pixel. Therefore the mean of
/// (F - m)(B - m) is 0, where m is the truth. With G from B and D = (F + G) / 2,
///   |F - B|^2 / 2 + |G - A|^2 / 2 - |A - B|^2 / 2 - |F - G|^2 / 4
///     = |D - m|^2 - (F - m)(B - m) - (G - m)(A - m) + (A - m)(B - m).
/// This is the square error of D, including the filter's bias, and three terms with mean 0. (F
/// depends a little on B in that pixel, by one factor of the noise estimate that comes from all
/// pixels. The effect is one part in the number of pixels.)
namespace parray::denoise {

struct Denoised {
  std::vector<float> rgb;  ///< linear radiance, 3 values per pixel, in image order
  /// Root mean square error over pixels and channels, and its 95 % confidence interval. 0 if the
  /// estimate of the square is negative.
  double rmse = 0;
  double low = 0;
  double high = 0;
};

/// Denoises a picture. `replicates` and `features` belong to the same picture. `isa` is automatic
/// or one that this machine has. The bits are the same for any `threads` and `isa`. Calls
/// `between_bands`, if set, several times a second; an exception of it ends the work. Uses about
/// 200 bytes of memory per pixel, including the features.
Denoised denoise(const Replicates& replicates, const Features& features, int threads,
                 Isa isa = Isa::automatic, const std::function<void()>& between_bands = {});

}  // namespace parray::denoise
