#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "common/scene/scene.h"
#include "common/scene/settings_fwd.h"
#include "common/schedule/cell_grid.h"
#include "common/schedule/traced_cells.h"
#include "common/trace/integrator/path_tracer.h"
#include "worker/accelerator_cache.h"
#include "worker/task_thread.h"

namespace parray::worker {

/// The key of a lease: job and epoch.
using LeaseKey = std::pair<std::uint64_t, std::uint64_t>;

/// A lease with all data that tracing it needs.
struct LeaseWork {
  std::uint64_t job = 0;
  std::uint64_t epoch = 0;
  CellBatch cells;
  Boxed<RenderSettings> settings;  ///< no value is `automatic`, except perhaps `isa`
  std::string scene_id;            ///< scenes with equal ids are equal
  /// Null only if the team's latest result has the same scene and settings.
  std::shared_ptr<const Scene> scene;
  /// Seconds of tracing after which the team hands in what it has; 0: it traces all cells.
  double longest = 0;

  [[nodiscard]] LeaseKey key() const { return {job, epoch}; }
};

/// A lease that the team has finished.
struct LeaseResult {
  std::uint64_t job = 0;
  std::uint64_t epoch = 0;
  std::shared_ptr<const TracedCells> cells;  ///< null: the lease could not be traced
  std::shared_ptr<const CellGrid> grid;      ///< grid of the cells
  std::string failure;                       ///< reason of a failure, in one line; otherwise empty
  double build_seconds = 0;  ///< time spent building the accelerator, possibly for an earlier lease
  std::uint64_t accelerator_bytes = 0;
  std::string isa;

  [[nodiscard]] LeaseKey key() const { return {job, epoch}; }
};

/// Traces leases, one at a time. One thread calls all functions.
class Team {
 public:
  virtual ~Team() = default;
  /// Begins to trace. Call it only when idle.
  virtual void start(LeaseWork assignment) = 0;
  /// Returns whether the team has no work and no finished lease that waits.
  [[nodiscard]] virtual bool idle() const = 0;
  /// Returns the finished lease, once; nothing: there is none. The team is idle after it has
  /// returned one. After a failed lease it traces other leases as before.
  virtual std::optional<LeaseResult> take() = 0;
  /// Gives up the current lease, which then has no result. The team becomes idle when its threads
  /// have finished their current cells, or the accelerator that they build, which may take seconds.
  virtual void abandon() = 0;
  /// Returns the samples of all leases that the team has traced in its life. The number grows while
  /// the team traces.
  [[nodiscard]] virtual std::uint64_t traced() const = 0;
  /// Returns whether the team builds an accelerator: it is alive, although traced() does not grow.
  [[nodiscard]] virtual bool preparing() const = 0;
};

/// The team of a real worker: a background thread that leads an OpenMP team. It uses no sockets.
/// The background thread calls `on_finished` when a lease is finished, to wake the owner of the
/// link.
class ThreadTeam final : public Team {
 public:
  /// Makes the tracer of a lease with `threads` threads. May throw.
  using TracerSource =
      std::function<std::shared_ptr<const PathTracer>(const LeaseWork&, int threads)>;

  /// Stores the accelerators that it builds in `accelerators`. In tests, `tracers` makes tracers.
  explicit ThreadTeam(
      int threads, std::function<void()> on_finished = [] {},
      std::shared_ptr<AcceleratorCache> accelerators = std::make_shared<AcceleratorCache>(),
      TracerSource tracers = {});

  void start(LeaseWork assignment) override { thread_.start(std::move(assignment)); }
  [[nodiscard]] bool idle() const override { return thread_.idle(); }
  std::optional<LeaseResult> take() override { return thread_.take(); }
  void abandon() override { thread_.abandon(); }
  [[nodiscard]] std::uint64_t traced() const override { return traced_; }
  [[nodiscard]] bool preparing() const override { return preparing_; }

  /// Waits until the current lease is finished, at most for the duration `timeout`.
  void wait(Time timeout) { thread_.wait_until_done(timeout); }

 private:
  LeaseResult trace(const LeaseWork& assignment, const std::atomic<bool>& stop);
  void prepare(const LeaseWork& assignment);
  std::shared_ptr<const PathTracer> tracer_for(const LeaseWork& assignment);

  const int threads_;
  const std::shared_ptr<AcceleratorCache> accelerators_;
  const TracerSource tracers_;
  std::atomic<std::uint64_t> traced_ = 0;
  std::atomic<bool> preparing_ = false;

  // Only the background thread uses these members: the picture traced last.
  std::string scene_;
  Boxed<RenderSettings> settings_;
  std::shared_ptr<const PathTracer> tracer_;
  double build_seconds_ = 0;

  TaskThread<LeaseWork, LeaseResult> thread_;
};

}  // namespace parray::worker
