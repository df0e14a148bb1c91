#include "cli/mpi/mpi_coordinator.h"

#include <sys/prctl.h>

#include <algorithm>
#include <iostream>

#include "cli/interrupt.h"
#include "cli/text.h"
#include "common/base/error.h"

namespace parray {
namespace {

/// How often rank 0 looks. Where MPI needs the target's help, or ranks wait for answers, one
/// request follows another, so after each it looks often for a while; looking costs its own team
/// time.
constexpr Time calm_poll = milliseconds(1);
constexpr Time eager_poll = std::chrono::microseconds(50);
constexpr Time eager_time = milliseconds(2);

constexpr Time look_interval = milliseconds(50);

/// Of results in one turn, so that a turn stays short.
constexpr std::uint64_t most_cells_a_turn = 4096;

}  // namespace

MpiCoordinator::MpiCoordinator(const MpiWorld& world, KeptJob& kept, const WorkPlan& plan,
                               const WindowLayout& layout, Transport& transport,
                               std::vector<std::unique_ptr<WindowLeases>>& leases,
                               ThreadCellTeam& team, WindowLedger::Locate locate,
                               const Options& options)
    : world_(world),
      kept_(kept),
      plan_(plan),
      transport_(transport),
      team_(team),
      options_(options),
      ledger_(plan, layout, *transport.window(), transport.memory(), kept.job().work->framebuffer,
              clock_.now(), std::move(locate)),
      worker_(plan, *leases.at(0), team, clock_),
      progress_(progress_style(options.quiet), std::cerr, terminal_columns()),
      asked_for_help_(transport.by_messages() || !world.one_machine()),
      started_(clock_.now()),
      next_checkpoint_(started_ + options.checkpoint) {
  if (asked_for_help_) {
    prctl(PR_SET_TIMERSLACK, 1000);  // or 50 us of sleep would be 110
  }
  if (transport.by_messages()) {
    server_ = std::make_unique<MessageServer>(world.comm(), layout, transport.memory(), leases);
  }
}

void MpiCoordinator::run(const std::function<void()>& pet) {
  kept_.job().work->started = started_;
  while (!ledger_.done()) {
    const Time now = clock_.now();
    try {
      check_interrupted();
    } catch (const Interrupted&) {
      keep_all_rows();
      throw Interrupted("interrupted, perhaps because another rank ended: " + kept_text());
    }
    pet();
    take_turn(now);
    const Time due = worker_.tick(clock_.now());
    const Time poll = clock_.now() < eager_until_ ? eager_poll : calm_poll;
    team_.wait(std::clamp(due - clock_.now(), Time(0), poll));
  }
  finished_ = clock_.now();
  progress_.show(finished_, status(finished_));
  ledger_.finish();
  worker_.stop();
  worker_.report();
}

void MpiCoordinator::take_turn(Time now) {
  transport_.progress();
  if (server_) {
    server_->poll();
  }
  if (const std::uint64_t activity = ledger_.activity();
      asked_for_help_ && activity != last_activity_) {
    last_activity_ = activity;
    eager_until_ = now + eager_time;
  }
  ledger_.collect(now, most_cells_a_turn);
  ledger_.issue_copies(now);
  if (now >= next_look_) {
    next_look_ = now + look_interval;
    look_after_ranks(now);
  }
}

void MpiCoordinator::look_after_ranks(Time now) {
  progress_.show(now, status(now));
  ledger_.listen(now);
  if (now - ledger_.last_sign_of_life() >= options_.patience) {
    give_up(now);
  }
  if (now >= next_checkpoint_) {
    keep_some_rows(now);
  }
}

/// A block a turn, because other ranks may need rank 0 meanwhile. A slow disk is asked less often,
/// so that it takes a tenth of the time at most.
void MpiCoordinator::keep_some_rows(Time now) {
  if (const auto block = ledger_.take_finished_rows()) {
    kept_.keep(*block);
    keeping_ += clock_.now() - now;
    return;
  }
  next_checkpoint_ = now + std::max(options_.checkpoint, 10 * keeping_);
  keeping_ = Time(0);
}

void MpiCoordinator::keep_all_rows() {
  while (const auto block = ledger_.take_finished_rows()) {
    kept_.keep(*block);
  }
}

std::string MpiCoordinator::kept_text() const {
  const double before = kept_.taken_up();
  const double done = before + (1 - before) * ledger_.complete_rows();
  return formatted("%.1f", 100 * done) + " % is kept in " + kept_.directory().string() +
         ": the same command goes on from there, with any number of ranks";
}

void MpiCoordinator::give_up(Time now) {
  keep_all_rows();
  std::string silent;
  for (const std::uint32_t rank : ledger_.silent_ranks(now, options_.patience)) {
    silent += (silent.empty() ? "" : ", ") + std::to_string(rank);
  }
  throw RunError("no rank has got on for " + duration_text(to_seconds(options_.patience)) +
                 (silent.empty() ? "" : "; at work and silent: " + silent) + "; " + kept_text());
}

JobStatus MpiCoordinator::status(Time now) const {
  const JobRecord& record = kept_.job().record;
  JobStatus status;
  status.id = record.id;
  status.name = record.name;
  status.state = name_of(ledger_.done() ? JobState::done : JobState::running);
  const double done = ledger_.progress();
  const double before = kept_.taken_up();
  status.progress = before + (1 - before) * done;
  const double elapsed = to_seconds(now - started_);
  if (done > 0 && elapsed > 0) {
    status.samples_per_second = done * static_cast<double>(plan_.samples()) / elapsed;
    status.seconds_left = elapsed * (1 - done) / done;
  }
  return status;
}

bool MpiCoordinator::gather_ranks(Time patience, const std::function<void()>& pet) {
  return world_.meet(patience, [this, &pet] {
    pet();
    transport_.progress();
    if (server_) {
      server_->poll();
    }
  });
}

}  // namespace parray
