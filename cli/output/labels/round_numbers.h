#pragma once

#include <string>
#include <vector>

#include "common/rooms.h"

/// Round numbers: 1, 2 or 5 times a power of ten.
namespace parray::labels {

/// Return the largest round number not above `value`, and the smallest not below it. `value` is > 0
/// and finite. A value within a millionth of a round number counts as that number.
double round_below(double value);
double round_above(double value);

/// Marks along a scale.
struct Ticks {
  std::vector<double> values;      ///< multiples of a round step, ascending, in [low, high]
  std::vector<std::string> texts;  ///< digits of each value, without the power of ten
  int exponent = 0;                ///< value = text times 10^exponent
};

/// Returns at least one and at most `most` (>= 2) marks from `low` to `high`, which are finite, low
/// < high. Extracts a power of ten if the numbers would be long: from 100,000 on, and below 0.01.
Ticks ticks_between(double low, double high, int most);

/// Returns at least one and at most `most` (>= 2) marks of a logarithmic scale from `low` to
/// `high`, which are finite, 0 < low < high: powers of ten, and 2 and 5 times them if there is
/// room. Texts include the power of ten, so the exponent is 0. A scale with fewer than two such
/// numbers has the marks of ticks_between().
Ticks log_ticks_between(double low, double high, int most);

/// Returns "10" with a superscript.
std::string power_of_ten(int exponent);

}  // namespace parray::labels
