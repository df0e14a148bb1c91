#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "common/base/bands.h"
#include "common/math/float_mode.h"

namespace parray::adaptive {

/// Adds up sum_of(begin, end), a Sum, over consecutive parts [begin, end) of 0 .. `items` - 1, in
/// parallel. The parts depend on `items` alone and are added in order. So the result has the same
/// bits for any number of threads. A Sum has a neutral value Sum{} and an operator +=.
template <typename Sum, typename SumOf>
Sum ordered_sum(std::size_t items, const SumOf& sum_of) {
  constexpr std::size_t least_items = std::size_t{1} << 15;
  constexpr std::size_t most_parts = 64;
  const std::size_t parts = std::clamp<std::size_t>(items / least_items, 1, most_parts);
  std::vector<Sum> sums(parts);
  side_by_side(parts, 0, [&](std::size_t part) {
    const FloatMode ieee;
    sums[part] = sum_of(items * part / parts, items * (part + 1) / parts);
  });
  Sum sum{};
  for (const Sum& part : sums) sum += part;
  return sum;
}

}  // namespace parray::adaptive
