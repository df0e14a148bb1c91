#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "common/image/framebuffer.h"
#include "common/schedule/traced_cells.h"
#include "common/schedule/work_plan.h"

namespace parray::coordinator {

/// Whoever traces, in every life of a coordinator: see machine_key() and tracer_key().
using TracerKey = std::uint64_t;

/// Takes in what has been traced of a pass, whichever way it came: merges what is new, compares
/// what comes again, and remembers who traced what. Every cell is merged exactly once.
///
/// Plain state; one thread at a time.
class ResultCollector {
 public:
  /// `framebuffer` outlives the object and holds no samples of the plan's.
  ResultCollector(std::shared_ptr<const WorkPlan> plan, Framebuffer& framebuffer);

  /// How many cells were new, came again with the same bits, or came again with others.
  struct Taken {
    std::uint64_t fresh = 0;
    std::uint64_t duplicates = 0;
    std::uint64_t mismatches = 0;
    std::uint64_t fresh_samples = 0;
  };
  /// `traced` has gone through fault_of() or unpack_cells(): its numbers are possible ones. Cells
  /// that are in are only compared.
  Taken take(TracerKey tracer, const TracedCells& traced) {
    return take(tracer, traced, cell_digests(traced.records, record_size()),
                plan_->grid()->cells_of(traced.range));
  }
  /// The same with the digests of its records and its cells at hand.
  Taken take(TracerKey tracer, const TracedCells& traced, std::vector<std::uint64_t> digests,
             std::span<const Cell> cells);
  /// Of each cell of what has been traced: equal unless counts, sums, or which samples were left
  /// out of the sums, differ.
  [[nodiscard]] std::vector<std::uint64_t> digests_of(const TracedCells& traced) const {
    return digests_of(traced, cell_digests(traced.records, record_size()));
  }
  /// Compares without merging. `digests` are those of the range's cells.
  Taken compare(const CellRange& range, const std::vector<std::uint64_t>& digests) const;
  /// Notes that `tracer` traced the range and got the bits that are merged.
  void note_check(TracerKey tracer, const CellRange& range);
  /// Whether a cell that is in was traced alike by somebody beside its tracer.
  [[nodiscard]] bool is_checked(std::uint64_t cell) const;
  /// Cells that are in and that somebody beside their tracer traced alike.
  [[nodiscard]] std::uint64_t checked_cells() const;

  /// A cell that is in, with other bits than `digests` have for it.
  struct Differing {
    std::uint64_t cell = 0;
    TracerKey tracer = 0;  ///< whose bits are merged
  };
  [[nodiscard]] std::vector<Differing> differing(const CellRange& range,
                                                 const std::vector<std::uint64_t>& digests) const;

  struct Retraction {
    std::vector<CellRange> cells;      ///< no longer in, among them others of the same pixels
    std::vector<CellRange> unchecked;  ///< still in, but only `tracer` had checked them
  };
  /// Sets back all pixels of which `tracer` has traced cells, and forgets its checks.
  Retraction retract(TracerKey tracer);
  /// Sets back the pixels of some cells.
  std::vector<CellRange> retract(const std::vector<CellRange>& ranges);
  /// Whether something that is in was traced by `tracer`.
  [[nodiscard]] bool has_cells_of(TracerKey tracer) const;
  /// Whether something that is in was traced, or checked, by `tracer`.
  [[nodiscard]] bool relies_on(TracerKey tracer) const;

  /// All who have sent something.
  [[nodiscard]] const std::vector<TracerKey>& tracers() const { return tracers_; }
  [[nodiscard]] const WorkPlan& plan() const { return *plan_; }
  [[nodiscard]] const std::shared_ptr<const WorkPlan>& shared_plan() const { return plan_; }
  [[nodiscard]] std::uint64_t done_cells() const { return done_; }
  [[nodiscard]] bool done() const { return done_ == plan_->cells(); }
  [[nodiscard]] bool has(std::uint64_t cell) const { return cells_[cell].digest != 0; }
  /// The first run of cells from `from` on that are not in, `most` at most; empty if there is none.
  [[nodiscard]] CellRange next_missing(std::uint64_t from, std::uint64_t most) const;
  /// All such runs.
  [[nodiscard]] std::vector<CellRange> missing() const;

 private:
  struct Done {
    std::uint64_t digest = 0;  ///< 0: not in
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
  void forget_checks_of_missing();
  void clear_pixels(std::uint64_t index, std::vector<std::uint64_t>& cleared);
  [[nodiscard]] std::uint32_t place_of(TracerKey tracer);

  std::shared_ptr<const WorkPlan> plan_;
  Framebuffer& framebuffer_;
  std::vector<Done> cells_;
  std::vector<Check> checks_;
  std::vector<TracerKey> tracers_;
  std::uint64_t done_ = 0;
  std::vector<PixelSums> sums_;  ///< of one cell, while it is merged
};

}  // namespace parray::coordinator
