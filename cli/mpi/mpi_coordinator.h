#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cli/mpi/kept_job.h"
#include "cli/mpi/message_leases.h"
#include "cli/mpi/mpi_job.h"
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
    bool quiet = false;
  };
  /// All references outlive the object. `leases[r]` are rank r's, over rank 0's memory; without
  /// messages only leases[0] is there.
  MpiCoordinator(const MpiWorld& world, KeptJob& kept, const WorkPlan& plan,
                 const WindowLayout& layout, Transport& transport,
                 std::vector<std::unique_ptr<WindowLeases>>& leases, ThreadCellTeam& team,
                 WindowLedger::Locate locate, const Options& options);

  /// Returns when every cell is in and all ranks know. `pet` is called all the time. Throws
  /// RunError when no rank gets on, Interrupted after a signal; what is finished has been kept by
  /// then.
  void run(const std::function<void()>& pet);

  /// Waits for the last words of the other ranks; false if some do not answer in time.
  bool gather_ranks(Time patience, const std::function<void()>& pet);

  [[nodiscard]] WindowLedger& ledger() { return ledger_; }
  [[nodiscard]] Time finished() const { return finished_; }

 private:
  void take_turn(Time now);
  void keep_some_rows(Time now);
  void keep_all_rows();
  void look_after_ranks(Time now);
  [[nodiscard]] JobStatus status(Time now) const;
  [[noreturn]] void give_up(Time now);
  [[nodiscard]] std::string kept_text() const;

  const MpiWorld& world_;
  KeptJob& kept_;
  const WorkPlan& plan_;
  Transport& transport_;
  ThreadCellTeam& team_;
  const Options options_;
  SteadyClock clock_;
  WindowLedger ledger_;
  std::unique_ptr<MessageServer> server_;
  RankWorker worker_;
  Progress progress_;
  bool asked_for_help_;  ///< others get on only while rank 0 looks
  std::uint64_t last_activity_ = 0;
  Time eager_until_{};
  Time started_;
  Time finished_{};
  Time next_look_{};
  Time next_checkpoint_;
  Time keeping_{};  ///< spent in the current checkpoint
};

}  // namespace parray
