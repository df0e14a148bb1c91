#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <queue>
#include <utility>
#include <vector>

#include "common/scene/settings.h"
#include "coordinator/leases/window_collector.h"
#include "tests/experiments/simulation/costs.h"
#include "tests/experiments/simulation/sim_team.h"
#include "tests/experiments/simulation/sim_window.h"
#include "tests/support/rooms.h"
#include "worker/lease_runner.h"
#include "worker/window_source.h"

namespace parray::simulation {

struct JobOptions {
  RenderSettings settings;          ///< size, samples, schedule, row order (not automatic)
  std::vector<double> row_seconds;  ///< of one thread, by image row: the whole job's
  double cell_noise = 0;
  std::uint64_t seed = 1;
  std::uint32_t ranks = 1;
  std::uint32_t threads = 1;   ///< of each rank, each on a core of its own
  std::vector<double> speeds;  ///< of the ranks; empty: 1 each
  std::vector<Stop> stops;     ///< of a rank in order, without overlap
  LinkCosts link;
  HostCosts host;
  StartCosts start;
  std::uint32_t ledger_ranks = Ledgers::group_ranks;  ///< as Ledgers has it
  Time give_up = std::chrono::hours(10000);
};

/// Seconds, start-up left out, that no way of handing out leases could do without.
struct Floors {
  double cells = 0;   ///< cell after cell to the core that is free first, at no cost
  double rank_0 = 0;  ///< all of its threads take in all cells, and nothing else
  double link = 0;    ///< all records through rank 0's link
};

/// A job of `parray-mpi` in virtual time: the very plan, sources, runners and collector, on a
/// simulated window with simulated teams. In one thread; the same options give the same result.
class SimJob {
 public:
  explicit SimJob(const JobOptions& options);
  ~SimJob();
  SimJob& operator=(SimJob&&) = delete;

  /// Returns when every cell is in; false: not before `give_up`.
  bool run();

  [[nodiscard]] double seconds() const { return to_seconds(end_); }
  /// Before ranks ask for work, and what building takes them afterwards.
  [[nodiscard]] double start_seconds() const { return ready_ + options_.start.build; }
  /// On one core of speed 1.
  [[nodiscard]] double work_seconds() const { return work_; }
  /// Of all cores together, in cores of speed 1.
  [[nodiscard]] double cores() const;
  [[nodiscard]] double efficiency() const { return work_ / (cores() * seconds()); }
  /// The same without start-up.
  [[nodiscard]] double running_efficiency() const {
    return work_ / (cores() * (seconds() - start_seconds()));
  }

  [[nodiscard]] Floors floors() const;

  /// By rank, in seconds of its own cores; sums to threads * seconds().
  [[nodiscard]] const std::vector<Spent>& spent() const { return spent_; }
  /// Of all ranks, in seconds of cores of speed 1; sums to cores() * seconds().
  [[nodiscard]] Spent spent_together() const;
  /// The report's figure 8: a rank's time of tracing over the job's, start-up left out.
  [[nodiscard]] double normalized_seconds(std::uint32_t rank) const;
  [[nodiscard]] const WorkTally& tally(std::uint32_t rank) const;

  [[nodiscard]] const WorkPlan& plan() const { return *pass_.plan; }
  [[nodiscard]] const Framebuffer& framebuffer() const { return picture_.framebuffer(); }
  [[nodiscard]] const WindowCollector::Totals& totals() const { return totals_; }

 private:
  struct Rank;
  struct Ledger;
  struct Event {
    Time at;
    std::uint64_t order;
    std::uint32_t rank;
    bool operator>(const Event& other) const {
      return at != other.at ? at > other.at : order > other.order;
    }
  };
  void turn(Rank& rank, Time now);
  void coordinate(Rank& rank);
  void schedule(std::uint32_t rank, Time at);
  [[nodiscard]] Time running_again(std::uint32_t rank, Time at) const;

  const JobOptions options_;
  JobPicture picture_;
  RankPass pass_;
  RankJob job_{options_.settings, "", nullptr};
  WindowLayout layout_;
  std::vector<std::uint64_t> words_;
  SimMemory memory_;
  Ledgers ledgers_;
  std::vector<std::unique_ptr<Ledger>> kept_;  ///< none if the only one is in rank 0's memory
  RankClock coordinator_clock_;
  SimWindow coordinator_window_;
  WindowCollector::Totals totals_;
  RankJudge judge_;
  WindowCollector collector_;
  std::vector<double> costs_;
  TracedMap map_;
  double work_ = 0;
  double ready_ = 0;
  std::vector<std::unique_ptr<Rank>> ranks_;
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
  std::uint64_t events_scheduled_ = 0;
  Time next_look_{};
  Time end_{};
  std::vector<Spent> spent_;
};

}  // namespace parray::simulation
