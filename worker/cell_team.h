#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/scene/scene.h"
#include "common/scene/settings.h"
#include "common/schedule/work_plan.h"
#include "common/trace/kernel.h"
#include "worker/task_thread.h"

namespace parray {

/// The records of some cells, as they stand in a window (proto/window.h).
struct TracedCells {
  CellRange range;
  std::vector<std::byte> records;
  std::uint64_t samples = 0;
  double seconds = 0;  ///< spent tracing
};

/// What traces cells for a rank, one range at a time. Called from one thread.
class CellTeam {
 public:
  virtual ~CellTeam() = default;
  /// Begins to trace; only when idle.
  virtual void start(const CellRange& range) = 0;
  /// At work, or with a result that has not been taken.
  [[nodiscard]] virtual bool busy() const = 0;
  /// The traced cells, once. Throws RunError when tracing failed.
  virtual std::optional<TracedCells> take() = 0;
  /// Gives the current range up, without a result.
  virtual void abandon() = 0;
  /// Samples traced since the start; grows while the team is alive.
  [[nodiscard]] virtual std::uint64_t traced() const = 0;
  /// Building the accelerator: alive, although traced() stands still.
  [[nodiscard]] virtual bool building() const = 0;
};

/// The real one: a thread of its own leads OpenMP threads, which take plan.piece_cells() cells at a
/// time. The accelerator is built before the first range, and serves all plans.
class ThreadCellTeam final : public CellTeam {
 public:
  using Plan = std::shared_ptr<const WorkPlan>;
  ThreadCellTeam(Scene scene, const RenderSettings& settings, Plan plan, int threads);

  /// From now on ranges are of `plan`: the next pass of the same job.
  void change_plan(Plan plan) { plan_ = std::move(plan); }

  void start(const CellRange& range) override { thread_.start({plan_, range}); }
  [[nodiscard]] bool busy() const override { return !thread_.idle(); }
  std::optional<TracedCells> take() override { return thread_.take(); }
  void abandon() override { thread_.abandon(); }
  [[nodiscard]] std::uint64_t traced() const override { return traced_; }
  [[nodiscard]] bool building() const override { return building_; }

  /// Returns when the current range is done, or after `timeout`.
  void wait(Time timeout) { thread_.wait_until_done(timeout); }

  /// Of the accelerator, once there has been a result.
  struct Built {
    double seconds = 0;
    std::uint64_t bytes = 0;
    std::string isa;
  };
  [[nodiscard]] Built built() const;

 private:
  struct Task {
    Plan plan;
    CellRange range;
  };
  TracedCells trace(const Task& task, const std::atomic<bool>& stop);
  void build();
  TracedCells trace_cells(const Task& task, const std::atomic<bool>& stop);

  std::unique_ptr<const Scene> scene_;  ///< until the accelerator is built
  const RenderSettings settings_;
  Plan plan_;
  const int threads_;
  std::vector<std::uint32_t> row_at_;
  std::atomic<std::uint64_t> traced_ = 0;
  std::atomic<bool> building_ = false;
  std::unique_ptr<Kernel> kernel_;
  mutable std::mutex mutex_;  // guards built_
  Built built_;
  TaskThread<Task, TracedCells> thread_;
};

}  // namespace parray
