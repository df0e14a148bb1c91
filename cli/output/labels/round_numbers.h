#pragma once

#include <string>
#include <vector>

#include "common/rooms.h"

/// Numbers that people read at a glance: 1, 2 or 5 times a power of ten.
namespace parray::labels {

/// The largest of them that is not above `value`, which is > 0 and finite.
double round_below(double value);
/// The least that is not below it.
double round_above(double value);

/// Marks along a scale.
struct Ticks {
  std::vector<double> values;      ///< multiples of a round step, ascending, in [low, high]
  std::vector<std::string> texts;  ///< of each: its digits, without the power of ten
  int exponent = 0;                ///< the texts times 10^exponent are the values
};

/// At least one and at most `most` (>= 2) marks from `low` to `high`, finite and low < high. A
/// power of ten is taken out where the numbers would be long: from 100,000 on, and below 0.01.
Ticks ticks_between(double low, double high, int most);

/// "10" and a superscript.
std::string power_of_ten(int exponent);

}  // namespace parray::labels
