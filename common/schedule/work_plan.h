#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/image/row_block.h"
#include "common/scene/settings.h"

namespace parray {

/// A horizontal run of pixels of one row, and a range of their samples; in a pass that gives each
/// pixel a range of its own, what the pixel has of these.
struct Cell {
  std::uint32_t position = 0;  ///< of the row in the job's row order
  std::uint32_t x_begin = 0;   ///< columns [x_begin, x_end)
  std::uint32_t x_end = 0;
  std::uint32_t sample_begin = 0;  ///< samples [sample_begin, sample_end)
  std::uint32_t sample_end = 0;
  /// Of each pixel, what the whole pass gives it; empty: all the same. A view of the plan's.
  std::span<const SampleRange> pass{};

  [[nodiscard]] std::uint32_t pixels() const { return x_end - x_begin; }
  /// Of the pixel `index` pixels right of the first.
  [[nodiscard]] SampleRange samples_of(std::uint32_t index) const;
  /// Of all pixels, one after the other.
  [[nodiscard]] std::vector<SampleRange> sample_ranges() const;
  /// How many that is together.
  [[nodiscard]] std::uint64_t samples() const;
  friend bool operator==(const Cell& a, const Cell& b);
};

/// Cells [begin, end) of a plan: what is leased over a window.
struct CellRange {
  std::uint64_t begin = 0;
  std::uint64_t end = 0;

  [[nodiscard]] std::uint64_t count() const { return end - begin; }
  friend bool operator==(const CellRange&, const CellRange&) = default;
};

/// The unfinished samples of a job, or of one pass of it, cut into cells of about a fifth of a
/// millisecond, in the order in which they are handed out: every rank computes the same plan, so
/// that a number names a cell.
///
/// A cell has a place of its own in the window: no two ranks ever add to the same sums, and a copy
/// of a cell writes the very bytes that are there. Immutable.
class WorkPlan {
 public:
  /// `settings` are resolved. `pending` are disjoint rectangles of the job's work, cut into bands
  /// of rows, column by column: bands of one row where the policy deals out whole rows, of 16 where
  /// leases are parts of interleaved rows. `tile` > 1: bands of that many rows, cut into square
  /// tiles (the seed report, section 4.6), of which a thread takes one at a time.
  ///
  /// `samples`: what the pass gives each pixel (Framebuffer::pass_samples, image order); empty: all
  /// that the rectangles hold.
  WorkPlan(const RenderSettings& settings, std::vector<WorkRect> pending, std::uint32_t tile = 0,
           std::vector<SampleRange> samples = {});

  [[nodiscard]] std::uint64_t cells() const { return first_cell_.back(); }
  [[nodiscard]] std::uint64_t samples() const { return total_; }  ///< of all cells
  [[nodiscard]] Cell cell(std::uint64_t index) const;

  /// Cells of a whole row of the image (of one range of samples, if those are cut).
  [[nodiscard]] std::uint64_t cells_per_row() const { return columns_; }
  /// The most pixels that a cell has.
  [[nodiscard]] std::uint32_t cell_pixels() const { return cell_pixels_; }
  /// Rows of a band.
  [[nodiscard]] std::uint32_t band_rows() const { return band_; }
  /// Samples of a full cell; the mean, where each pixel has a range of its own.
  [[nodiscard]] double cell_samples() const { return cell_samples_; }
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
  [[nodiscard]] std::span<const SampleRange> row_samples(std::uint32_t position) const;
  void count_samples();
  void cut_evenly();
  void cut_ragged();

  std::uint32_t width_;
  std::uint32_t tile_;
  std::uint32_t band_;  ///< rows that are cut across together
  std::uint32_t cell_pixels_ = 1;
  std::uint32_t layer_samples_ = 1;
  std::uint64_t columns_ = 1;
  double cell_samples_ = 0;
  std::vector<WorkRect> rects_;
  std::vector<SampleRange> samples_;       ///< of each pixel, image order; empty: all the same
  std::vector<std::uint32_t> row_at_;      ///< where they are not
  std::uint64_t total_ = 0;                ///< samples of all cells
  std::uint32_t most_ = 1;                 ///< samples that a pixel has in one rectangle, at most
  std::vector<std::uint64_t> first_cell_;  ///< of each rectangle, and the total
  std::vector<std::uint64_t> first_pass_;  ///< likewise
};

}  // namespace parray
