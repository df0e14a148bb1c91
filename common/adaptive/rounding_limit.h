#pragma once

#include <string_view>

#include "common/scene/settings.h"

namespace parray::adaptive {

/// Checks that an error can be reached although a picture holds 32-bit numbers.
///
/// `error` is the value of `option`: an RMSE or a half-width in linear radiance; 0: none. The
/// passes of its render aim at `share` of it, in (0, 1]. Values near `largest_radiance`, that of
/// the scene's sky, are rounded most. Throws InputError where half of the aim is below their
/// rounding error: more samples would not show in the file, and the render would take for ever.
void check_above_rounding(std::string_view option, double error, double largest_radiance,
                          double share = 1);

/// Checks both targets of a job like this. Passes of a recipe decide by themselves when they end:
/// their targets are not checked. Throws InputError.
void check_targets(const StopSettings& settings, double largest_radiance);

}  // namespace parray::adaptive
