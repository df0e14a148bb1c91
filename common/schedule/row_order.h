#pragma once

#include <cstdint>
#include <vector>

#include "common/scene/settings.h"

namespace parray::schedule {

/// The order in which an image's rows are handed out: element p is the row at position p.
///
/// `sequential`: 0, 1, 2 ... `interleaved`: bit-reversed, so that any range of positions samples
/// the whole image and a band of dear rows is shared by all. A permutation of 0 .. height - 1.
std::vector<std::uint32_t> make_row_order(RowOrder order, std::uint32_t height);

}  // namespace parray::schedule
