#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/mpi/checkpointed_job.h"
#include "cli/mpi/mpi_job.h"
#include "cli/mpi/transport.h"
#include "cli/output/preview.h"
#include "cli/output/progress.h"
#include "coordinator/jobs/report.h"
#include "coordinator/leases/window_collector.h"
#include "worker/lease_runner.h"

namespace parray::mpi {

/// The objects that every rank that renders needs for a pass.
struct PassResources {
  RankPass pass;
  std::optional<WindowLayout> layout;
  std::optional<WindowSource> source;

  /// Makes the objects for the pass `next`. Collective, unless rank 0 is alone.
  void begin(RankPass next, Transport& transport, const Ranks& ranks, RankJob& job);
};

/// Rank 0's work: merges results, keeps them on disk, watches the other ranks, and traces as one of
/// them.
class MpiCoordinator {
 public:
  struct Options {
    Time patience = seconds(60);  ///< run_pass() throws after this time without any progress
    /// Shortest interval between saves to disk. A full buffer (JobRun::buffer_full()) is saved at
    /// once.
    Time checkpoint = seconds(10);
    ProgressOptions following;
    std::uint32_t threads = 1;      ///< threads of rank 0
    std::uint32_t all_threads = 1;  ///< threads of all ranks together
    /// Returns the non-finite samples of a cell: see WindowCollector::Hooks.
    std::function<std::vector<ExcludedSamples>(const CellBatch& cell)> locate;
    /// Traces a cell in rank 0, to decide which rank is wrong: see RankJudge::Hooks.
    std::function<TracedCells(const CellBatch& cell)> trace;
    std::vector<std::string> hosts;        ///< host name of each rank that renders, by rank
    std::function<void()> reset_watchdog;  ///< called in each turn of run_pass() and barrier()
  };
  /// `world`, `job` and `team` must outlive this object.
  MpiCoordinator(const MpiWorld& world, CheckpointedJob& job, ThreadTeam& team, Options options);

  /// Renders the pass that the job has begun. Returns when all cells are merged, the next pass is
  /// decided, and all ranks can see that this pass is over. Returns whether there is another pass.
  /// Returns true at once if the picture began again because of a faulty rank. Throws RunError if
  /// no rank makes progress or if rank 0 itself returned wrong bits, and Interrupted after a
  /// signal. Saves the results to disk before it throws.
  ///
  /// `resources` and `transport` must live until the next call of run_pass(): barrier(),
  /// last_barrier(), facts() and rank_value() use them.
  bool run_pass(PassResources& resources, Transport& transport);

  /// Waits until all ranks have ended the pass. Throws as run_pass() does. Collective.
  void barrier();
  /// Does the same after the last pass: then rank_value() has the last values of all ranks. Returns
  /// false if a rank does not answer within `patience`.
  bool last_barrier(Time patience);

  /// Returns facts for the report, from the values of all ranks. Call after last_barrier().
  [[nodiscard]] RenderFacts facts(const Ranks& ranks) const;
  /// Returns a value that a rank has published, in the unit of RankWord. 0 if no pass was rendered.
  [[nodiscard]] std::uint64_t rank_value(std::uint32_t rank, WindowLayout::RankWord word) const {
    return pass_ ? pass_->collector.rank_value(rank, word) : 0;
  }
  [[nodiscard]] const WindowCollector::Totals& totals() const { return totals_; }
  /// Returns the ranks that returned wrong results.
  [[nodiscard]] const std::vector<RankJudge::Verdict>& verdicts() const {
    return judge_.verdicts();
  }
  /// Shows the finished picture in the preview.
  void show_finished(const Image& image) { preview_.finish(image); }

 private:
  /// The current pass.
  struct Pass {
    Pass(MpiCoordinator& own, PassResources& resources, Transport& transport);
    Transport& transport;
    WindowCollector collector;
    LeaseRunner runner;
  };

  bool end_pass();
  void report_verdict(const RankJudge::Verdict& verdict);
  [[noreturn]] void give_up_judging();
  void stop_if_interrupted();
  void stay_alive();
  void take_turn(Time now);
  void save_some(Time now);
  void check_ranks(Time now);
  [[nodiscard]] PassTimes times(Time now) const;
  [[nodiscard]] JobStatus status(Time now, bool done) const;
  [[noreturn]] void give_up(Time now);
  [[nodiscard]] std::string kept_text() const;

  const MpiWorld& world_;
  CheckpointedJob& job_;
  JobRun& run_;
  ThreadTeam& team_;
  const Options options_;
  SteadyClock clock_;
  RankJudge judge_;
  WindowCollector::Totals totals_;
  std::unique_ptr<Pass> pass_;
  Progress progress_;
  Preview preview_;
  bool asked_for_help_ = false;  ///< the operations of other ranks need rank 0's help
  std::uint64_t last_activity_ = 0;
  Time eager_until_{};
  Time started_;
  Time pass_began_;
  Time finished_;
  double deciding_seconds_ = 0;
  double progress_before_;
  Time next_look_{};
  Time next_checkpoint_;
  Time saving_{};  ///< time spent for the current checkpoint
};

}  // namespace parray::mpi
