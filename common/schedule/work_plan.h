#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/scene/settings_fwd.h"
#include "common/schedule/cell_grid.h"

namespace parray::schedule {

/// The samples that a pass adds to a picture.
struct Pass {
  /// Ranges of samples in the order of tracing; see GridShape.
  std::vector<Stage> stages;
  /// Sample range of each pixel, in image order. A pixel gets only the samples that are in its
  /// range and in a stage. Empty: every pixel gets all samples of the stages. Must be empty unless
  /// every stage covers the whole image.
  std::vector<SampleRange> samples;
};

/// A pass cut into cells of about 2048 samples or more, in the order in which they are leased.
/// Cells have fewer samples if a row of the image has fewer. The plan depends on the constructor's
/// arguments alone, and is the same on every machine. So a number names the same cell throughout
/// the pass, also after a restart. Immutable and thread-safe.
class WorkPlan {
 public:
  /// `settings` must be resolved: no value is `automatic`, except perhaps `isa`. If `tile` > 1, the
  /// plan has square tiles of `tile` pixels a side. A cell is one row of a tile, and a thread takes
  /// all cells of a tile at a time. Throws std::logic_error if `pass` has samples for another
  /// number of pixels than the image. Throws InputError as CellGrid does.
  WorkPlan(const RenderSettings& settings, Pass pass, std::uint32_t tile = 0);

  [[nodiscard]] const std::shared_ptr<const CellGrid>& grid() const { return grid_; }
  [[nodiscard]] std::uint64_t cells() const { return grid_->cells(); }
  [[nodiscard]] Cell cell(std::uint64_t index) const { return grid_->cell(index); }
  [[nodiscard]] std::uint64_t samples() const { return total_; }  ///< samples of all cells
  /// Returns the average number of samples of a cell, or 1 if it is less.
  [[nodiscard]] double cell_samples() const { return cell_samples_; }
  /// Returns the sample range of each pixel, in image order. Empty: every pixel gets all samples of
  /// the stages.
  [[nodiscard]] const std::vector<SampleRange>& pixel_samples() const { return samples_; }
  /// Returns the batch that a worker needs to trace the cells of `range`.
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
