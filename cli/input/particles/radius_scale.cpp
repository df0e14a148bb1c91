#include "cli/input/particles/radius_scale.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "cli/input/particles/file_place.h"
#include "cli/input/select/columns.h"
#include "cli/input/select/selection.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/text.h"
#include "common/scene/scene_ranges.h"

namespace parray::input {
namespace {

/// Returns "mass of particle 7", with the particle's index in the file.
std::string number_of_particle(const std::string& by, const Particles& particles,
                               std::ptrdiff_t place) {
  return printable(by) + " of particle " +
         std::to_string(particles.index_of(static_cast<std::size_t>(place)));
}

bool is_radius(double value) {
  return value >= ranges::length.least && value <= ranges::length.most;  // false for NaN
}

/// Returns the number of each particle. All are finite.
std::vector<double> numbers_in(const Particles& particles, const std::string& by) {
  const NumberSource source = known_number("radius_by", by, particles);
  std::vector<double> numbers(particles.count());
  source(0, numbers);
  const auto unknown = std::ranges::find_if_not(numbers, [](double v) { return std::isfinite(v); });
  if (unknown != numbers.end()) {
    throw SourceError("radius_by", number_of_particle(by, particles, unknown - numbers.begin()) +
                                       " is not known: select particles with a known number");
  }
  return numbers;
}

/// Replaces the numbers by radii from `low` to `high`. Returns the numbers with these radii.
NumberBounds scale_to(const RadiusScale& scale, std::vector<double>& numbers) {
  NumberBounds bounds = scale.numbers;
  if (bounds.empty()) std::ranges::for_each(numbers, [&](double number) { bounds.add(number); });
  const auto [least, most] = bounds;
  const auto [low, high] = std::pair(scale.low, scale.high);
  for (double& number : numbers) {
    // Halves, because the difference may overflow.
    const double share = least < most ? (number / 2 - least / 2) / (most / 2 - least / 2) : 0.5;
    number = std::clamp(low + share * (high - low), low, high);
  }
  return bounds;
}

}  // namespace

RadiusScale radius_scale_from(std::string_view text) {
  // One colon is part of a name, such as velocity:0.
  const bool scaled = std::ranges::count(text, ':') >= 2;
  const std::size_t second = scaled ? text.rfind(':') : text.size();
  const std::size_t first = scaled ? text.rfind(':', second - 1) : text.size();
  RadiusScale scale{lower_case(trimmed(text.substr(0, first)))};
  bool valid = !scale.by.empty() && scale.by.front() != ':' && scale.by.back() != ':';
  if (scaled) {
    scale.low = number_or_nan(trimmed(text.substr(first + 1, second - first - 1)));
    scale.high = number_or_nan(trimmed(text.substr(second + 1)));
    valid = valid && is_radius(scale.low) && is_radius(scale.high) && scale.low < scale.high;
  }
  if (valid) return scale;
  throw InputError("'" + printable(text) +
                   "' does not name radii: write a numeric column, or COLUMN:LOW:HIGH with two "
                   "ascending radii such as mass:0.5:2");
}

std::string text_of(const RadiusScale& scale) {
  if (scale.low == 0) return scale.by;
  return scale.by + ":" + number_text(scale.low) + ":" + number_text(scale.high);
}

NumberBounds apply(const RadiusScale& scale, Particles& particles) {
  if (particles.count() == 0) return {};
  std::vector<double> radii = numbers_in(particles, scale.by);
  const NumberBounds sized = scale.low > 0 ? scale_to(scale, radii) : NumberBounds{};
  const auto wrong = std::ranges::find_if_not(radii, is_radius);
  if (wrong != radii.end()) {
    throw SourceError("radius_by", number_of_particle(scale.by, particles, wrong - radii.begin()) +
                                       " is " + number_text(*wrong) +
                                       ", which is not a radius: write " + printable(scale.by) +
                                       ":LOW:HIGH to scale the numbers");
  }
  particles.radii = std::move(radii);
  return sized;
}

}  // namespace parray::input
