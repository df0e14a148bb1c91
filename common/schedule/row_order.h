#pragma once

#include <cstdint>
#include <vector>

#include "common/scene/setting_choices.h"

namespace parray::schedule {

/// Returns the order in which an image's rows are leased: element p is the row at position p.
///
/// `sequential`: 0, 1, 2 ... `interleaved`: bit-reversed, so that any range of positions samples
/// the whole image and all workers share a band of expensive rows. The result is a permutation of 0
/// .. height - 1.
std::vector<std::uint32_t> make_row_order(RowOrder order, std::uint32_t height);

}  // namespace parray::schedule
