#include "worker/rank_worker.h"

#include <algorithm>

namespace parray {
namespace {

/// Of one result: what one put carries, and what a rank keeps in memory.
constexpr std::size_t most_slice_bytes = std::size_t{1} << 25;
/// Seconds of one slice: how often a long lease shows progress.
constexpr double slice_seconds = 0.5;
/// Samples of a slice while the speed is unknown.
constexpr double first_slice_samples = 1e6;

constexpr Time beat_interval = milliseconds(250);
constexpr Time shortest_wait = std::chrono::microseconds(500);
constexpr Time longest_wait = milliseconds(5);

}  // namespace

RankWorker::RankWorker(const WorkPlan& plan, LeaseSource& leases, CellTeam& team,
                       const Clock& clock, const RankTally& before)
    : plan_(plan), leases_(leases), team_(team), clock_(clock), tally_(before) {
  if (before.samples > 0 && before.busy > 0) {
    samples_per_second_ = static_cast<double>(before.samples) / before.busy;
  }
}

Time RankWorker::tick(Time now) {
  hand_in();
  keep_at_work(now);
  beat(now);
  return slices_.empty() && !over_ ? std::min(take_at_, next_beat_) : next_beat_;
}

void RankWorker::keep_at_work(Time now) {
  start_next(now);
  if (!over_ && slices_.empty() && (take_at_ <= now || (!tracing_ && wait_ == Time(0)))) {
    take(now);
    start_next(now);
  }
}

void RankWorker::hand_in() {
  const auto traced = team_.take();
  if (!traced) {
    return;
  }
  tracing_ = false;
  if (traced->seconds > 0 && traced->samples > 0) {
    const double speed = static_cast<double>(traced->samples) / traced->seconds;
    samples_per_second_ = samples_per_second_ > 0 ? (samples_per_second_ + speed) / 2 : speed;
  }
  tally_.busy += traced->seconds;
  tally_.samples += traced->samples;
  // The team goes on while the result travels.
  keep_at_work(clock_.now());
  const Time begin = clock_.now();
  leases_.complete(traced->range, traced->records);
  tally_.putting += clock_.now() - begin;
}

void RankWorker::start_next(Time now) {
  if (slices_.empty() || team_.busy()) {
    return;
  }
  const CellRange slice = slices_.front();
  slices_.pop_front();
  team_.start(slice);
  tracing_ = true;
  take_at_ = now;
  if (slices_.empty()) {
    // Taken too early, a lease would be work that nobody does; too late, the team would wait.
    const auto takes = static_cast<Time::rep>(std::max<std::uint64_t>(tally_.takes, 1));
    const Time lead = 2 * tally_.taking / takes + std::chrono::microseconds(200);
    const std::chrono::duration<double> length(
        samples_per_second_ > 0 ? samples_of(slice) / samples_per_second_ : 1e9);
    take_at_ = now + std::chrono::duration_cast<Time>(length) - lead;
  }
}

void RankWorker::take(Time now) {
  const auto taken = leases_.take(samples_per_second_, !tracing_);
  if (taken.answer == LeaseSource::Answer::over) {
    over_ = true;
    return;
  }
  if (taken.answer == LeaseSource::Answer::wait) {
    // While the team is at work there is no hurry: hand_in() asks again.
    wait_ = tracing_ ? Time(0) : std::clamp(2 * wait_, shortest_wait, longest_wait);
    take_at_ = tracing_ ? never : now + wait_;
    return;
  }
  wait_ = Time(0);
  ++tally_.takes;
  tally_.taking += clock_.now() - now;
  const double samples =
      samples_per_second_ > 0 ? samples_per_second_ * slice_seconds : first_slice_samples;
  const auto by_time = static_cast<std::uint64_t>(samples / plan_.cell_samples());
  const std::uint64_t most = std::clamp<std::uint64_t>(
      std::min<std::uint64_t>(by_time, most_slice_bytes / record_bytes_of(plan_)), 1,
      most_cells_in_word);
  const std::uint64_t count = taken.range.count();
  const std::uint64_t parts = (count + most - 1) / most;
  for (std::uint64_t part = 0; part < parts; ++part) {  // of equal length
    slices_.push_back(
        {taken.range.begin + count * part / parts, taken.range.begin + count * (part + 1) / parts});
  }
}

void RankWorker::beat(Time now) {
  if (now < next_beat_) {
    return;
  }
  next_beat_ = now + beat_interval;
  leases_.tell(WindowLayout::beat, team_.traced() | (tracing_ ? beat_flags::tracing : 0) |
                                       (team_.building() ? beat_flags::building : 0));
}

void RankWorker::stop() {
  slices_.clear();
  team_.abandon();
  tracing_ = false;
  over_ = true;
}

void RankWorker::report() {
  leases_.tell(WindowLayout::samples, tally_.samples);
  leases_.tell(WindowLayout::busy, static_cast<std::uint64_t>(tally_.busy * 1e9));
  leases_.tell(WindowLayout::takes, tally_.takes);
  leases_.tell(WindowLayout::taking, static_cast<std::uint64_t>(tally_.taking.count()));
  leases_.tell(WindowLayout::putting, static_cast<std::uint64_t>(tally_.putting.count()));
}

double RankWorker::samples_of(const CellRange& range) const {
  return static_cast<double>(range.count()) * plan_.cell_samples();
}

}  // namespace parray
