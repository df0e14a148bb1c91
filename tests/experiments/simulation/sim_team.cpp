#include "tests/experiments/simulation/sim_team.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <numeric>
#include <queue>
#include <random>

#include "tests/support/rooms.h"

namespace parray::simulation {

std::vector<double> cell_costs(const WorkPlan& plan, const std::vector<double>& row_seconds,
                               double noise, std::uint64_t seed) {
  std::vector<double> costs(plan.cells());
  std::vector<double> weights(row_seconds.size());
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  for (std::uint64_t i = 0; i < plan.cells(); ++i) {
    const Cell cell = plan.cell(i);
    const double samples = static_cast<double>(cell.pixels()) * cell.samples.count();
    costs[i] = samples * std::exp(noise * normal(engine));
    weights[cell.y] += costs[i];
  }
  for (std::uint64_t i = 0; i < plan.cells(); ++i) {
    const std::uint32_t row = plan.cell(i).y;
    costs[i] *= row_seconds[row] / weights[row];
  }
  return costs;
}

SimCellTeam::SimCellTeam(const WorkPlan& plan, const std::vector<double>& costs, TracedMap& map,
                         const Clock& clock, std::vector<Stop> stops, const Options& options)
    : plan_(plan),
      costs_(costs),
      map_(map),
      clock_(clock),
      stops_(std::move(stops)),
      options_(options),
      idle_since_(to_time(options.ready)) {
  spent_.start = options_.threads * options_.ready;
}

/// The next piece goes to the thread that is free first.
SimCellTeam::Dealt SimCellTeam::deal(const CellRange& range) const {
  const std::uint64_t piece = plan_.grid()->shape().piece_cells;
  std::priority_queue<double, std::vector<double>, std::greater<>> free_at;
  for (std::uint32_t thread = 0; thread < options_.threads; ++thread) free_at.push(0);
  const auto cost = [this](std::uint64_t i) {
    return costs_.begin() + static_cast<std::ptrdiff_t>(i);
  };
  Dealt dealt;
  for (std::uint64_t begin = range.begin; begin < range.end; begin += piece) {
    const double seconds =
        std::accumulate(cost(begin), cost(std::min(begin + piece, range.end)), 0.0) /
        options_.speed;
    const double done = free_at.top() + seconds;
    free_at.pop();
    free_at.push(done);
    dealt.length = std::max(dealt.length, done);
    dealt.work += seconds;
  }
  return dealt;
}

double SimCellTeam::stopped_seconds(Time begin, Time end) const {
  double seconds = 0;
  for (const Stop& stop : stops_) {
    seconds += std::max(0.0, to_seconds(std::min(end, stop.end) - std::max(begin, stop.begin)));
  }
  return seconds;
}

void SimCellTeam::set_due() {
  due_ = built_at_ + to_time(dealt_.length) + for_leases_ + for_coordinator_;
  for (const Stop& stop : stops_) {
    if (stop.end > begun_ && stop.begin < due_) {
      due_ = stop.end == never ? never : due_ + (stop.end - std::max(stop.begin, begun_));
    }
    if (due_ == never) return;
  }
}

void SimCellTeam::start(LeaseWork assignment) {
  begun_ = clock_.now();
  gaps_.push_back({idle_since_, begun_, waiting_});
  dealt_ = deal(assignment.cells.range);
  lease_ = std::move(assignment);
  build_ = built_ ? 0 : options_.build;
  built_ = true;
  built_at_ = begun_ + to_time(options_.hand_over + build_);
  for_leases_ = for_coordinator_ = Time(0);
  set_due();
}

void SimCellTeam::share_core(Time begin, Time end, Other what, std::uint32_t cores) {
  begin = std::max(begin, begun_);
  if (!lease_ || due_ == never || begin >= std::min(end, due_)) return;
  // Where no core is left the two take turns; else the threads have the other cores.
  const double rate =
      options_.threads > cores ? 1 - static_cast<double>(cores) / options_.threads : 0.5;
  const double delay =
      std::min(to_seconds(end - begin) * (1 - rate), to_seconds(due_ - begin) * (1 / rate - 1));
  (what == Other::leases ? for_leases_ : for_coordinator_) += to_time(delay);
  set_due();
}

std::optional<LeaseResult> SimCellTeam::take() {
  if (!lease_ || clock_.now() < due_) return {};
  const LeaseWork lease = *std::exchange(lease_, std::nullopt);
  const CellRange& range = lease.cells.range;
  const std::size_t size = record_bytes(plan_.grid()->shape().cell_pixels);
  TracedCells traced;
  traced.range = range;
  traced.records.resize(range.count() * size);
  traced.samples = lease.cells.sample_count();
  const CellHeader header{1, 0, 0};  // one ray a cell: the picture shows how often it came
  double again = 0;
  for (std::uint64_t i = range.begin; i < range.end; ++i) {
    std::memcpy(traced.records.data() + (i - range.begin) * size, &header, sizeof header);
    again += map_.cells[i] ? costs_[i] / options_.speed : 0;
    if (!map_.cells[i]) {
      map_.cells[i] = true;
      map_.last = std::max(map_.last, due_);
    }
  }
  traced.seconds = to_seconds(due_ - built_at_);
  const double threads = options_.threads;
  spent_.start += threads * build_;
  spent_.leases += threads * (options_.hand_over + to_seconds(for_leases_));
  spent_.coordinator += threads * to_seconds(for_coordinator_);
  spent_.useful += dealt_.work - again;
  spent_.tail += again;
  spent_.inner += threads * dealt_.length - dealt_.work;
  spent_.faults += threads * stopped_seconds(begun_, due_);
  samples_ += traced.samples;
  idle_since_ = due_;
  LeaseResult finished;
  finished.job = lease.job;
  finished.epoch = lease.epoch;
  finished.cells = std::make_shared<const TracedCells>(std::move(traced));
  finished.grid = plan_.grid();
  return finished;
}

std::uint64_t SimCellTeam::traced() const {
  const Time now = std::min(clock_.now(), due_);
  if (!lease_ || now <= built_at_) return samples_;
  const double cells = to_seconds(now - built_at_) / std::max(dealt_.length, 1e-9) *
                       static_cast<double>(lease_->cells.range.count());
  return samples_ + static_cast<std::uint64_t>(cells * plan_.cell_samples());
}

Spent SimCellTeam::finish(Time end) {
  if (lease_ && begun_ < end) {
    give_up_lease(end);
  } else if (!lease_) {
    gaps_.push_back({idle_since_, end, true});
  }
  for (Gap gap : gaps_) {
    gap.end = std::min(gap.end, end);  // a turn may have gone on beyond it
    close(gap);
  }
  return spent_;
}

/// The lease at hand was traced in vain: somebody else was faster, or this rank is dead.
void SimCellTeam::give_up_lease(Time end) {
  const double threads = options_.threads;
  const double length = to_seconds(end - begun_);
  if (due_ == never) {
    spent_.faults += threads * length;
    return;
  }
  const double stopped = stopped_seconds(begun_, end);
  const double leases = to_seconds(for_leases_);
  const double coordinator = to_seconds(for_coordinator_);
  spent_.faults += threads * stopped;
  spent_.leases += threads * leases;
  spent_.coordinator += threads * coordinator;
  spent_.tail += threads * (length - stopped - leases - coordinator);
}

void SimCellTeam::close(const Gap& gap) {
  const double threads = options_.threads;
  const auto running = [this](Time begin, Time end) {
    return std::max(0.0, to_seconds(end - begin)) - stopped_seconds(begin, end);
  };
  spent_.faults += threads * stopped_seconds(gap.begin, gap.end);
  if (!gap.nothing_left) {
    spent_.leases += threads * running(gap.begin, gap.end);
    return;
  }
  const Time split = std::clamp(map_.last, gap.begin, std::max(gap.begin, gap.end));
  spent_.imbalance += threads * running(gap.begin, split);
  spent_.ending += threads * running(split, gap.end);
}

}  // namespace parray::simulation
