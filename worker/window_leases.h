#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/scene/settings.h"
#include "common/schedule/chunk_policy.h"
#include "worker/lease_source.h"

namespace parray {

/// How a rank sizes its leases; the same on every rank, but for `rank` and `threads`.
struct WindowLeaseOptions {
  SchedulePolicy policy = SchedulePolicy::weighted;
  std::uint32_t rank = 0;
  std::uint32_t threads = 1;
  std::uint32_t all_threads = 1;  ///< of all ranks
  /// Weighted leases are between these two long, by measured speed.
  double shortest_seconds = 0.002;
  double longest_seconds = 1;
};

/// Leases over a window, without anybody's help: the rank takes a step number, or a run of cells,
/// by an atomic addition and computes its chunk; see PROTOCOL.md, "The window".
///
/// When nothing is left it draws a ticket and waits for a copy of cells that others have not
/// finished.
class WindowLeases final : public LeaseSource {
 public:
  /// `plan`, `layout` and `window` outlive the object.
  WindowLeases(const WorkPlan& plan, const WindowLayout& layout, Window& window,
               const WindowLeaseOptions& options);

  Taken take(double samples_per_second, bool idle) override;
  void complete(const CellRange& range, std::span<const std::byte> records) override;
  void tell(WindowLayout::RankWord word, std::uint64_t value) override;

  /// The log entry of `range`, whose records are in the window: the second half of complete(), for
  /// results that came another way.
  void log(const CellRange& range, std::uint64_t digest);

 private:
  std::optional<CellRange> take_step();
  std::optional<CellRange> take_weighted(double samples_per_second);
  Taken take_copy();
  SpeedSum publish_speed(double samples_per_second);

  const WorkPlan& plan_;
  const WindowLayout& layout_;
  Window& window_;
  const WindowLeaseOptions options_;
  std::vector<std::uint64_t> starts_;  ///< of the chunks; empty if weighted
  SpeedSum published_;                 ///< this rank's part of the sum
  bool exhausted_ = false;
  std::optional<std::uint64_t> ticket_;
};

}  // namespace parray
