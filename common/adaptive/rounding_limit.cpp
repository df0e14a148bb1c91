#include "common/adaptive/rounding_limit.h"

#include <cmath>
#include <string>

#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/scene/stop_settings.h"

namespace parray::adaptive {
namespace {

/// Returns the standard deviation of the error that rounding `radiance` to 32 bits causes. Assumes
/// that the error is uniform over one ulp and that `radiance` is in the middle of a binade.
double rounding_error(double radiance) { return radiance * 0x1p-23 / std::sqrt(12.0) / 1.5; }

/// Formats `value` with two digits. Rounds up, so that check_above_rounding() accepts the printed
/// number.
std::string rounded_up(double value) {
  const double scale = std::pow(10.0, 1 - std::floor(std::log10(value)));
  return number_text(std::ceil(value * scale) / scale);
}

}  // namespace

void check_above_rounding(std::string_view option, double error, double largest_radiance,
                          double share) {
  const double rounding = rounding_error(largest_radiance);
  const double least = 2 * rounding / share;
  if (error <= 0 || error >= least) return;
  throw InputError(std::string(option) + " " + number_text(error) +
                   " is too small: pictures hold 32-bit numbers, and rounding to them causes an "
                   "error of about " +
                   rounded_up(rounding) + " in this scene, with every --precision: use " +
                   rounded_up(least) + " or more");
}

void check_targets(const StopSettings& settings, double largest_radiance) {
  if (!settings.passes.empty()) return;
  check_above_rounding("--target-error", settings.target_error, largest_radiance);
  check_above_rounding("--target-half-width", settings.target_half_width, largest_radiance);
}

}  // namespace parray::adaptive
