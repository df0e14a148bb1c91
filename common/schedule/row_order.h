#pragma once

#include <cstdint>
#include <vector>

#include "common/scene/setting_choices.h"

namespace parray::schedule {

/// Returns the order in which the rows of an image are leased: element p is the row at position p.
/// The result is a permutation of 0 .. height - 1.
///
/// `sequential`: 0, 1, 2 ... `interleaved`: the order of the reversed bits, for the next power of
/// two from `height` on, without the numbers that are not rows. So any range of positions samples
/// the whole image, and all workers share a band of expensive rows. `automatic`, which
/// resolve_settings() normally replaces, counts as `sequential`.
std::vector<std::uint32_t> make_row_order(RowOrder order, std::uint32_t height);

}  // namespace parray::schedule
