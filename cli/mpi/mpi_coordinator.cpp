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

MpiCoordinator::Pass::Pass(MpiCoordinator& own, const WorkPlan& its_plan,
                           const WindowLayout& layout, Transport& its_transport,
                           std::vector<std::unique_ptr<WindowLeases>>& leases)
    : plan(its_plan),
      transport(its_transport),
      ledger(plan, layout, *transport.window(), transport.memory(),
             own.kept_.job().work->framebuffer, own.clock_.now(), own.locate_),
      worker(plan, *leases.at(0), own.team_, own.clock_,
             own.pass_ ? own.pass_->worker.tally() : RankTally{}) {
  if (own.pass_) {
    ledger.go_on_from(own.pass_->ledger);
  }
  if (transport.by_messages()) {
    server = std::make_unique<MessageServer>(own.world_.comm(), layout, transport.memory(), leases);
  }
}

MpiCoordinator::MpiCoordinator(const MpiWorld& world, KeptJob& kept, ThreadCellTeam& team,
                               WindowLedger::Locate locate, std::function<void()> pet,
                               const Options& options)
    : world_(world),
      kept_(kept),
      team_(team),
      locate_(std::move(locate)),
      pet_(std::move(pet)),
      options_(options),
      progress_(progress_style(options.following.quiet), std::cerr, terminal_columns()),
      preview_(options.following.preview,
               [this] {
                 stop_if_interrupted();
                 stay_alive();
               }),
      started_(clock_.now()),
      samples_before_(kept.job().work->framebuffer.counts().samples),
      next_checkpoint_(started_ + options.checkpoint) {
  kept_.job().work->started = started_;
  kept_.job().work->pass_began = started_;
}

bool MpiCoordinator::run_pass(const WorkPlan& plan, const WindowLayout& layout,
                              Transport& transport,
                              std::vector<std::unique_ptr<WindowLeases>>& leases) {
  pass_ = std::make_unique<Pass>(*this, plan, layout, transport, leases);
  last_activity_ = 0;
  asked_for_help_ = transport.by_messages() || !world_.one_machine();
  if (asked_for_help_) {
    prctl(PR_SET_TIMERSLACK, 1000);  // or 50 us of sleep would be 110
  }
  while (!pass_->ledger.done()) {
    stop_if_interrupted();
    pet_();
    take_turn(clock_.now());
    const Time due = pass_->worker.tick(clock_.now());
    const Time poll = clock_.now() < eager_until_ ? eager_poll : calm_poll;
    team_.wait(std::clamp(due - clock_.now(), Time(0), poll));
  }
  return end_pass();
}

/// Others only wait for leases meanwhile, and see that rank 0 is alive.
bool MpiCoordinator::end_pass() {
  WindowLedger& ledger = pass_->ledger;
  const bool goes_on = kept_.next_pass(clock_.now());
  while (goes_on) {
    const auto block = ledger.take_finished_rows();
    if (!block) {
      break;
    }
    kept_.keep(*block);
    stop_if_interrupted();
    stay_alive();
  }
  if (ledger.rows_left_out() > 0) {
    kept_.keep_no_more();
  }
  finished_ = clock_.now();
  progress_.show(finished_, status(finished_, !goes_on));
  ledger.finish();
  pass_->worker.stop();
  pass_->worker.report();
  return goes_on;
}

void MpiCoordinator::stop_if_interrupted() {
  try {
    check_interrupted();
  } catch (const Interrupted&) {
    keep_all_rows();
    throw Interrupted("interrupted, perhaps because another rank ended: " + kept_text());
  }
}

/// Lets other ranks get on.
void MpiCoordinator::serve() {
  pass_->transport.progress();
  if (pass_->server) {
    pass_->server->poll();
  }
}

/// While rank 0 does something else than its share of the work.
void MpiCoordinator::stay_alive() {
  pet_();
  serve();
  pass_->ledger.listen(clock_.now());
}

void MpiCoordinator::take_turn(Time now) {
  WindowLedger& ledger = pass_->ledger;
  serve();
  if (const std::uint64_t activity = ledger.activity();
      asked_for_help_ && activity != last_activity_) {
    last_activity_ = activity;
    eager_until_ = now + eager_time;
  }
  ledger.collect(now, most_cells_a_turn);
  ledger.issue_copies(now);
  if (now >= next_look_) {
    next_look_ = now + look_interval;
    look_after_ranks(now);
  }
}

void MpiCoordinator::look_after_ranks(Time now) {
  const JobStatus so_far = status(now, false);
  progress_.show(now, so_far);
  preview_.follow(now, so_far, [this] {
    const JobWork& work = *kept_.job().work;
    return resolve_image(work.framebuffer, work.largest_radiance);
  });
  pass_->ledger.listen(now);
  if (now - pass_->ledger.last_sign_of_life() >= options_.patience) {
    give_up(now);
  }
  if (now >= next_checkpoint_) {
    keep_some_rows(now);
  }
}

/// A block a turn, because other ranks may need rank 0 meanwhile. A slow disk is asked less often,
/// so that it takes a tenth of the time at most.
void MpiCoordinator::keep_some_rows(Time now) {
  if (const auto block = pass_->ledger.take_finished_rows()) {
    kept_.keep(*block);
    kept_.commit();
    keeping_ += clock_.now() - now;
    return;
  }
  kept_.commit();  // rows of earlier passes
  next_checkpoint_ = now + std::max(options_.checkpoint, 10 * keeping_);
  keeping_ = Time(0);
}

void MpiCoordinator::keep_all_rows() {
  while (const auto block = pass_->ledger.take_finished_rows()) {
    kept_.keep(*block);
  }
  kept_.commit();
}

std::string MpiCoordinator::kept_text() const {
  const double before = kept_.taken_up();
  const double done = before + (1 - before) * pass_->ledger.complete_rows();
  return kept_.amount_text(done) + (kept_.job().record.settings.in_passes() ? " are" : " is") +
         " kept in " + kept_.directory().string() +
         ": the same command goes on from there, with any number of ranks";
}

void MpiCoordinator::give_up(Time now) {
  keep_all_rows();
  std::string silent;
  for (const std::uint32_t rank : pass_->ledger.silent_ranks(now, options_.patience)) {
    silent += (silent.empty() ? "" : ", ") + std::to_string(rank);
  }
  throw RunError("no rank has got on for " + duration_text(to_seconds(options_.patience)) +
                 (silent.empty() ? "" : "; at work and silent: " + silent) + "; " + kept_text());
}

JobStatus MpiCoordinator::status(Time now, bool done) const {
  const Job& job = kept_.job();
  const bool in_passes = job.record.settings.in_passes();
  const double share = pass_->ledger.progress();
  const double before = kept_.taken_up();
  const double progress = in_passes ? job.progress(now) : before + (1 - before) * share;
  const double elapsed = to_seconds(now - started_);
  JobStatus status;
  status.id = job.record.id;
  status.name = job.record.name;
  status.state = name_of(done ? JobState::done : JobState::running);
  status.progress = done ? 1 : progress;
  status.whole = preview_.wanted() && job.whole();
  if (progress > before && elapsed > 0) {
    const std::uint64_t merged = job.work->framebuffer.counts().samples - samples_before_;
    status.samples_per_second = (in_passes ? static_cast<double>(merged)
                                           : share * static_cast<double>(pass_->plan.samples())) /
                                elapsed;
    status.seconds_left = elapsed * (1 - progress) / (progress - before);
  }
  return status;
}

void MpiCoordinator::meet_ranks() {
  const bool met = world_.meet(options_.patience, [this] {
    stop_if_interrupted();
    stay_alive();
  });
  if (!met) {
    give_up(clock_.now());
  }
}

bool MpiCoordinator::gather_ranks(Time patience) {
  return world_.meet(patience, [this] { stay_alive(); });
}

}  // namespace parray
