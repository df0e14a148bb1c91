#include "cli/mpi/mpi_render.h"

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <optional>
#include <thread>

#include "cli/commands/rendering.h"
#include "cli/front_door.h"
#include "cli/interrupt.h"
#include "cli/mpi/mpi_coordinator.h"
#include "cli/mpi/mpi_job.h"
#include "cli/mpi/mpi_report.h"
#include "cli/mpi/watchdog.h"
#include "cli/text.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/image/image.h"
#include "common/scene/scene_bytes.h"
#include "common/schedule/row_order.h"
#include "common/trace/fingerprint.h"
#include "common/trace/nonfinite.h"

namespace parray {
namespace {

constexpr const char* program = "parray-mpi";

/// Ends all ranks, this one at once: a rank that waits for MPI cannot be told otherwise.
[[noreturn]] void end_all(int status) {
  std::cerr << std::flush;
  MPI_Abort(MPI_COMM_WORLD, status);
  std::_Exit(status);
}

/// A rank that waits for another in vain says so and takes the others with it.
Watchdog guard(const MpiWorld& world, const MpiOptions& options) {
  const std::uint32_t rank = world.rank();
  return Watchdog(seconds(options.patience), [rank] {
    fail(program, 1,
         "rank " + std::to_string(rank) +
             " waits for another that does not answer. If all are there, one-sided communication "
             "does not work here: try --mode messages");
    std::_Exit(1);  // mpirun ends the rest
  });
}

/// Of the processors that mpirun has left to this rank.
std::uint32_t threads_for(const MpiWorld& world, const MpiOptions& options, bool alone) {
  if (options.mode == MpiMode::sequential) {
    return 1;
  }
  // Alone on the machine, rank 0 has all of its processors.
  const auto share = alone ? static_cast<std::uint32_t>(usable_cpus()) : world.threads();
  return options.threads.value_or(share);
}

/// The ranks that take part, as each of them knows them. Making it is collective.
struct Crew {
  Crew(const MpiWorld& world, const MpiOptions& asked, const MpiJob& job)
      : ranks(job.alone() ? 1 : world.ranks()) {
    options.policy = job.settings.schedule;
    options.rank = world.rank();
    options.threads = threads_for(world, asked, job.alone());
    facts = gather_facts(world, options.threads, ranks);
    options.all_threads = options.threads;
    if (!job.alone()) {
      options.all_threads = static_cast<std::uint32_t>(world.sum(options.threads));
    }
  }

  std::uint32_t ranks;
  WindowLeaseOptions options;
  std::vector<RankFacts> facts;
};

/// What every rank that takes part builds alike, pass by pass.
struct Parts {
  Parts(const MpiWorld& world, const MpiJob& job) : transport(world, job) {}

  /// Collective.
  void begin_pass(const Crew& crew, const MpiJob& job, MpiPass pass) {
    leases.clear();
    plan = std::make_shared<const WorkPlan>(job.settings, std::move(pass.pending), job.tile,
                                            std::move(pass.samples));
    layout.emplace(*plan, crew.ranks);
    transport.begin_pass(*layout);
    if (crew.options.rank == 0) {
      make_leases(crew);
    }
  }
  void make_leases(const Crew& crew);

  Transport transport;
  std::shared_ptr<const WorkPlan> plan;
  std::optional<WindowLayout> layout;
  /// Of every rank that rank 0 takes leases for: itself, and all where they send messages.
  std::vector<std::unique_ptr<WindowLeases>> leases;
};

void Parts::make_leases(const Crew& crew) {
  const std::uint32_t count = transport.by_messages() ? crew.ranks : 1;
  for (std::uint32_t rank = 0; rank < count; ++rank) {
    WindowLeaseOptions options = crew.options;
    options.rank = rank;
    options.threads = crew.facts[rank].threads;
    leases.push_back(std::make_unique<WindowLeases>(*plan, *layout, *transport.window(), options));
  }
}

void tell_of_accelerator(LeaseSource& leases, const ThreadCellTeam& team) {
  const auto built = team.built();
  leases.tell(WindowLayout::build, static_cast<std::uint64_t>(built.seconds * 1e9));
  leases.tell(WindowLayout::tree_bytes, built.bytes);
}

constexpr Time for_ever = std::chrono::hours(24 * 365);
/// How long rank 0 waits, when all is done, for ranks that may have been stopped.
constexpr Time last_meeting = seconds(10);

/// Whether rank 0 has been seen alive, asked now and then.
class Pulse {
 public:
  /// Without a window (null) rank 0 answers, or the rank hangs: there is nothing to ask.
  explicit Pulse(Window* window) : window_(window) {}

  bool felt(Time now) {
    if (window_ == nullptr) {
      return true;
    }
    if (now < next_look_) {
      return false;
    }
    next_look_ = now + milliseconds(250);
    return std::exchange(last_, window_->load(WindowLayout::pulse)) != last_;
  }

 private:
  Window* window_;
  std::uint64_t last_ = 0;
  Time next_look_{};
};

/// A pass, in a rank other than 0. Returns what the rank has done so far in the job.
RankTally work_on_pass(const MpiWorld& world, Parts& parts, const Crew& crew, ThreadCellTeam& team,
                       const RankTally& before, Watchdog& dog) {
  std::unique_ptr<LeaseSource> leases;
  if (parts.transport.by_messages()) {
    leases = std::make_unique<MessageLeases>(world.comm());
  } else {
    leases = std::make_unique<WindowLeases>(*parts.plan, *parts.layout, *parts.transport.window(),
                                            crew.options);
  }
  team.change_plan(parts.plan);
  const SteadyClock clock;
  RankWorker worker(*parts.plan, *leases, team, clock, before);
  Pulse pulse(parts.transport.window());
  while (!worker.over()) {
    if (team.busy() || pulse.felt(clock.now())) {
      dog.pet();
    }
    const Time due = worker.tick(clock.now());
    team.wait(std::max(due - clock.now(), Time(0)));
  }
  worker.stop();
  worker.report();
  tell_of_accelerator(*leases, team);
  // Of rank 0 that waits for another; by messages nothing is known, and the dog's patience counts.
  world.meet(for_ever, [&] {
    if (!parts.transport.by_messages() && pulse.felt(clock.now())) {
      dog.pet();
    }
  });
  return worker.tally();
}

/// Ranks other than 0.
int work(const MpiOptions& options, const MpiWorld& world) {
  const auto job = broadcast_job(world, nullptr);
  if (!job) {
    return 0;  // rank 0 says why
  }
  if (job->alone()) {
    world.meet(for_ever);  // until the work is done, and then until the picture is written
    world.meet(for_ever);
    return 0;
  }
  Watchdog dog = guard(world, options);
  if (!world.all_of(trace_fingerprint() == job->fingerprint)) {
    return 0;  // rank 0 says so
  }
  const Crew crew(world, options, *job);
  ThreadCellTeam team(scene_from_bytes(job->scene_bytes), job->settings, nullptr,
                      static_cast<int>(crew.options.threads));
  Parts parts(world, *job);
  RankTally tally;
  while (auto pass = broadcast_pass(world, nullptr)) {
    parts.begin_pass(crew, *job, std::move(*pass));
    tally = work_on_pass(world, parts, crew, team, tally, dog);
    dog.pet();
  }
  world.meet(for_ever, [&dog] { dog.pet(); });  // while rank 0 writes the picture
  parts.transport.close();
  return 0;
}

MpiJob load_job(const MpiOptions& options, std::unique_ptr<KeptJob>& kept) {
  check_outputs(options.output.paths(), options.scene);
  const Preview preview(options.following.preview);  // before any work
  Submission submission = load_submission(options.scene, options.render, 50);
  check_isa(submission.settings.isa);
  if (options.mode == MpiMode::static_split) {
    submission.settings.schedule = SchedulePolicy::static_split;
    submission.settings.row_order = RowOrder::sequential;
  }
  const bool named = !options.state.empty();
  kept = std::make_unique<KeptJob>(
      std::move(submission),
      named ? options.state : options.output.paths().image.string() + ".state", named);
  if (kept->taken_up() > 0) {
    std::cerr << std::string(program) + ": going on from " + kept->amount_text(kept->taken_up()) +
                     " in " + kept->directory().string() + "\n";
  }
  MpiJob job;
  job.settings = kept->job().record.settings;
  job.mode = options.mode;
  job.tile = options.tile;
  job.fingerprint = trace_fingerprint();
  job.scene_bytes = *kept->job().work->scene_bytes;
  return job;
}

/// Traces a cell again to find what is not finite; the kernel is made when the first is asked for.
class Locator {
 public:
  explicit Locator(const MpiJob& job)
      : job_(job), row_at_(make_row_order(job.settings.row_order, job.settings.height)) {}

  std::vector<ExcludedSamples> operator()(const Cell& cell) {
    if (!kernel_) {
      kernel_ = make_kernel(scene_from_bytes(job_.scene_bytes), job_.settings);
    }
    return locate_nonfinite(*kernel_, {row_at_[cell.position], cell.x_begin, cell.x_end},
                            cell.sample_ranges(), cell.position);
  }

 private:
  const MpiJob& job_;
  std::vector<std::uint32_t> row_at_;
  std::shared_ptr<const Kernel> kernel_;  // shared, because a std::function is copied
};

MpiPass pass_of(const JobWork& work) {
  return {work.leases.pending(), work.framebuffer.pass_samples()};
}

struct Rendered {
  Picture picture;
  bool all_answer = true;
  std::uint64_t mismatches = 0;
  int threads = 1;
  std::unique_ptr<Parts> parts;
};

/// Pass after pass, in rank 0; the first is the whole job, as a rule.
void run_passes(const MpiWorld& world, const Crew& crew, const JobWork& work, const MpiJob& job,
                MpiCoordinator& coordinator, ThreadCellTeam& team, Parts& parts) {
  for (bool goes_on = true; goes_on;) {
    MpiPass pass = pass_of(work);
    if (!job.alone()) {
      broadcast_pass(world, &pass);
    }
    const bool by_messages = parts.transport.by_messages();
    parts.begin_pass(crew, job, std::move(pass));
    if (parts.transport.by_messages() && !by_messages) {
      std::cerr << std::string(program) + ": no MPI window here (" +
                       parts.transport.fallback_reason() + "): ranks send messages instead\n";
    }
    team.change_plan(parts.plan);
    goes_on = coordinator.run_pass(*parts.plan, *parts.layout, parts.transport, parts.leases);
    tell_of_accelerator(*parts.leases[0], team);
    if (goes_on && !job.alone()) {
      coordinator.meet_ranks();
    }
  }
}

/// Rank 0, once it has a job.
Rendered render_job(const MpiOptions& options, const MpiWorld& world, KeptJob& kept,
                    const MpiJob& job) {
  Watchdog dog = guard(world, options);
  broadcast_job(world, &job);
  if (!job.alone() && !world.all_of(trace_fingerprint() == job.fingerprint)) {
    throw RunError(
        "not all ranks trace the same bits (the built-in test picture differs): run the same build "
        "on all machines, or test their memory");
  }
  const Crew crew(world, options, job);
  Rendered rendered;
  rendered.threads = static_cast<int>(crew.options.threads);
  ThreadCellTeam team(scene_from_bytes(job.scene_bytes), job.settings, nullptr, rendered.threads);
  MpiCoordinator coordinator(world, kept, team, Locator(job), [&dog] { dog.pet(); },
                             {.patience = seconds(options.patience),
                              .checkpoint = seconds(options.checkpoint),
                              .following = options.following});
  Job& done = kept.job();
  rendered.parts = std::make_unique<Parts>(world, job);
  Parts& parts = *rendered.parts;
  run_passes(world, crew, *done.work, job, coordinator, team, parts);
  rendered.all_answer = coordinator.gather_ranks(std::min(seconds(options.patience), seconds(10)));
  if (rendered.all_answer && !job.alone()) {
    broadcast_pass(world, nullptr);
  }
  WindowLedger& ledger = coordinator.ledger();
  note_ranks(done, crew.facts, *parts.layout, ledger);
  done.work->isa = team.built().isa;
  FinishedPicture finished = finish_picture(done, coordinator.finished());
  rendered.picture = {std::move(finished.image), std::move(finished.statistics),
                      std::move(finished.report)};
  nlohmann::json& report = rendered.picture.report;
  report["mpi"] = mpi_report(done, parts.transport, job.mode, crew.facts, *parts.layout, ledger,
                             report.at("seconds").at("render"), options.row_seconds);
  rendered.mismatches = ledger.tally().mismatches;
  return rendered;
}

/// Does what all ranks depend on: when it throws, they all end.
template <typename Action>
auto together(Action action) {
  decltype(action()) result{};
  const int status = run_action(program, [&] {
    result = action();
    return 0;
  });
  if (status == interrupted_status) {
    // mpirun is ending the others; it drops what a rank that has gone has said just before.
    std::this_thread::sleep_for(milliseconds(300));
    std::_Exit(status);
  }
  if (status != 0) {
    end_all(status);
  }
  return result;
}

int finish(const MpiOptions& options, KeptJob& kept, const MpiJob& job, Rendered& rendered,
           Time started) {
  kept.keep_picture(rendered.picture);
  add_channels(rendered.picture, extra_channels(options.output.paths().aovs, job.settings,
                                                job.scene_bytes, rendered.threads));
  const int status = deliver(std::move(rendered.picture), options.output.paths(), started);
  kept.forget();
  if (rendered.mismatches > 0) {
    throw RunError(std::to_string(rendered.mismatches) +
                   " cells came out with other bits when a second rank traced them: test the "
                   "machines' memory");
  }
  return status;
}

/// Rank 0.
int lead(const MpiOptions& options, const MpiWorld& world, Time started) {
  std::unique_ptr<KeptJob> kept;
  MpiJob job;
  try {
    job = load_job(options, kept);
  } catch (...) {
    broadcast_job(world, nullptr);
    throw;
  }
  const DeferredInterrupts deferred;
  Rendered rendered = together([&] { return render_job(options, world, *kept, job); });
  const int status =
      run_action(program, [&] { return finish(options, *kept, job, rendered, started); });
  if (!rendered.all_answer || !world.meet(last_meeting)) {
    fail(program, status, "the work is done, but not all ranks answer: ending them");
    end_all(status);
  }
  rendered.parts->transport.close();
  return status;
}

}  // namespace

int mpi_render(const MpiOptions& options) {
  const SteadyClock clock;
  const Time started = clock.now();
  auto world = std::make_unique<MpiWorld>();
  const int status = world->first() ? lead(options, *world, started)
                                    : together([&] { return work(options, *world); });
  const Watchdog dog(seconds(options.patience), [status] {
    std::_Exit(status);  // a rank does not come to the end: all the others have done their work
  });
  world.reset();
  return status;
}

}  // namespace parray
