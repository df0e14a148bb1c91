#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/image/lattice.h"
#include "common/image/sample_range.h"
#include "common/scene/setting_choices.h"

namespace parray::schedule {

/// The unit of work: a run of pixels in one row (every `step`-th pixel) and a range of their
/// samples.
struct Cell {
  std::uint32_t y = 0;        ///< row of the image
  std::uint32_t x_begin = 0;  ///< columns [x_begin, x_end)
  std::uint32_t x_end = 0;
  /// The samples of every pixel. If pixels have ranges of their own (CellBatch), only the samples
  /// that are in both ranges.
  SampleRange samples;
  std::uint32_t step = 1;  ///< columns from one pixel to the next

  [[nodiscard]] std::uint32_t pixels() const { return (x_end - x_begin + step - 1) / step; }
  friend bool operator==(const Cell&, const Cell&) = default;
};

/// A range of cells [begin, end) of a pass: the content of a lease.
struct CellRange {
  std::uint64_t begin = 0;
  std::uint64_t end = 0;

  [[nodiscard]] std::uint64_t count() const { return end - begin; }
  friend bool operator==(const CellRange&, const CellRange&) = default;
};

/// A range of samples that is traced for every pixel of one lattice (every n-th pixel in x and y)
/// before the next stage starts.
struct Stage : SampleRange {
  Stage() = default;
  Stage(std::uint32_t first, std::uint32_t last, Lattice its_lattice = {})
      : SampleRange{first, last}, lattice(its_lattice) {}

  Lattice lattice{};  ///< pixels of the image that the stage covers

  friend bool operator==(const Stage&, const Stage&) = default;
};

/// Returns the order in which the rows of an image are leased: element p is the row at position p.
/// The result is a permutation of 0 .. height - 1.
///
/// `sequential`: 0, 1, 2 ... `interleaved`: 0, 1, 2 ... with their binary digits in reverse order,
/// as many digits as height - 1 has, without the numbers that are not rows. With 6 rows: 0, 4, 2,
/// 1, 5, 3. So any range of positions samples the whole image, and all workers share a group of
/// adjacent expensive rows. `automatic`, which resolve_settings() normally replaces, counts as
/// `sequential`.
std::vector<std::uint32_t> make_row_order(RowOrder order, std::uint32_t height);

/// The numbers that determine how the samples of a pass are cut into cells. They are few enough to
/// travel with every lease.
struct GridShape {
  std::uint32_t width = 1;  ///< pixels of the image, 1 .. limits::max_image_side
  /// Pixels, 1 .. limits::max_image_side; width times height is at most limits::max_pixels.
  std::uint32_t height = 1;
  RowOrder row_order = RowOrder::sequential;
  std::uint32_t band_rows = 1;  ///< rows of a band, 1 .. 2^16
  /// Pixels of a cell, 1 .. width; the last cell of a row may have fewer.
  std::uint32_t cell_pixels = 1;
  std::uint32_t layer_samples = 1;  ///< most samples of a pixel in one cell, > 0
  std::uint32_t piece_cells = 1;    ///< cells that a thread takes at a time, 1 .. 2^16
  /// Stages in the order of tracing: 1 to 64, none empty. Stages of the same lattice have
  /// ascending, disjoint sample ranges. Stages of different lattices share no pixel.
  std::vector<Stage> stages{{0, 1}};

  friend bool operator==(const GridShape&, const GridShape&) = default;
};

/// Numbers the cells of a pass in the order in which they are leased. The order is by stage, then
/// by layer, by band, by column of cells, and by row of the band. A layer is a range of up to
/// layer_samples samples of every pixel. A band is a group of `band_rows` rows that are consecutive
/// in the row order; it is one row if the policy leases whole rows. Immutable and thread-safe.
class CellGrid {
 public:
  /// Throws InputError if a number is out of its range, or if the grid would have 2^40 cells or
  /// more. Does not check that stages of different lattices share no pixel.
  explicit CellGrid(GridShape shape);

  [[nodiscard]] const GridShape& shape() const { return shape_; }
  [[nodiscard]] std::uint64_t cells() const { return first_cell_.back(); }
  /// Returns cell `index`, which must be below cells().
  [[nodiscard]] Cell cell(std::uint64_t index) const;
  /// Returns all cells of a range, in order, faster than cell() for each of them.
  [[nodiscard]] std::vector<Cell> cells_of(const CellRange& range) const;
  /// Returns the number of cells in a whole row of the image, in one layer of samples. With several
  /// lattices, the row is one of the last lattice.
  [[nodiscard]] std::uint64_t cells_per_row() const { return parts_.back().columns; }
  /// Returns the numbers of all cells with the same pixels as cell number `cell`, including `cell`.
  [[nodiscard]] std::vector<std::uint64_t> cells_of_same_pixels(std::uint64_t cell) const;

 private:
  struct Place {
    std::size_t stage;
    std::uint64_t layer;
    std::uint64_t position;  ///< position of the row in the row order
    std::uint64_t column;
    std::uint64_t rows_left;     ///< rows of the band from this one on
    std::uint64_t within_layer;  ///< number of the cell among those of its layer
  };
  [[nodiscard]] Place place_of(std::uint64_t cell) const;
  [[nodiscard]] Cell cell_at(const Place& place) const;
  /// Sizes that determine the numbers of a stage's cells.
  struct Part {
    std::uint64_t columns = 0;          ///< cells across
    std::vector<std::uint32_t> row_at;  ///< rows of the lattice, in row order
    std::uint64_t layers = 0;

    [[nodiscard]] std::uint64_t layer_cells() const { return row_at.size() * columns; }
  };

  GridShape shape_;
  std::vector<Part> parts_;                ///< one per stage
  std::vector<std::uint64_t> first_cell_;  ///< first cell of each stage, then the total
};

/// A list of some cells of a plan in ascending order. The place of a cell is its position in the
/// list, from 0. Immutable and thread-safe.
class CellList {
 public:
  CellList() = default;
  /// `ranges` must be ascending and disjoint, and no range may be empty.
  explicit CellList(std::vector<CellRange> ranges);

  /// Returns the number of cells in the list.
  [[nodiscard]] std::uint64_t count() const { return first_.empty() ? 0 : first_.back(); }
  [[nodiscard]] const std::vector<CellRange>& ranges() const { return ranges_; }
  /// Returns the cells at `places` [begin, end) of the list, with end <= count(), as ascending
  /// ranges: one for each element of ranges() that they touch.
  [[nodiscard]] std::vector<CellRange> cells_at(const CellRange& places) const;

 private:
  std::vector<CellRange> ranges_;
  std::vector<std::uint64_t> first_;  ///< place of the first cell of each range, and the total
};

/// Cells together with the sample ranges of their pixels: all that a worker needs of a WorkPlan to
/// trace them.
struct CellBatch {
  std::shared_ptr<const CellGrid> grid;
  CellRange range;
  /// Sample ranges of all pixels, stored cell by cell with shape().cell_pixels entries each;
  /// entries after a cell's last pixel are empty ranges. An empty vector: every pixel gets all
  /// samples of its cell.
  std::vector<SampleRange> samples;

  /// Returns the sample range of each column of cell `index`, which must lie in `range`, from its
  /// first to its last. Columns between its pixels have empty ranges.
  [[nodiscard]] std::vector<SampleRange> column_ranges_of(std::uint64_t index) const;
  /// Returns the sample ranges of the cell's pixels as a view of this object.
  [[nodiscard]] RunSamples run_samples(std::uint64_t index) const {
    return run_samples(index, samples.empty() ? grid->cell(index) : Cell());
  }
  /// Returns run_samples(index), faster. `cell` must be cell `index`.
  [[nodiscard]] RunSamples run_samples(std::uint64_t index, const Cell& cell) const;
  /// Returns the number of samples of all cells.
  [[nodiscard]] std::uint64_t sample_count() const { return sample_count(grid->cells_of(range)); }
  /// Returns sample_count(), faster. `cells` must be the cells of `range`.
  [[nodiscard]] std::uint64_t sample_count(std::span<const Cell> cells) const;
};

}  // namespace parray::schedule
