#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "common/scene/scene.h"
#include "common/scene/settings.h"
#include "common/schedule/cell_grid.h"
#include "common/schedule/traced_cells.h"
#include "common/trace/integrator/path_tracer.h"
#include "worker/accelerator_cache.h"
#include "worker/task_thread.h"

namespace parray::worker {

/// Job and epoch: what names a lease.
using LeaseKey = std::pair<std::uint64_t, std::uint64_t>;

/// A lease with all that tracing it needs.
struct Assignment {
  std::uint64_t job = 0;
  std::uint32_t pass = 0;
  std::uint64_t epoch = 0;
  CellBatch cells;
  RenderSettings settings;  ///< resolved
  std::string scene_id;     ///< equal ids are equal scenes
  /// Null only where the team's latest result was of the same scene and settings.
  std::shared_ptr<const Scene> scene;
  /// Seconds of tracing after which the team hands in what it has; 0: it traces all cells.
  double longest = 0;

  [[nodiscard]] LeaseKey key() const { return {job, epoch}; }
};

/// A lease that the team is through with.
struct Finished {
  std::uint64_t job = 0;
  std::uint32_t pass = 0;
  std::uint64_t epoch = 0;
  std::shared_ptr<const TracedCells> cells;  ///< null: it could not be traced
  std::shared_ptr<const CellGrid> grid;      ///< of the cells
  std::string failure;                       ///< why it could not, in one line; else empty
  double build_seconds = 0;                  ///< spent building the accelerator, whenever that was
  std::uint64_t accelerator_bytes = 0;
  std::string isa;

  [[nodiscard]] LeaseKey key() const { return {job, epoch}; }
};

/// What traces leases, one at a time. Called from one thread.
class Team {
 public:
  virtual ~Team() = default;
  /// Begins to trace; only when idle.
  virtual void start(Assignment assignment) = 0;
  /// Neither at work nor with a lease that has not been taken.
  [[nodiscard]] virtual bool idle() const = 0;
  /// The finished lease, once; the team is idle from then on. After a failure too, and it traces
  /// other leases as before.
  virtual std::optional<Finished> take() = 0;
  /// Gives the current lease up: within a few milliseconds the team is idle, without a result.
  virtual void abandon() = 0;
  /// Samples traced since the start, by all threads; grows while the team is alive.
  [[nodiscard]] virtual std::uint64_t traced() const = 0;
  /// Building an accelerator: alive, although traced() stands still.
  [[nodiscard]] virtual bool preparing() const = 0;
};

/// The real team: a thread of its own that leads an OpenMP team. It touches no sockets;
/// `on_finished` is called from its thread when a lease is finished (to wake the thread that owns
/// the link).
class ThreadTeam final : public Team {
 public:
  /// Makes what traces a lease; threads build. May throw.
  using TracerSource =
      std::function<std::shared_ptr<const PathTracer>(const Assignment&, int threads)>;

  /// What it builds, it leaves in `accelerators`; `tracers`, for tests, takes the place of that.
  explicit ThreadTeam(
      int threads, std::function<void()> on_finished = [] {},
      std::shared_ptr<AcceleratorCache> accelerators = std::make_shared<AcceleratorCache>(),
      TracerSource tracers = {});

  void start(Assignment assignment) override { thread_.start(std::move(assignment)); }
  [[nodiscard]] bool idle() const override { return thread_.idle(); }
  std::optional<Finished> take() override { return thread_.take(); }
  void abandon() override { thread_.abandon(); }
  [[nodiscard]] std::uint64_t traced() const override { return traced_; }
  [[nodiscard]] bool preparing() const override { return preparing_; }

  /// Returns when the current lease is finished, or after `timeout`.
  void wait(Time timeout) { thread_.wait_until_done(timeout); }

 private:
  Finished trace(const Assignment& assignment, const std::atomic<bool>& stop);
  void prepare(const Assignment& assignment);
  std::shared_ptr<const PathTracer> tracer_for(const Assignment& assignment);

  const int threads_;
  const std::shared_ptr<AcceleratorCache> accelerators_;
  const TracerSource tracers_;
  std::atomic<std::uint64_t> traced_ = 0;
  std::atomic<bool> preparing_ = false;

  // Of the team's thread alone: the picture that was traced last.
  std::string scene_;
  RenderSettings settings_;
  std::shared_ptr<const PathTracer> tracer_;
  double build_seconds_ = 0;

  TaskThread<Assignment, Finished> thread_;
};

}  // namespace parray::worker
