#include "tests/experiments/simulation/sim_job.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "common/scene/settings.h"
#include "tests/support/rooms.h"

namespace parray::simulation {
namespace {

// As in cli/mpi/mpi_coordinator.cpp, where ranks are on several machines.
constexpr Time poll = std::chrono::microseconds(50);
constexpr Time look_interval = milliseconds(50);
constexpr std::uint64_t most_cells_a_turn = 4096;

double doublings(std::uint32_t ranks) { return std::ceil(std::log2(std::max(ranks, 1U))); }

/// What mpirun, MPI and the scene's broadcast take, alike on all ranks.
double ready_seconds(const JobOptions& o) {
  const double broadcast = o.start.scene_bytes / o.link.bytes_per_second + o.link.put;
  return o.start.mpi + doublings(o.ranks) * (o.start.mpi_per_doubling + broadcast);
}

/// Tells the team when nothing is left to be leased.
class WatchedSource final : public LeaseSource {
 public:
  WatchedSource(LeaseSource& source, SimCellTeam& team) : source_(source), team_(team) {}
  Taken take(Time now, double samples_per_second, bool idle) override {
    Taken taken = source_.take(now, samples_per_second, idle);
    if (taken.answer == Answer::wait) team_.note_waiting();
    return taken;
  }
  void complete(Time now, LeaseResult finished) override {
    source_.complete(now, std::move(finished));
  }
  Time tick(Time now, const TeamState& team) override { return source_.tick(now, team); }

 private:
  LeaseSource& source_;
  SimCellTeam& team_;
};

std::vector<Stop> stops_of(std::uint32_t rank, const std::vector<Stop>& stops) {
  std::vector<Stop> own;
  std::copy_if(stops.begin(), stops.end(), std::back_inserter(own),
               [rank](const Stop& stop) { return stop.rank == rank; });
  return own;
}

WindowOptions window_options(const JobOptions& o, std::uint32_t rank) {
  WindowOptions options;
  options.policy = o.settings.schedule;
  options.rank = rank;
  options.threads = o.threads;
  options.all_threads = o.threads * o.ranks;
  return options;
}

constexpr std::uint64_t events_until_settled = 1024;

SimCellTeam::Options team_options(const JobOptions& o, std::uint32_t rank) {
  return {.threads = o.threads,
          .speed = o.speeds.empty() ? 1 : o.speeds.at(rank),
          .ready = ready_seconds(o),
          .build = o.start.build,
          .hand_over = o.host.hand_over};
}

RankPass begin_pass(JobPicture& picture) {
  picture.begin_pass();
  return {picture.plan(), CellList(picture.collector().missing())};
}

}  // namespace

struct SimJob::Ledger {
  Ledger(const JobOptions& options, std::uint32_t keeper)
      : memory(std::as_writable_bytes(std::span(words)), options.link, options.stops, keeper) {}

  std::array<std::uint64_t, WindowLayout::shared_words> words{};
  SimMemory memory;
};

struct SimJob::Rank {
  Rank(SimJob& job, std::uint32_t which)
      : number(which),
        window(job.memory_, which, clock, job.options_.host),
        team(job.plan(), job.costs_, job.map_, clock, stops_of(which, job.options_.stops),
             team_options(job.options_, which)),
        source(job.job_, job.pass_, job.layout_, window, window_options(job.options_, which),
               reach_ledgers(job)),
        watched(source, team),
        runner(watched, team, clock) {}

  LedgerWindows reach_ledgers(SimJob& job) {
    std::vector<Window*> windows;
    if (job.kept_.empty()) windows.push_back(&window);
    for (const auto& ledger : job.kept_) {
      ledgers.push_back(
          std::make_unique<SimWindow>(ledger->memory, number, clock, job.options_.host));
      windows.push_back(ledgers.back().get());
    }
    return {job.ledgers_, std::move(windows)};
  }

  const std::uint32_t number;
  RankClock clock;
  SimWindow window;
  std::vector<std::unique_ptr<SimWindow>> ledgers;
  SimCellTeam team;
  WindowSource source;
  WatchedSource watched;
  LeaseRunner runner;
};

SimJob::SimJob(const JobOptions& options)
    : options_(options),
      picture_(options.settings, SceneFacts(Scene())),
      pass_(begin_pass(picture_)),
      layout_(*plan().grid(), options.ranks),
      words_((layout_.bytes() + 7) / 8),
      memory_(std::as_writable_bytes(std::span(words_)), options_.link, options_.stops),
      ledgers_(options.ranks, options.ledger_ranks),
      coordinator_window_(memory_, 0, coordinator_clock_, options_.host),
      judge_(picture_, rank_voices(std::vector<std::string>(options.ranks, "one host")), {}),
      collector_(picture_, judge_, layout_, coordinator_window_, std::as_bytes(std::span(words_)),
                 Time(0), totals_, {},
                 {.own = options.threads, .all = options.threads * options.ranks}),
      costs_(cell_costs(plan(), options.row_seconds, options.cell_noise, options.seed)),
      map_{std::vector<bool>(plan().cells()), Time(0)},
      work_(std::accumulate(costs_.begin(), costs_.end(), 0.0)),
      ready_(ready_seconds(options)) {
  for (std::uint32_t ledger = 0; ledgers_.count() > 1 && ledger < ledgers_.count(); ++ledger) {
    kept_.push_back(std::make_unique<Ledger>(options_, ledgers_.keeper(ledger)));
  }
  for (std::uint32_t rank = 0; rank < options.ranks; ++rank) {
    ranks_.push_back(std::make_unique<Rank>(*this, rank));
    schedule(rank, to_time(ready_));
  }
}

SimJob::~SimJob() = default;

/// When a rank that is stopped at `at` goes on.
Time SimJob::running_again(std::uint32_t rank, Time at) const {
  for (const Stop& stop : options_.stops) {
    if (stop.rank == rank && stop.begin <= at && at < stop.end) at = stop.end;
  }
  return at;
}

void SimJob::schedule(std::uint32_t rank, Time at) {
  at = running_again(rank, at);
  if (at != never) events_.push({at, events_scheduled_++, rank});
}

bool SimJob::run() {
  while (!collector_.done() && !events_.empty() && events_.top().at < options_.give_up) {
    const Event event = events_.top();
    events_.pop();
    const Time again = running_again(event.rank, event.at);
    if (again != event.at) {
      schedule(event.rank, again);
      continue;
    }
    memory_.settle(event.at);
    if (event.order % events_until_settled == 0) {
      for (const auto& ledger : kept_) ledger->memory.settle(event.at);
    }
    end_ = event.at;
    turn(*ranks_[event.rank], event.at);
  }
  for (const auto& rank : ranks_) spent_.push_back(rank->team.finish(end_));
  return collector_.done();
}

/// What parray-mpi's loops do between two waits.
void SimJob::turn(Rank& rank, Time now) {
  rank.clock.set(now);
  if (rank.number == 0) {
    coordinate(rank);
    if (collector_.done()) {
      end_ = rank.clock.now();
      return;
    }
  }
  if (rank.number == 0 && rank.runner.idle() && collector_.wants_all_threads(now)) {
    memory_.occupy(rank.clock.now());
    schedule(0,
             std::max(rank.clock.now() + (collector_.behind() ? Time(0) : poll), now + Time(1000)));
    return;
  }
  const Time begin = rank.clock.now();
  const Time due = rank.runner.tick(begin);
  rank.team.share_core(begin, rank.clock.now(), SimCellTeam::Other::leases);
  if (rank.runner.over()) return;
  Time next = std::min(due, rank.team.due());
  if (rank.number == 0) {
    memory_.occupy(rank.clock.now());
    next = std::min(next, rank.clock.now() + poll);
  }
  schedule(rank.number, std::max({next, rank.clock.now(), now + Time(1000)}));
}

/// Rank 0 takes in what has come.
void SimJob::coordinate(Rank& rank) {
  const Time now = rank.clock.now();
  const WindowCollector::Totals before = totals_;
  const std::uint64_t cells_before = picture_.collector().done_cells();
  coordinator_clock_.set(now);
  collector_.collect(now, most_cells_a_turn);
  const auto entries = static_cast<double>(totals_.entries - before.entries);
  const auto cells = static_cast<double>(picture_.collector().done_cells() - cells_before +
                                         totals_.duplicates - before.duplicates);
  coordinator_clock_.advance(
      options_.ranks * options_.host.look +
      (entries * options_.host.collect_entry + cells * options_.host.collect_cell) /
          collector_.merging_threads());
  collector_.issue_copies(now);
  if (now >= next_look_) {
    next_look_ = now + look_interval;
    collector_.listen(now);
  }
  rank.clock.set(coordinator_clock_.now());
  rank.team.share_core(now, rank.clock.now(), SimCellTeam::Other::coordinator,
                       collector_.merging_threads());
}

double SimJob::cores() const {
  double speeds = options_.ranks;
  if (!options_.speeds.empty()) {
    speeds = std::accumulate(options_.speeds.begin(), options_.speeds.end(), 0.0);
  }
  return speeds * options_.threads;
}

Floors SimJob::floors() const {
  using Core = std::pair<double, double>;  // free at; its speed
  std::priority_queue<Core, std::vector<Core>, std::greater<>> cores;
  for (const auto& rank : ranks_) {
    for (std::uint32_t thread = 0; thread < options_.threads; ++thread) {
      cores.emplace(0, rank->team.speed());
    }
  }
  Floors floors;
  for (const double cost : costs_) {
    const auto [begin, speed] = cores.top();
    cores.pop();
    cores.emplace(begin + cost / speed, speed);
    floors.cells = std::max(floors.cells, begin + cost / speed);
  }
  const auto cells = static_cast<double>(plan().cells());
  floors.rank_0 = cells * options_.host.collect_cell / options_.threads;
  floors.link = cells * static_cast<double>(layout_.record_bytes()) * (options_.ranks - 1) /
                options_.ranks / options_.link.bytes_per_second;
  return floors;
}

Spent SimJob::spent_together() const {
  Spent sum;
  for (std::size_t rank = 0; rank < spent_.size(); ++rank) {
    sum += ranks_[rank]->team.speed() * spent_[rank];
  }
  return sum;
}

double SimJob::normalized_seconds(std::uint32_t rank) const {
  return tally(rank).busy / (seconds() - start_seconds());
}

const WorkTally& SimJob::tally(std::uint32_t rank) const { return ranks_[rank]->runner.tally(); }

}  // namespace parray::simulation
