#pragma once

#include <cstdint>
#include <vector>

#include "common/image/row_block.h"
#include "common/scene/settings.h"

namespace parray {

/// A horizontal run of pixels of one row, and a range of their samples.
struct Cell {
  std::uint32_t position = 0;  ///< of the row in the job's row order
  std::uint32_t x_begin = 0;   ///< columns [x_begin, x_end)
  std::uint32_t x_end = 0;
  std::uint32_t sample_begin = 0;  ///< samples [sample_begin, sample_end)
  std::uint32_t sample_end = 0;

  [[nodiscard]] std::uint32_t pixels() const { return x_end - x_begin; }
  [[nodiscard]] std::uint64_t samples() const {
    return std::uint64_t{pixels()} * (sample_end - sample_begin);
  }
  friend bool operator==(const Cell&, const Cell&) = default;
};

/// Cells [begin, end) of a plan: what is leased over a window.
struct CellRange {
  std::uint64_t begin = 0;
  std::uint64_t end = 0;

  [[nodiscard]] std::uint64_t count() const { return end - begin; }
  friend bool operator==(const CellRange&, const CellRange&) = default;
};

/// The unfinished samples of a job, cut into cells of about a fifth of a millisecond, in the order
/// in which they are handed out: every rank computes the same plan, so that a number names a cell.
///
/// A cell has a place of its own in the window: no two ranks ever add to the same sums, and a copy
/// of a cell writes the very bytes that are there. Immutable.
class WorkPlan {
 public:
  /// `settings` are resolved. `pending` are disjoint rectangles of the job's work, cut into bands
  /// of rows, column by column: bands of one row where the policy deals out whole rows, of 16 where
  /// leases are parts of interleaved rows. `tile` > 1: bands of that many rows, cut into square
  /// tiles (the seed report, section 4.6), of which a thread takes one at a time.
  WorkPlan(const RenderSettings& settings, std::vector<WorkRect> pending, std::uint32_t tile = 0);

  [[nodiscard]] std::uint64_t cells() const { return first_cell_.back(); }
  [[nodiscard]] std::uint64_t samples() const;  ///< of all cells
  [[nodiscard]] Cell cell(std::uint64_t index) const;

  /// Cells of a whole row of the image (of one range of samples, if those are cut).
  [[nodiscard]] std::uint64_t cells_per_row() const { return columns_; }
  /// The most pixels that a cell has.
  [[nodiscard]] std::uint32_t cell_pixels() const { return cell_pixels_; }
  /// Rows of a band.
  [[nodiscard]] std::uint32_t band_rows() const { return band_; }
  /// Samples of a full cell.
  [[nodiscard]] double cell_samples() const;
  /// Cells that a thread takes at a time.
  [[nodiscard]] std::uint32_t piece_cells() const { return tile_; }

  [[nodiscard]] const std::vector<WorkRect>& rects() const { return rects_; }

  /// Ranges of samples that the rows of `rects()[rect]` are cut into.
  [[nodiscard]] std::uint32_t layers(std::size_t rect) const;
  /// Which of the plan's row passes a cell belongs to: (rectangle, range of samples, row), counted
  /// through. A pass that has all its cells is a finished RowBlock of one row.
  [[nodiscard]] std::uint64_t pass_of(std::uint64_t cell) const;
  [[nodiscard]] std::uint64_t passes() const { return first_pass_.back(); }
  /// What pass `pass` covers.
  [[nodiscard]] WorkRect pass_rect(std::uint64_t pass) const;
  /// The cells of a pass from left to right: the first, and the distance to the next.
  struct Stride {
    std::uint64_t first = 0;
    std::uint64_t step = 1;
  };
  [[nodiscard]] Stride pass_cells(std::uint64_t pass) const;

 private:
  struct Place {
    std::size_t rect;
    std::uint32_t layer;
    std::uint32_t row;     ///< within the rectangle
    std::uint64_t column;  ///< which run of pixels
  };
  [[nodiscard]] Place place_of(std::uint64_t cell) const;
  /// Which rectangle an index into `first` belongs to.
  static std::size_t rect_of(const std::vector<std::uint64_t>& first, std::uint64_t index);

  std::uint32_t width_;
  std::uint32_t tile_;
  std::uint32_t band_;  ///< rows that are cut across together
  std::uint32_t cell_pixels_;
  std::uint32_t layer_samples_;
  std::uint64_t columns_;
  std::vector<WorkRect> rects_;
  std::vector<std::uint64_t> first_cell_;  ///< of each rectangle, and the total
  std::vector<std::uint64_t> first_pass_;  ///< likewise
};

}  // namespace parray
