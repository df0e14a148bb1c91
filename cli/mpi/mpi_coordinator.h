#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cli/mpi/kept_job.h"
#include "cli/mpi/message_leases.h"
#include "cli/mpi/mpi_job.h"
#include "cli/preview.h"
#include "cli/progress.h"
#include "coordinator/window_ledger.h"
#include "worker/rank_worker.h"

namespace parray {

/// Rank 0 at work: takes results in, keeps them, watches the other ranks, and traces as one of
/// them.
class MpiCoordinator {
 public:
  struct Options {
    Time patience = seconds(60);
    Time checkpoint = seconds(10);
    Following following;
  };
  /// References outlive the object. `pet` is called all the time.
  MpiCoordinator(const MpiWorld& world, KeptJob& kept, ThreadCellTeam& team,
                 WindowLedger::Locate locate, std::function<void()> pet, const Options& options);

  /// Does a pass of the job, or all of it. Returns when every cell is in, it is decided whether
  /// there is another pass, and all ranks can know that this one is over: true if there is. Throws
  /// RunError when no rank gets on, Interrupted after a signal; what is finished has been kept by
  /// then.
  ///
  /// `leases[r]` are rank r's, over rank 0's memory; without messages only leases[0] is there.
  /// References stay good for meet_ranks(), gather_ranks() and ledger().
  bool run_pass(const WorkPlan& plan, const WindowLayout& layout, Transport& transport,
                std::vector<std::unique_ptr<WindowLeases>>& leases);

  /// Between passes: waits for the other ranks. Throws as run_pass() does.
  void meet_ranks();
  /// Waits for the last words of the other ranks; false if some do not answer in time.
  bool gather_ranks(Time patience);

  /// Of the latest pass; it has counted on from those before.
  [[nodiscard]] WindowLedger& ledger() { return pass_->ledger; }
  [[nodiscard]] Time finished() const { return finished_; }

 private:
  /// A pass under way.
  struct Pass {
    Pass(MpiCoordinator& own, const WorkPlan& plan, const WindowLayout& layout,
         Transport& transport, std::vector<std::unique_ptr<WindowLeases>>& leases);
    const WorkPlan& plan;
    Transport& transport;
    WindowLedger ledger;
    RankWorker worker;
    std::unique_ptr<MessageServer> server;
  };

  bool end_pass();
  void stop_if_interrupted();
  void serve();
  void stay_alive();
  void take_turn(Time now);
  void keep_some_rows(Time now);
  void keep_all_rows();
  void look_after_ranks(Time now);
  [[nodiscard]] JobStatus status(Time now, bool done) const;
  [[noreturn]] void give_up(Time now);
  [[nodiscard]] std::string kept_text() const;

  const MpiWorld& world_;
  KeptJob& kept_;
  ThreadCellTeam& team_;
  const WindowLedger::Locate locate_;
  const std::function<void()> pet_;
  const Options options_;
  SteadyClock clock_;
  std::unique_ptr<Pass> pass_;
  Progress progress_;
  Preview preview_;
  bool asked_for_help_ = false;  ///< others get on only while rank 0 looks
  std::uint64_t last_activity_ = 0;
  Time eager_until_{};
  Time started_;
  std::uint64_t samples_before_;  ///< of earlier lives of the job
  Time finished_{};
  Time next_look_{};
  Time next_checkpoint_;
  Time keeping_{};  ///< spent in the current checkpoint
};

}  // namespace parray
