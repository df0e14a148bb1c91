#include "cli/mpi/mpi_coordinator.h"

#include <sys/prctl.h>

#include <algorithm>
#include <iostream>

#include "cli/output/text.h"
#include "common/base/error.h"
#include "common/process/stop_signal.h"
#include "common/scene/settings.h"

namespace parray::mpi {
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

void PassResources::begin(RankPass next, Transport& transport, const Ranks& ranks, RankJob& job) {
  source.reset();
  pass = std::move(next);
  layout.emplace(*pass.plan->grid(), ranks.count);
  transport.begin_pass(*layout);
  source.emplace(job, pass, *layout, transport.window(), ranks.own, transport.ledgers());
}

MpiCoordinator::Pass::Pass(MpiCoordinator& own, PassResources& resources, Transport& its_transport)
    : transport(its_transport),
      collector(own.job_.picture(), own.judge_, *resources.layout, transport.window(),
                transport.memory(), own.clock_.now(), own.totals_,
                {own.options_.locate,
                 [&own](TracerKey tracer, TracedCells cells) {
                   own.job_.keep(tracer, std::move(cells));
                 }},
                {.own = own.options_.threads, .all = own.options_.all_threads}),
      runner(*resources.source, own.team_, own.clock_,
             own.pass_ ? own.pass_->runner.tally() : WorkTally{}) {}

MpiCoordinator::MpiCoordinator(const MpiWorld& world, CheckpointedJob& job, ThreadTeam& team,
                               Options options)
    : world_(world),
      job_(job),
      team_(team),
      options_(std::move(options)),
      judge_(job.picture(), rank_voices(options_.hosts),
             {.trace = options_.trace,
              .retracted = [&job](const std::vector<CellRange>& cells) { job.retract(cells); },
              .restarted = [&job] { job.restart(); },
              .decided = [this](const RankJudge::Verdict& verdict) { tell(verdict); }}),
      progress_(progress_style(options_.following.quiet, options_.following.progress), std::cerr,
                terminal_columns),
      preview_(options_.following,
               [this] {
                 stop_if_interrupted();
                 stay_alive();
               }),
      started_(clock_.now()),
      pass_began_(started_),
      finished_(started_),
      progress_before_(job.taken_up() ? job.progress(Time(0)) : 0),
      next_checkpoint_(started_ + options_.checkpoint) {}

bool MpiCoordinator::run_pass(PassResources& resources, Transport& transport) {
  pass_ = std::make_unique<Pass>(*this, resources, transport);
  pass_began_ = clock_.now();
  last_activity_ = 0;
  asked_for_help_ = transport.by_messages() || !world_.one_machine();
  if (asked_for_help_) {
    prctl(PR_SET_TIMERSLACK, 1000);  // or 50 us of sleep would be 110
  }
  while (!pass_->collector.done() && !pass_->collector.overtaken()) {
    stop_if_interrupted();
    options_.pet();
    take_turn(clock_.now());
    const WindowCollector& collector = pass_->collector;
    const bool traces = !pass_->runner.idle() || !collector.wants_all_threads(clock_.now());
    const Time due = traces ? pass_->runner.tick(clock_.now()) : never;
    const Time poll = collector.behind()            ? Time(0)
                      : clock_.now() < eager_until_ ? eager_poll
                                                    : calm_poll;
    team_.wait(std::clamp(due - clock_.now(), Time(0), poll));
  }
  return end_pass();
}

/// Others only wait for leases meanwhile, and see that rank 0 is alive.
bool MpiCoordinator::end_pass() {
  progress_.show(clock_.now(), status(clock_.now(), false));
  const Time began = clock_.now();
  const bool goes_on = job_.begin_pass(times(began));
  finished_ = clock_.now();
  deciding_seconds_ += to_seconds(finished_ - began);
  if (!goes_on) {
    progress_.show(finished_, status(finished_, true));
  }
  pass_->collector.finish();
  pass_->runner.stop();
  return goes_on;
}

PassTimes MpiCoordinator::times(Time now) const {
  const JobRecord& record = job_.record();
  PassTimes times = ending_times(record.settings, job_.picture().framebuffer().counts().samples,
                                 record.reserved_seconds + to_seconds(now - started_));
  times.pass = to_seconds(now - pass_began_);
  return times;
}

void MpiCoordinator::stop_if_interrupted() {
  try {
    check_interrupted();
  } catch (const Interrupted&) {
    job_.commit();
    throw Interrupted("interrupted, perhaps because another rank ended: " + kept_text());
  }
}

/// While rank 0 does something else than its share of the work.
void MpiCoordinator::stay_alive() {
  options_.pet();
  pass_->transport.progress();
  pass_->collector.listen(clock_.now());
}

void MpiCoordinator::take_turn(Time now) {
  WindowCollector& collector = pass_->collector;
  pass_->transport.progress();
  if (const std::uint64_t activity = collector.activity();
      asked_for_help_ && activity != last_activity_) {
    last_activity_ = activity;
    eager_until_ = now + eager_time;
  }
  collector.collect(now, most_cells_a_turn);
  if (judge_.self_doubt()) {
    give_up_judging();
  }
  collector.issue_copies(now);
  if (now >= next_look_) {
    next_look_ = now + look_interval;
    look_after_ranks(now);
  }
}

void MpiCoordinator::look_after_ranks(Time now) {
  const JobStatus so_far = status(now, false);
  progress_.show(now, so_far);
  preview_.follow(clock_, so_far, [this] { return shown_image(job_.picture()).image; });
  pass_->collector.listen(now);
  if (now - pass_->collector.last_sign_of_life() >= options_.patience) {
    give_up(now);
  }
  if (now >= next_checkpoint_ || job_.holds_much()) {
    keep_some(now);
  }
}

/// A little at each look, because other ranks may need rank 0 meanwhile. A slow disk is asked less
/// often, so that it takes a tenth of the time at most.
void MpiCoordinator::keep_some(Time now) {
  next_checkpoint_ = now;  // until nothing waits
  if (!job_.pack_some()) {
    job_.commit();
    keeping_ += clock_.now() - now;
    next_checkpoint_ = now + std::max(options_.checkpoint, 10 * std::exchange(keeping_, Time(0)));
    return;
  }
  keeping_ += clock_.now() - now;
}

std::string MpiCoordinator::kept_text() const {
  return job_.amount_text() + (job_.record().settings->in_passes() ? " are" : " is") + " kept in " +
         job_.directory().string() +
         ": the same command goes on from there, with any number of ranks";
}

/// A rank returned wrong bits: which, and what follows.
void MpiCoordinator::tell(const RankJudge::Verdict& verdict) {
  const auto name_of_rank = [this](std::uint32_t rank) {
    return "rank " + std::to_string(rank) + " on " + options_.hosts[rank];
  };
  const std::string wrong =
      (verdict.rank ? name_of_rank(*verdict.rank) : "an earlier mpirun") + " returned wrong bits: ";
  const std::string follows = verdict.restarted
                                  ? "the picture was begun again"
                                  : std::to_string(verdict.cells) + " cells were traced again";
  job_.add_flag(wrong + follows);
  progress_.make_way();
  std::string line =
      "parray-mpi: " + wrong +
      "rank 0 got different ones for the same samples. ParRay traces its cells again";
  if (verdict.left_out.size() > 1) {
    line += ", and those of all other ranks of that machine, without these ranks";
  } else if (verdict.rank) {
    line += " without it";
  }
  std::cerr << line + ". Test that machine's memory\n";
}

/// Rank 0 decides which bits are right, and nobody else can.
void MpiCoordinator::give_up_judging() {
  job_.commit();
  throw RunError("rank 0 on " + options_.hosts[0] +
                 " got other bits when it traced the same samples again, so that the picture "
                 "cannot be trusted: test that machine's memory. " +
                 kept_text() + "; begin the list of hosts with another machine");
}

void MpiCoordinator::give_up(Time now) {
  job_.commit();
  std::string silent;
  for (const std::uint32_t rank : pass_->collector.silent_ranks(now, options_.patience)) {
    silent += (silent.empty() ? "" : ", ") + std::to_string(rank);
  }
  throw RunError("no rank has made progress for " + duration_text(to_seconds(options_.patience)) +
                 (silent.empty() ? "" : "; at work and silent: " + silent) + "; " + kept_text());
}

JobStatus MpiCoordinator::status(Time now, bool done) const {
  const Framebuffer& framebuffer = job_.picture().framebuffer();
  const double elapsed = to_seconds(now - started_);
  const double progress = job_.progress(now - started_);
  JobStatus status;
  status.id = job_.record().id;
  status.name = job_.record().name;
  status.state = name_of(done ? JobState::done : JobState::running);
  status.progress = done ? 1 : progress;
  status.whole = preview_.wanted() && framebuffer.whole();
  status.error = job_.picture().passes().error();
  status.target_error = job_.record().settings->target_error;
  status.target_half_width = job_.record().settings->target_half_width;
  if (progress > progress_before_ && elapsed > 0) {
    status.samples_per_second = (static_cast<double>(framebuffer.counts().samples) -
                                 static_cast<double>(job_.samples_before())) /
                                elapsed;
    status.seconds_left = elapsed * (1 - progress) / (progress - progress_before_);
  }
  return status;
}

void MpiCoordinator::barrier() {
  const bool met = world_.barrier(options_.patience, [this] {
    stop_if_interrupted();
    stay_alive();
  });
  if (!met) {
    give_up(clock_.now());
  }
}

bool MpiCoordinator::last_barrier(Time patience) {
  return !pass_ || world_.barrier(patience, [this] { stay_alive(); });
}

RenderFacts MpiCoordinator::facts(const Ranks& ranks) const {
  RenderFacts facts;
  facts.render_seconds = to_seconds(finished_ - started_);
  facts.deciding_seconds = deciding_seconds_;
  facts.workers = ranks.count;
  facts.isa = pass_ ? pass_->runner.tally().isa : "";
  for (std::uint32_t rank = 0; rank < ranks.count; ++rank) {
    const auto seconds_of = [&](WindowLayout::RankWord word) {
      return 1e-9 * static_cast<double>(rank_value(rank, word));
    };
    facts.threads += ranks.facts[rank].threads;
    facts.trace_seconds += seconds_of(WindowLayout::busy);
    facts.build_seconds = std::max(facts.build_seconds, seconds_of(WindowLayout::build));
    facts.accelerator_bytes =
        std::max(facts.accelerator_bytes, rank_value(rank, WindowLayout::tree_bytes));
  }
  return facts;
}

}  // namespace parray::mpi
