#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/image/row_block.h"
#include "common/scene/scene.h"
#include "common/scene/settings.h"
#include "common/trace/kernel.h"
#include "worker/task_thread.h"

namespace parray {

/// A lease with all that tracing it needs.
struct Assignment {
  std::uint64_t job = 0;
  std::uint64_t epoch = 0;
  WorkRect rect;
  RenderSettings settings;
  std::vector<SampleRange> samples;  ///< of each pixel of `rect`, position order; empty: all
  std::string scene_id;
  std::shared_ptr<const Scene> scene;
};

/// A traced lease.
struct Finished {
  std::uint64_t job = 0;
  std::uint64_t epoch = 0;
  RowBlock block;
  double seconds = 0;        ///< spent tracing
  double build_seconds = 0;  ///< spent building the accelerator, whenever that was
  std::uint64_t accelerator_bytes = 0;
  std::string isa;
};

/// What traces leases for a Worker, one at a time. Called from one thread.
class Team {
 public:
  virtual ~Team() = default;
  /// Begins to trace; only when idle.
  virtual void start(Assignment assignment) = 0;
  [[nodiscard]] virtual bool idle() const = 0;
  /// The finished lease, once; the team is idle from then on. Throws RunError when tracing failed.
  virtual std::optional<Finished> take() = 0;
  /// Gives the current lease up: within a few milliseconds the team is idle, without a result.
  virtual void abandon() = 0;
  /// Samples traced since the start, by all threads; grows while the team is alive.
  [[nodiscard]] virtual std::uint64_t traced() const = 0;
  /// Building an accelerator: alive, although traced() stands still.
  [[nodiscard]] virtual bool preparing() const = 0;
};

/// Traces the samples of a rectangle with `threads` OpenMP threads. Work is dealt out in pieces of
/// about a millisecond, parts of a row and of a pixel's samples included, so that a single row, or
/// a single pixel, keeps all threads busy. `samples`: which of the rectangle's each pixel has, in
/// position order; empty: all. `traced` grows as pieces are done; `stop` ends the work early, and
/// the block is then incomplete.
RowBlock trace_rect(const Kernel& kernel, const RenderSettings& settings, const WorkRect& rect,
                    int threads, std::atomic<std::uint64_t>& traced, const std::atomic<bool>& stop,
                    std::span<const SampleRange> samples = {});

/// The real team: a thread of its own that leads an OpenMP team. It touches no sockets;
/// `on_finished` is called from its thread when a result is ready (to wake the thread that owns the
/// link).
class ThreadTeam final : public Team {
 public:
  ThreadTeam(int threads, std::function<void()> on_finished);

  void start(Assignment assignment) override { thread_.start(std::move(assignment)); }
  [[nodiscard]] bool idle() const override { return thread_.idle(); }
  std::optional<Finished> take() override { return thread_.take(); }
  void abandon() override { thread_.abandon(); }
  [[nodiscard]] std::uint64_t traced() const override { return traced_; }
  [[nodiscard]] bool preparing() const override { return preparing_; }

 private:
  Finished trace(const Assignment& assignment, const std::atomic<bool>& stop);

  const int threads_;
  std::atomic<std::uint64_t> traced_ = 0;
  std::atomic<bool> preparing_ = false;

  // Of the team's thread alone: the kernel of the job that was traced last.
  std::string kernel_scene_;
  RenderSettings kernel_settings_;
  std::unique_ptr<Kernel> kernel_;
  double build_seconds_ = 0;

  TaskThread<Assignment, Finished> thread_;
};

}  // namespace parray
