#include <doctest/doctest.h>

#include "common/base/error.h"
#include "tests/support/dice.h"
#include "tests/support/message_of.h"
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

TEST_CASE("stages of a lattice have ascending samples, also with another lattice between them") {
  GridShape shape;
  shape.width = shape.height = 8;
  const Lattice even{0, 0, 2};
  const Lattice odd{1, 1, 2};
  const auto refused = [&shape](const std::vector<Stage>& stages) {
    shape.stages = stages;
    return test::message_of<InputError>([&shape] { const CellGrid grid(shape); }) != "no error";
  };
  CHECK_FALSE(refused({{0, 4, even}, {0, 4, odd}, {4, 6, even}}));
  CHECK(refused({{0, 4, even}, {0, 4, odd}, {3, 6, even}}));
  CHECK(refused({{4, 6, even}, {0, 4, odd}, {0, 4, even}}));
  CHECK(refused({{0, 4, even}, {3, 6, even}}));
}

}  // namespace parray
