#include <doctest/doctest.h>

#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/window_rig.h"

namespace parray {

TEST_CASE("the cells of a range are those of its numbers, across bands, layers and stages") {
  test::Dice dice(1);
  for (int i = 0; i < 300; ++i) {
    CAPTURE(i);
    GridShape shape;
    shape.width = 1 + dice.below32(70);
    shape.height = 1 + dice.below32(70);
    shape.row_order = dice.one_in(2) ? RowOrder::sequential : RowOrder::interleaved;
    shape.band_rows = 1 + dice.below32(20);
    shape.cell_pixels = 1 + dice.below32(shape.width);
    shape.layer_samples = 1 + dice.below32(9);
    shape.stages = {{0, 1 + dice.below32(30)}};
    if (shape.width > 4 && shape.height > 4) {
      shape.stages.emplace_back(0, 1 + dice.below32(5), Lattice{1, 2, 4});
    }
    const CellGrid grid(shape);
    const std::uint64_t begin = dice.below(grid.cells());
    const CellRange range{begin, begin + dice.below(grid.cells() - begin + 1)};
    const std::vector<Cell> cells = grid.cells_of(range);
    REQUIRE(cells.size() == range.count());
    for (std::uint64_t cell = range.begin; cell < range.end; ++cell) {
      REQUIRE(cells[cell - range.begin] == grid.cell(cell));
    }
  }
}

}  // namespace parray
