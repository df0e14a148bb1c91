#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/image/framebuffer.h"
#include "common/schedule/traced_cells.h"
#include "common/schedule/work_plan.h"

namespace parray::coordinator {

/// A number for a tracer: a machine or a worker process of a farm, or a rank of an mpirun. Every
/// process computes the same number for it: see machine_key() and tracer_key().
using TracerKey = std::uint64_t;

/// Collects the results of a pass, of a farm or of MPI ranks. Merges new cells, compares repeated
/// ones, and remembers which tracer traced each. A cell that is merged is not merged again until
/// retract() removes it.
///
/// Not thread-safe.
class ResultCollector {
 public:
  /// `framebuffer` must outlive this object and must not contain samples of the plan yet.
  ResultCollector(std::shared_ptr<const WorkPlan> plan, Framebuffer& framebuffer);

  /// Numbers of cells in a result.
  struct Taken {
    std::uint64_t fresh = 0;          ///< new cells, now merged
    std::uint64_t duplicates = 0;     ///< merged before, with the same bits
    std::uint64_t mismatches = 0;     ///< merged before, with other bits
    std::uint64_t fresh_samples = 0;  ///< samples of the new cells
  };
  /// Merges the cells of `traced` that are not merged yet, and compares the others. The caller must
  /// have checked `traced` by fault_of() or unpack_cells().
  Taken take(TracerKey tracer, const TracedCells& traced) {
    return take(tracer, traced, cell_digests(traced.records, record_size()),
                plan_->grid()->cells_of(traced.range));
  }
  /// Does the same if the caller already has `digests`, the cell_digests() of the records (not
  /// digests_of()), and `cells`, the cells of the range.
  Taken take(TracerKey tracer, const TracedCells& traced, std::vector<std::uint64_t> digests,
             std::span<const Cell> cells);
  /// Returns a digest per cell, for compare() and differing(). Digests are equal exactly if counts,
  /// sums and excluded samples are, except for hash collisions.
  [[nodiscard]] std::vector<std::uint64_t> digests_of(const TracedCells& traced) const {
    return digests_of(traced, cell_digests(traced.records, record_size()));
  }
  /// Counts the merged cells of the range that agree with `digests`, and those that differ.
  /// `digests`: from digests_of(), one per cell of the range. Ignores cells that are not
  /// merged. Merges nothing.
  Taken compare(const CellRange& range, const std::vector<std::uint64_t>& digests) const;
  /// Notes that `tracer` also traced the range. The merged cells of the range that another tracer
  /// traced then count as checked. Compares no bits: the caller has done that. Ignores cells that
  /// are not merged.
  void note_check(TracerKey tracer, const CellRange& range);
  /// Notes that a check of the range is wanted.
  void note_wanted(const CellRange& range) { wanted_.push_back(range); }
  /// Returns whether a merged cell is checked: another tracer has traced it, too (note_check()).
  [[nodiscard]] bool is_checked(std::uint64_t cell) const;
  /// Returns the number of checked cells.
  [[nodiscard]] std::uint64_t checked_cells() const;
  /// Merged cells that are not checked.
  struct Unchecked {
    CellRange range;
    TracerKey tracer = 0;  ///< the tracer of all these cells
  };
  /// Returns all merged cells that are not checked, in ranges of at most `most` cells.
  [[nodiscard]] std::vector<Unchecked> unchecked_cells(std::uint64_t most) const;
  /// Returns the cells of unchecked_cells() for which note_wanted() was called.
  [[nodiscard]] std::vector<Unchecked> wanted_cells(std::uint64_t most) const;

  /// A merged cell whose bits differ from a digest.
  struct Differing {
    std::uint64_t cell = 0;
    TracerKey tracer = 0;  ///< the tracer of the merged bits
  };
  /// Returns the merged cells of the range that differ from `digests`: see compare().
  [[nodiscard]] std::vector<Differing> differing(const CellRange& range,
                                                 const std::vector<std::uint64_t>& digests) const;

  /// What retract() changed.
  struct Retraction {
    /// Cells whose results this call has removed: all merged cells of the cleared pixels.
    std::vector<CellRange> cells;
    /// Merged cells that the retracted tracer had checked. Others may have checked them, too.
    std::vector<Unchecked> unchecked;
  };
  /// Clears all pixels of which `tracer` has traced a merged cell, and forgets its checks. (Sums of
  /// single cells are not kept, so all cells of such a pixel must be traced again.)
  Retraction retract(TracerKey tracer);
  /// Clears all pixels that have a merged cell in `ranges`. Returns the cells whose results this
  /// call has removed.
  std::vector<CellRange> retract(const std::vector<CellRange>& ranges);
  /// Returns whether `tracer` traced a cell that is merged now.
  [[nodiscard]] bool has_cells_of(TracerKey tracer) const;
  /// Returns whether `tracer` traced or checked a cell that is merged now.
  [[nodiscard]] bool relies_on(TracerKey tracer) const;

  /// Returns all tracers of results and checks, also of retracted ones.
  [[nodiscard]] const std::vector<TracerKey>& tracers() const { return tracers_; }
  [[nodiscard]] const std::shared_ptr<const WorkPlan>& plan() const { return plan_; }
  [[nodiscard]] std::uint64_t done_cells() const { return done_; }
  [[nodiscard]] bool done() const { return done_ == plan_->cells(); }
  /// Returns whether a cell is merged.
  [[nodiscard]] bool has(std::uint64_t cell) const { return cells_[cell].digest != 0; }
  /// Returns the first run of cells that are not merged, from the cell `from` on: at most `most`
  /// cells. Empty: all cells from there on are merged.
  [[nodiscard]] CellRange next_missing(std::uint64_t from, std::uint64_t most) const;
  /// Returns all runs of cells that are not merged.
  [[nodiscard]] std::vector<CellRange> missing() const;

 private:
  struct Done {
    std::uint64_t digest = 0;  ///< 0: not merged
    std::uint64_t rays = 0;
    std::uint64_t lost = 0;
    std::uint32_t nonfinite = 0;
    std::uint32_t tracer = 0;  ///< place in tracers_
  };
  struct Check {
    CellRange range;
    std::uint32_t tracer = 0;  ///< place in tracers_
  };

  [[nodiscard]] std::size_t record_size() const {
    return record_bytes(plan_->grid()->shape().cell_pixels);
  }
  [[nodiscard]] std::vector<std::uint64_t> digests_of(const TracedCells& traced,
                                                      std::vector<std::uint64_t> digests) const;
  void merge(const CellBatch& batch, std::uint64_t index, const Cell& cell, std::uint64_t digest,
             std::span<const std::byte> record, std::uint32_t tracer, Taken& taken);
  void exclude_some(const Cell& cell, const std::vector<ExcludedSamples>& excluded);
  [[nodiscard]] std::vector<bool> checked() const;
  [[nodiscard]] std::vector<Unchecked> unchecked_among(const std::vector<bool>& some,
                                                       std::uint64_t most) const;
  void forget_checks_of_missing();
  void add_unchecked(std::vector<Unchecked>& list, std::uint64_t cell, std::uint64_t most) const;
  void clear_pixels(std::uint64_t index, std::vector<std::uint64_t>& cleared);
  [[nodiscard]] std::uint32_t place_of(TracerKey tracer);

  std::shared_ptr<const WorkPlan> plan_;
  Framebuffer& framebuffer_;
  std::vector<Done> cells_;
  std::vector<Check> checks_;
  std::vector<CellRange> wanted_;
  std::vector<TracerKey> tracers_;
  std::uint64_t done_ = 0;
  std::vector<PixelSums> sums_;  ///< scratch: the sums of the cell that is being merged
};

}  // namespace parray::coordinator
