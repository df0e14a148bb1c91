#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/image/lattice.h"
#include "common/image/sample_range.h"
#include "common/scene/settings.h"

namespace parray::schedule {

/// A horizontal run of pixels of one row, or every `step`-th of one, and a range of their samples:
/// the unit of work.
struct Cell {
  std::uint32_t y = 0;        ///< row of the image
  std::uint32_t x_begin = 0;  ///< columns [x_begin, x_end)
  std::uint32_t x_end = 0;
  SampleRange samples;     ///< where each pixel has a range of its own, what is left of it in here
  std::uint32_t step = 1;  ///< columns from one pixel to the next

  [[nodiscard]] std::uint32_t pixels() const { return (x_end - x_begin + step - 1) / step; }
  friend bool operator==(const Cell&, const Cell&) = default;
};

/// Cells [begin, end) of a pass: what is leased.
struct CellRange {
  std::uint64_t begin = 0;
  std::uint64_t end = 0;

  [[nodiscard]] std::uint64_t count() const { return end - begin; }
  friend bool operator==(const CellRange&, const CellRange&) = default;
};

/// Samples that every pixel of a lattice is to have, handed out together.
struct Stage : SampleRange {
  Stage() = default;
  Stage(std::uint32_t first, std::uint32_t last, Lattice its_lattice = {})
      : SampleRange{first, last}, lattice(its_lattice) {}

  Lattice lattice{};  ///< of the image

  friend bool operator==(const Stage&, const Stage&) = default;
};

/// The numbers that say how the samples of a pass are cut into cells: few enough to travel with
/// every lease.
struct GridShape {
  std::uint32_t width = 1;   ///< pixels of the image, 1 .. limits::max_image_side
  std::uint32_t height = 1;  ///< likewise
  RowOrder row_order = RowOrder::sequential;
  std::uint32_t band_rows = 1;      ///< rows that are cut across together, 1 .. 2^16
  std::uint32_t cell_pixels = 1;    ///< of a cell, but for the last of a row: 1 .. width
  std::uint32_t layer_samples = 1;  ///< of a pixel in one cell, at most: > 0
  std::uint32_t piece_cells = 1;    ///< that a thread takes at a time, 1 .. 2^16
  /// One handed out after the other: 1 .. 64, none empty. Of one lattice ascending and apart; those
  /// of different lattices share no pixel.
  std::vector<Stage> stages{{0, 1}};

  friend bool operator==(const GridShape&, const GridShape&) = default;
};

/// Numbers the cells of a pass, in the order in which they are handed out: stage, layer of samples,
/// band of rows, column, row of the band. A band has one row where policies deal out whole rows.
/// Immutable; any thread.
class CellGrid {
 public:
  /// Throws InputError when a number is out of its range, or there would be 2^40 cells or more.
  explicit CellGrid(GridShape shape);

  [[nodiscard]] const GridShape& shape() const { return shape_; }
  [[nodiscard]] std::uint64_t cells() const { return first_cell_.back(); }
  /// `index` is below cells().
  [[nodiscard]] Cell cell(std::uint64_t index) const;
  /// All cells of a range, for less than one by one.
  [[nodiscard]] std::vector<Cell> cells_of(const CellRange& range) const;
  /// Cells of a whole row of the image (of one layer of samples, if those are cut); where there
  /// are lattices, of the last.
  [[nodiscard]] std::uint64_t cells_per_row() const { return parts_.back().columns; }
  /// Rows of the image, or of the last lattice, in the order in which they are handed out.
  [[nodiscard]] const std::vector<std::uint32_t>& rows() const { return parts_.back().row_at; }
  /// Every cell that holds samples of the pixels of `cell`, it included.
  [[nodiscard]] std::vector<std::uint64_t> cells_of_same_pixels(std::uint64_t cell) const;

 private:
  struct Place {
    std::size_t stage;
    std::uint64_t layer;
    std::uint64_t position;  ///< of the row in the row order
    std::uint64_t column;
    std::uint64_t rows_left;     ///< of the band, from this one on
    std::uint64_t within_layer;  ///< number of the cell among those of its layer
  };
  [[nodiscard]] Place place_of(std::uint64_t cell) const;
  [[nodiscard]] Cell cell_at(const Place& place) const;
  /// What the cells of a stage are numbered by.
  struct Part {
    std::uint64_t columns = 0;          ///< cells across
    std::vector<std::uint32_t> row_at;  ///< rows of the lattice, in their order
    std::uint64_t layers = 0;

    [[nodiscard]] std::uint64_t layer_cells() const { return row_at.size() * columns; }
  };

  GridShape shape_;
  std::vector<Part> parts_;                ///< of each stage
  std::vector<std::uint64_t> first_cell_;  ///< of each stage, and the total
};

/// Cells with all that says which samples they are made of: what a worker gets to trace.
struct CellBatch {
  std::shared_ptr<const CellGrid> grid;
  CellRange range;
  /// Of each pixel of each cell, cell after cell, shape().cell_pixels of each; empty: of each pixel
  /// all samples of its cell.
  std::vector<SampleRange> samples;

  /// Of each pixel of cell `index`, which lies in `range`.
  [[nodiscard]] std::vector<SampleRange> ranges_of(std::uint64_t index) const;
  /// The same of every column from the cell's first to its last: those between its pixels have
  /// none.
  [[nodiscard]] std::vector<SampleRange> column_ranges_of(std::uint64_t index) const;
  /// Of each pixel of the cell; a view of this.
  [[nodiscard]] RunSamples run_samples(std::uint64_t index) const {
    return run_samples(index, samples.empty() ? grid->cell(index) : Cell());
  }
  /// The same of a cell that is at hand.
  [[nodiscard]] RunSamples run_samples(std::uint64_t index, const Cell& cell) const;
  /// How many samples all cells have together.
  [[nodiscard]] std::uint64_t sample_count() const { return sample_count(grid->cells_of(range)); }
  /// The same with the range's cells at hand.
  [[nodiscard]] std::uint64_t sample_count(std::span<const Cell> cells) const;
};

}  // namespace parray::schedule
