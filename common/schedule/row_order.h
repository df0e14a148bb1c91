#pragma once

#include <cstdint>
#include <vector>

#include "common/scene/setting_choices.h"

namespace parray::schedule {

/// Returns the order in which the rows of an image are leased: element p is the row at position p.
/// The result is a permutation of 0 .. height - 1.
///
/// `sequential`: 0, 1, 2 ... `interleaved`: 0, 1, 2 ... with their binary digits in reverse order,
/// as many digits as height - 1 has, without the numbers that are not rows. With 6 rows: 0, 4, 2,
/// 1, 5, 3. So any range of positions samples the whole image, and all workers share a group of
/// adjacent expensive rows. `automatic`, which resolve_settings() normally replaces, counts as
/// `sequential`.
std::vector<std::uint32_t> make_row_order(RowOrder order, std::uint32_t height);

}  // namespace parray::schedule
