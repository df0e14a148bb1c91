#pragma once

#include <string_view>

#include "common/scene/settings_fwd.h"

namespace parray::adaptive {

/// Checks that 32-bit picture values can represent an error.
///
/// `error` is a target, an RMSE or a half-width in linear radiance; 0: no such target, and no
/// check. `option` is the name of its option in messages. The passes of the render aim at `share`
/// times `error`; `share` is in (0, 1]. Values near `largest_radiance`, the radiance of the scene's
/// sky, have the largest rounding error. Throws InputError if half of `share` times `error` is
/// below that rounding error: more samples would not change the file, and the render would never
/// end.
void check_above_rounding(std::string_view option, double error, double largest_radiance,
                          double share = 1);

/// Checks both targets of a job in the same way. Throws InputError. Checks nothing if
/// settings.passes is not empty, because that list alone ends the picture.
void check_targets(const StopSettings& settings, double largest_radiance);

}  // namespace parray::adaptive
