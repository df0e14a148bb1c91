#include "cli/mpi/mpi_coordinator.h"

#include <sys/prctl.h>

#include <algorithm>
#include <iostream>

#include "cli/output/text.h"
#include "common/base/error.h"
#include "common/process/stop_signal.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"

namespace parray::mpi {
namespace {

/// Intervals at which rank 0 polls. If MPI needs the target's help, or ranks wait for answers,
/// requests often follow each other. So rank 0 polls eagerly for a while after each request, but
/// not always, because polling takes time from its own team.
constexpr Time calm_poll = milliseconds(1);
constexpr Time eager_poll = std::chrono::microseconds(50);
constexpr Time eager_time = milliseconds(2);

constexpr Time look_interval = milliseconds(50);

/// Largest number of merged cells in one turn, so that a turn stays short.
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
      collector(own.run_.picture(), own.judge_, *resources.layout, transport.window(),
                transport.memory(), own.clock_.now(), own.totals_,
                {own.options_.locate,
                 [&own](TracerKey tracer, TracedCells cells) {
                   own.run_.keep(tracer, std::move(cells));
                 }},
                {.own = own.options_.threads, .all = own.options_.all_threads}),
      runner(*resources.source, own.team_, own.clock_,
             own.pass_ ? own.pass_->runner.tally() : WorkTally{}) {}

MpiCoordinator::MpiCoordinator(const MpiWorld& world, CheckpointedJob& job, ThreadTeam& team,
                               Options options)
    : world_(world),
      job_(job),
      run_(job.run()),
      team_(team),
      options_(std::move(options)),
      judge_(run_.picture(), rank_voices(options_.hosts),
             {.trace = options_.trace,
              .retracted =
                  [this](const std::vector<CellRange>& cells) { run_.keep_retraction(cells); },
              .restarted =
                  [this] {
                    run_.drop_results();
                    run_.commit();
                  },
              .decided = [this](const RankJudge::Verdict& verdict) { report_verdict(verdict); }}),
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
      progress_before_(
          run_.samples_before() > 0 ? share_done(run_.record().settings, run_.state(), 0) : 0),
      next_checkpoint_(started_ + options_.checkpoint) {}

bool MpiCoordinator::run_pass(PassResources& resources, Transport& transport) {
  pass_ = std::make_unique<Pass>(*this, resources, transport);
  pass_began_ = clock_.now();
  last_activity_ = 0;
  asked_for_help_ = transport.by_messages() || !world_.one_machine();
  if (asked_for_help_) {
    prctl(PR_SET_TIMERSLACK, 1000);  // otherwise 50 us of sleep take 110
  }
  while (!pass_->collector.done() && !pass_->collector.overtaken()) {
    stop_if_interrupted();
    options_.reset_watchdog();
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

/// Decides on the next pass. Other ranks meanwhile wait for leases, and see rank 0's heartbeat.
bool MpiCoordinator::end_pass() {
  progress_.show(clock_.now(), status(clock_.now(), false));
  const Time began = clock_.now();
  const bool goes_on = run_.begin_pass(times(began));
  finished_ = clock_.now();
  deciding_seconds_ += to_seconds(finished_ - began);
  if (!goes_on) progress_.show(finished_, status(finished_, true));
  pass_->collector.finish();
  pass_->runner.stop();
  return goes_on;
}

PassTimes MpiCoordinator::times(Time now) const {
  const JobRecord& record = run_.record();
  PassTimes times = ending_times(record.settings, run_.picture().framebuffer().counts().samples,
                                 record.reserved_seconds + to_seconds(now - started_));
  times.pass = to_seconds(now - pass_began_);
  return times;
}

void MpiCoordinator::stop_if_interrupted() {
  try {
    check_interrupted();
  } catch (const Interrupted&) {
    run_.commit();
    throw Interrupted("interrupted, perhaps because another rank ended: " + kept_text());
  }
}

/// Serves other ranks and shows that rank 0 is alive, while it does other things than tracing.
void MpiCoordinator::stay_alive() {
  options_.reset_watchdog();
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
  if (judge_.self_doubt()) give_up_judging();
  collector.issue_copies(now);
  if (now >= next_look_) {
    next_look_ = now + look_interval;
    check_ranks(now);
  }
}

void MpiCoordinator::check_ranks(Time now) {
  const JobStatus so_far = status(now, false);
  progress_.show(now, so_far);
  preview_.follow(clock_, so_far, [this] { return shown_image(run_.picture()).image; });
  pass_->collector.listen(now);
  if (now - pass_->collector.last_sign_of_life() >= options_.patience) give_up(now);
  if (now >= next_checkpoint_ || run_.buffer_full()) save_some(now);
}

/// Saves a few results in each call, because other ranks may need rank 0 meanwhile. With a slow
/// disk, checkpoints are less frequent, so that they take at most a tenth of the time.
void MpiCoordinator::save_some(Time now) {
  next_checkpoint_ = now;  // the next call continues, until the buffer is empty
  if (!run_.pack_next()) {
    run_.commit();
    saving_ += clock_.now() - now;
    next_checkpoint_ = now + std::max(options_.checkpoint, 10 * std::exchange(saving_, Time(0)));
    return;
  }
  saving_ += clock_.now() - now;
}

std::string MpiCoordinator::kept_text() const {
  return job_.amount_text() + (run_.record().settings->in_passes() ? " are" : " is") + " kept in " +
         job_.directory().string() +
         ": the same command continues from there, with any number of ranks";
}

/// Reports a rank that returned wrong bits, and the consequences, on stderr and in the job's flag.
void MpiCoordinator::report_verdict(const RankJudge::Verdict& verdict) {
  const auto name_of_rank = [this](std::uint32_t rank) {
    return "rank " + std::to_string(rank) + " on " + options_.hosts[rank];
  };
  const std::string wrong =
      (verdict.rank ? name_of_rank(*verdict.rank) : "an earlier mpirun") + " returned wrong bits: ";
  const std::string follows = verdict.restarted
                                  ? "the picture was begun again"
                                  : std::to_string(verdict.cells) + " cells were traced again";
  std::string& flag = run_.record().flag;
  flag += (flag.empty() ? "" : "; ") + wrong + follows;
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

/// Ends the job, because rank 0 itself returned wrong bits and no other rank can decide.
void MpiCoordinator::give_up_judging() {
  run_.commit();
  throw RunError("rank 0 on " + options_.hosts[0] +
                 " got other bits when it traced the same samples again, so the picture cannot be "
                 "trusted: test that machine's memory. " +
                 kept_text() + "; put another machine first in the list of hosts");
}

void MpiCoordinator::give_up(Time now) {
  run_.commit();
  std::string silent;
  for (const std::uint32_t rank : pass_->collector.silent_ranks(now, options_.patience)) {
    silent += (silent.empty() ? "" : ", ") + std::to_string(rank);
  }
  throw RunError("no rank has made progress for " + duration_text(to_seconds(options_.patience)) +
                 (silent.empty() ? "" : "; silent ranks with leases: " + silent) + "; " +
                 kept_text());
}

JobStatus MpiCoordinator::status(Time now, bool done) const {
  const JobRecord& record = run_.record();
  const RunState state = run_.state();
  const double elapsed = to_seconds(now - started_);
  const double progress = share_done(record.settings, state, elapsed);
  JobStatus status;
  status.id = record.id;
  status.name = record.name;
  status.state = name_of(done ? JobState::done : JobState::running);
  status.progress = done ? 1 : progress;
  status.whole = preview_.wanted() && state.whole;
  status.error = state.error;
  status.target_error = record.settings->target_error;
  status.target_half_width = record.settings->target_half_width;
  if (progress > progress_before_ && elapsed > 0) {
    status.samples_per_second =
        (static_cast<double>(state.samples) - static_cast<double>(run_.samples_before())) / elapsed;
    status.seconds_left = elapsed * (1 - progress) / (progress - progress_before_);
  }
  return status;
}

void MpiCoordinator::barrier() {
  const bool met = world_.barrier(options_.patience, [this] {
    stop_if_interrupted();
    stay_alive();
  });
  if (!met) give_up(clock_.now());
}

bool MpiCoordinator::last_barrier(Time patience) {
  return !pass_ || world_.barrier(patience, [this] { stay_alive(); });
}

RenderFacts MpiCoordinator::facts(const Ranks& ranks) const {
  RenderFacts facts;
  facts.render_seconds = to_seconds(finished_ - started_);
  facts.samples_before = run_.samples_before();
  facts.deciding_seconds = deciding_seconds_;
  facts.workers = ranks.count;
  const RenderSettings& settings = run_.record().settings;
  // Also if rank 0 only merged the results of other ranks.
  facts.isa = pass_ ? name_of(isa_for(settings.accelerator, settings.isa)) : "";
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
