#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/schedule/cell_grid.h"

namespace parray::schedule {

/// What a pass is to add to a picture.
struct Pass {
  /// Ranges of samples, one handed out after the other; see GridShape.
  std::vector<Stage> stages;
  /// Of each pixel, image order; empty: of each pixel all that the stages hold. Only with stages of
  /// the whole image.
  std::vector<SampleRange> samples;
};

/// A pass cut into cells of about a fifth of a millisecond, in the order in which they are handed
/// out. Fixed when the pass begins, whatever is done of it already, and the same wherever it is
/// computed: a number names a cell for as long as the pass lasts. Immutable; any thread.
class WorkPlan {
 public:
  /// `settings` are resolved. `tile` > 1: square tiles of that many pixels a side (the seed report,
  /// section 4.6), of which a thread takes one at a time.
  WorkPlan(const RenderSettings& settings, Pass pass, std::uint32_t tile = 0);

  [[nodiscard]] const std::shared_ptr<const CellGrid>& grid() const { return grid_; }
  [[nodiscard]] std::uint64_t cells() const { return grid_->cells(); }
  [[nodiscard]] Cell cell(std::uint64_t index) const { return grid_->cell(index); }
  [[nodiscard]] std::uint64_t samples() const { return total_; }  ///< of all cells
  /// Of a cell, on average; > 0.
  [[nodiscard]] double cell_samples() const { return cell_samples_; }
  /// Of each pixel, image order; empty: of each pixel all that the stages hold.
  [[nodiscard]] const std::vector<SampleRange>& pixel_samples() const { return samples_; }
  /// What tracing cells of the plan takes.
  [[nodiscard]] CellBatch batch(const CellRange& range) const;

 private:
  [[nodiscard]] GridShape evenly(GridShape shape, std::uint32_t tile) const;
  [[nodiscard]] GridShape ragged(GridShape shape, std::uint32_t tile, std::uint32_t most) const;

  std::vector<SampleRange> samples_;
  std::uint64_t total_ = 0;
  double cell_samples_ = 1;
  std::shared_ptr<const CellGrid> grid_;
};

}  // namespace parray::schedule
