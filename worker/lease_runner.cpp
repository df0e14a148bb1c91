#include "worker/lease_runner.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace parray::worker {
namespace {

constexpr Time shortest_wait = std::chrono::microseconds(500);
constexpr Time longest_wait = milliseconds(5);

}  // namespace

LeaseRunner::LeaseRunner(LeaseSource& source, Team& team, const Clock& clock, WorkTally before)
    : source_(source), team_(team), clock_(clock), tally_(before) {
  if (tally_.samples > 0 && tally_.busy > 0) {
    samples_per_second_ = static_cast<double>(tally_.samples) / tally_.busy;
  }
}

Time LeaseRunner::tick(Time now) {
  drop_unwanted();
  hand_in();
  keep_at_work(now, true);
  const Time due = source_.tick(now, {team_.traced(), tracing_.has_value(), team_.preparing()});
  return next_ || over_ ? due : std::min(take_at_, due);
}

void LeaseRunner::stop() {
  next_.reset();
  team_.abandon();
  tracing_.reset();
  over_ = true;
  source_.report(tally_);
}

void LeaseRunner::drop_unwanted() {
  if (next_ && !source_.wants(next_->lease.key())) next_.reset();
  if (tracing_ && !source_.wants(*tracing_)) {
    team_.abandon();
    tracing_.reset();
  }
}

void LeaseRunner::keep_at_work(Time now, bool copies) {
  start_next(now);
  if (!over_ && !next_ && (take_at_ <= now || (!tracing_ && wait_ == Time(0)))) {
    take(now, !tracing_ && copies);
    start_next(now);
  }
}

void LeaseRunner::hand_in() {
  auto finished = team_.take();
  if (!finished || !tracing_) return;
  tracing_.reset();
  note(*finished);
  // The team continues while the result travels. Copies of other workers' leases are not worth a
  // delay of the result.
  keep_at_work(clock_.now(), false);
  const Time begin = clock_.now();
  source_.complete(begin, std::move(*finished));
  tally_.putting += clock_.now() - begin;
  keep_at_work(clock_.now(), true);
}

void LeaseRunner::note(const LeaseResult& finished) {
  if (!finished.cells) return;
  const TracedCells& cells = *finished.cells;
  if (cells.seconds > 0 && cells.samples > 0) {
    const double speed = static_cast<double>(cells.samples) / cells.seconds;
    samples_per_second_ = samples_per_second_ > 0 ? (samples_per_second_ + speed) / 2 : speed;
  }
  tally_.busy += cells.seconds;
  tally_.samples += cells.samples;
  tally_.build_seconds = finished.build_seconds;
  tally_.accelerator_bytes = finished.accelerator_bytes;
}

void LeaseRunner::start_next(Time now) {
  if (!next_ || !team_.idle()) return;
  LeaseSource::Taken taken = std::move(*next_);
  next_.reset();
  tracing_ = taken.lease.key();
  team_.start(std::move(taken.lease));
  take_at_ = never;
  if (taken.samples > 0 && samples_per_second_ > 0) {
    // A lease taken too early would block work that another worker could do. A lease taken too late
    // would make the team wait.
    const auto leases = static_cast<Time::rep>(std::max<std::uint64_t>(tally_.leases, 1));
    const Time lead = 2 * tally_.taking / leases + std::chrono::microseconds(200);
    const std::chrono::duration<double> length(taken.samples / samples_per_second_);
    take_at_ = now + std::chrono::duration_cast<Time>(length) - lead;
  }
}

void LeaseRunner::take(Time now, bool idle) {
  LeaseSource::Taken taken = source_.take(now, samples_per_second_, idle);
  wait_ = taken.answer == LeaseSource::Answer::wait && idle
              ? std::clamp(2 * wait_, shortest_wait, longest_wait)
              : Time(0);
  // While the team works, there is no hurry: hand_in() asks again.
  take_at_ = wait_ > Time(0) ? now + wait_ : never;
  over_ = taken.answer == LeaseSource::Answer::over;
  if (taken.answer != LeaseSource::Answer::lease) return;
  if (taken.fresh) {
    ++tally_.leases;
    tally_.taking += clock_.now() - now;
  }
  next_ = std::move(taken);
}

}  // namespace parray::worker
