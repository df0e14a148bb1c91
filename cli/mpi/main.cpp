// parray-mpi: renders a scene with all the ranks of one mpirun.
#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>

#include "cli/commands/prepare.h"
#include "cli/commands/rendering.h"
#include "cli/mpi/mpi_coordinator.h"
#include "cli/mpi/watchdog.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/image/image.h"
#include "common/process/run_main.h"
#include "common/process/stop_signal.h"
#include "common/scene/scene_bytes.h"
#include "common/scene/settings.h"
#include "common/trace/selfcheck/fingerprint.h"
#include "common/trace/tracer.h"
#include "worker/cell_tracer.h"

namespace {

using namespace parray::mpi;
using nlohmann::json;

constexpr const char* program = "parray-mpi";

double ratio(double a, double b) { return b > 0 ? a / b : 0; }

/// Returns the ranks that returned wrong bits, for the report.
json faulty_ranks(const std::vector<RankJudge::Verdict>& verdicts, const Ranks& ranks) {
  json list = json::array();
  for (const RankJudge::Verdict& verdict : verdicts) {
    list.push_back({{"rank", verdict.rank ? json(*verdict.rank) : json()},
                    {"host", verdict.rank ? ranks.facts[*verdict.rank].host : ""},
                    {"retraced_cells", verdict.cells},
                    {"restarted", verdict.restarted},
                    {"left_out", verdict.left_out}});
  }
  return list;
}

/// Returns the map "mpi" of the report, which only MPI jobs have; see cli/REFERENCE.md, "The
/// report".
json mpi_report(const MpiCoordinator& coordinator, const Ranks& ranks, MpiMode mode,
                const char* transport, double render_seconds, bool row_seconds) {
  double takes = 0;
  double taking = 0;
  double putting = 0;
  json list = json::array();
  for (std::uint32_t rank = 0; rank < ranks.count; ++rank) {
    const auto value = [&](WindowLayout::RankWord word) {
      return static_cast<double>(coordinator.rank_value(rank, word));
    };
    takes += value(WindowLayout::takes);
    taking += value(WindowLayout::taking);
    putting += value(WindowLayout::putting);
    const double busy = 1e-9 * value(WindowLayout::busy);
    list.push_back({{"host", ranks.facts[rank].host},
                    {"threads", ranks.facts[rank].threads},
                    {"samples", coordinator.rank_value(rank, WindowLayout::samples)},
                    {"leases", coordinator.rank_value(rank, WindowLayout::takes)},
                    {"busy_seconds", busy},
                    {"normalized_seconds", ratio(busy, render_seconds)}});
  }
  const WindowCollector::Totals& totals = coordinator.totals();
  json map = {
      {"mode", name_of(mode)},
      {"transport", transport},
      {"leases", takes},
      {"microseconds_per_lease", 1e-3 * ratio(taking, takes)},
      {"microseconds_per_result", 1e-3 * ratio(putting, static_cast<double>(totals.entries))},
      {"copies", totals.copies},
      {"duplicate_cells", totals.duplicates},
      {"mismatched_cells", totals.mismatches},
      {"corrupt_results", totals.corrupt},
      {"faulty_ranks", faulty_ranks(coordinator.verdicts(), ranks)},
      {"ranks", std::move(list)}};
  if (row_seconds) {
    json& rows = map["row_seconds"] = json::array();  // by image row, top first
    for (const std::uint64_t nanoseconds : totals.row_nanoseconds) {
      rows.push_back(1e-9 * static_cast<double>(nanoseconds));
    }
  }
  return map;
}

/// Ends all ranks, and this one at once. MPI_Abort also ends ranks that wait in MPI.
[[noreturn]] void end_all(int status) {
  std::cerr << std::flush;
  MPI_Abort(MPI_COMM_WORLD, status);
  std::_Exit(status);
}

/// Returns a watchdog that ends all ranks with a message if this rank waits too long for another.
Watchdog guard(const MpiWorld& world, const MpiOptions& options) {
  const std::uint32_t rank = world.rank();
  return Watchdog(seconds(options.patience), [rank] {
    fail(program, 1,
         "rank " + std::to_string(rank) +
             " waits for a rank that does not answer. If all ranks run, one-sided communication "
             "does not work here: try --mode messages");
    std::_Exit(1);  // mpirun ends the rest
  });
}

/// Returns the number of threads of this rank. `alone`: only rank 0 renders.
std::uint32_t threads_for(const MpiWorld& world, const MpiOptions& options, bool alone) {
  if (options.mode == MpiMode::sequential) return 1;
  // Alone on the machine, rank 0 has all of its processors.
  const auto share = alone ? static_cast<std::uint32_t>(usable_cpus()) : world.threads();
  return options.threads.value_or(share);
}

RankJob rank_job(const MpiJob& job, std::shared_ptr<const Scene> scene) {
  return {job.settings, "the scene", std::move(scene)};
}

constexpr Time for_ever = std::chrono::hours(24 * 365);
/// Interval at which the rank with a ledger completes operations of other ranks, if MPI needs that.
constexpr Time keeper_poll = std::chrono::microseconds(200);
/// How long rank 0 waits at the end for ranks that may have been stopped.
constexpr Time last_patience = seconds(10);

/// Watches the heartbeat of rank 0.
class RootHeartbeat {
 public:
  explicit RootHeartbeat(Window& window) : window_(window) {}

  /// Returns whether the heartbeat has changed since the last check. Checks every 250 ms.
  bool alive(Time now) {
    if (now < next_look_) return false;
    next_look_ = now + milliseconds(250);
    return std::exchange(last_, window_.load(WindowLayout::root_heartbeat)) != last_;
  }

 private:
  Window& window_;
  std::uint64_t last_ = 0;
  Time next_look_{};
};

/// A rank other than 0.
class Follower {
 public:
  /// Collective.
  Follower(const MpiOptions& options, MpiWorld& world, MpiJob job, Watchdog& watchdog)
      : world_(world),
        job_(std::move(job)),
        watchdog_(watchdog),
        ranks_(find_ranks(world, job_, threads_for(world, options, false))),
        rank_job_(rank_job(job_, std::make_shared<const Scene>(
                                     scene_from_bytes(std::exchange(job_.scene_bytes, {}))))),
        team_(static_cast<int>(ranks_.own.threads)),
        transport_(world, false, job_.mode == MpiMode::messages, options.ledger_ranks) {}

  /// Renders all passes, and returns when rank 0 has written the picture.
  void run() {
    PassResources resources;
    while (auto pass = broadcast_pass(world_, job_, nullptr)) {
      resources.begin(std::move(*pass), transport_, ranks_, rank_job_);
      work(resources);
      watchdog_.reset();
    }
    world_.barrier(for_ever, [this] { watchdog_.reset(); });
    transport_.close();
  }

 private:
  void work(PassResources& resources) {
    LeaseRunner runner(*resources.source, team_, clock_, tally_);
    RootHeartbeat heartbeat(transport_.window());
    const bool keeps = transport_.ledgers().ledgers.is_keeper(world_.rank());
    while (!runner.over()) {
      if (!team_.idle() || heartbeat.alive(clock_.now())) watchdog_.reset();
      const Time due = runner.tick(clock_.now());
      if (keeps) transport_.progress();
      const Time longest = keeps ? keeper_poll : for_ever;
      team_.wait(std::clamp(due - clock_.now(), Time(0), longest));
    }
    runner.stop();
    tally_ = runner.tally();
    // Rank 0 may wait for another rank. It answers no requests after the last rank has come here.
    // So without one-sided communication there is no heartbeat, and the watchdog's time runs. After
    // the last pass rank 0 may write the picture for a long time without a rank that is missing.
    world_.barrier(for_ever, [&] {
      if (keeps) {
        transport_.progress();  // other ranks may still use this rank's ledger
      }
      if (world_.end_announced() || (!transport_.by_messages() && heartbeat.alive(clock_.now()))) {
        watchdog_.reset();
      }
    });
  }

  MpiWorld& world_;
  MpiJob job_;
  Watchdog& watchdog_;
  const SteadyClock clock_;
  const Ranks ranks_;
  RankJob rank_job_;
  ThreadTeam team_;
  Transport transport_;
  WorkTally tally_;
};

int follow(const MpiOptions& options, MpiWorld& world) {
  auto job = broadcast_job(world, nullptr);
  if (!job) {
    return 0;  // rank 0 prints the reason
  }
  if (job->alone()) {
    world.barrier(for_ever);  // first until the work is done, then until the picture is written
    world.barrier(for_ever);
    return 0;
  }
  Watchdog watchdog = guard(world, options);
  if (world.all_of(trace_fingerprint() == job->fingerprint)) {  // otherwise rank 0 reports it
    Follower(options, world, std::move(*job), watchdog).run();
  }
  return 0;
}

/// A job that rank 0 is ready to share.
struct LoadedJob {
  MpiJob job;
  std::unique_ptr<CheckpointedJob> kept;
  OutputPaths outputs;
};

LoadedJob load_job(const MpiOptions& options, const MpiWorld& world, Time started) {
  PreparedRender prepared = prepare({RenderMode::mpi, options.scene, options.render, options.output,
                                     options.following, threads_for(world, options, false)});
  RenderSettings& settings = prepared.submission.settings;
  if (options.mode == MpiMode::static_split) {
    settings.schedule = SchedulePolicy::static_split;
    settings.row_order = RowOrder::sequential;
  }
  reserve_time(prepared, [&] { return to_seconds(SteadyClock().now() - started); });
  const bool named = !options.state.empty();
  auto kept = std::make_unique<CheckpointedJob>(
      std::move(prepared.submission), options.tile,
      named ? options.state : prepared.outputs.image.string() + ".state", named);
  if (kept->run().samples_before() > 0) {
    std::cerr << std::string(program) + ": continuing from " + kept->amount_text() + " in " +
                     kept->directory().string() + "\n";
  }
  MpiJob job;
  job.settings = kept->run().record().settings;
  job.mode = options.mode;
  job.tile = kept->run().record().tile;
  job.fingerprint = trace_fingerprint();
  return {std::move(job), std::move(kept), std::move(prepared.outputs)};
}

/// Traces cells again in rank 0. Makes the tracer when it is first needed.
class Retracer {
 public:
  Retracer(const CheckpointedJob& kept, const RenderSettings& settings)
      : kept_(kept), settings_(settings) {}

  /// Returns the samples of a cell that are not finite.
  std::vector<ExcludedSamples> locate(const CellBatch& batch) {
    const Cell cell = batch.grid->cell(batch.range.begin);
    return locate_nonfinite(tracer(), {cell.y, cell.x_begin, cell.x_end},
                            batch.column_ranges_of(batch.range.begin));
  }
  TracedCells trace(const CellBatch& batch) {
    std::atomic<std::uint64_t> traced = 0;
    return trace_cells(tracer(), batch, 1, traced, false);
  }

 private:
  const PathTracer& tracer() {
    if (!tracer_) tracer_ = make_path_tracer(*kept_.copy_scene(), settings_);
    return *tracer_;
  }

  const CheckpointedJob& kept_;
  const RenderSettings& settings_;
  std::unique_ptr<const PathTracer> tracer_;
};

struct Rendered {
  Picture picture;
  bool all_answer = true;
  int threads = 1;
  std::unique_ptr<Transport> transport;
};

std::vector<std::string> hosts_of(const Ranks& ranks) {
  std::vector<std::string> hosts;
  for (std::uint32_t rank = 0; rank < ranks.count; ++rank) hosts.push_back(ranks.facts[rank].host);
  return hosts;
}

/// Renders all passes in rank 0. Most jobs have only one.
void run_passes(const MpiWorld& world, const Ranks& ranks, const MpiJob& job, CheckpointedJob& kept,
                MpiCoordinator& coordinator, PassResources& resources, Transport& transport) {
  RankJob own = rank_job(job, kept.take_scene());
  for (bool goes_on = kept.run().begin_pass(); goes_on;) {
    const JobPicture& picture = kept.run().picture();
    RankPass pass{picture.plan(), CellList(picture.collector().missing())};
    if (!job.alone()) broadcast_pass(world, job, &pass);
    const bool by_messages = transport.by_messages();
    resources.begin(std::move(pass), transport, ranks, own);
    if (transport.by_messages() && !by_messages) {
      std::cerr << std::string(program) + ": one-sided communication of MPI does not work here (" +
                       transport.fallback_reason() + "): ranks send messages instead\n";
    }
    goes_on = coordinator.run_pass(resources, transport);
    if (goes_on && !job.alone()) coordinator.barrier();
  }
}

/// Renders a loaded job in rank 0.
Rendered render_job(const MpiOptions& options, const MpiWorld& world, CheckpointedJob& kept,
                    const MpiJob& job) {
  Watchdog watchdog = guard(world, options);
  broadcast_job(world, &job, kept.scene_bytes());
  if (!job.alone() && !world.all_of(trace_fingerprint() == job.fingerprint)) {
    throw RunError(
        "not all ranks trace the same bits (the built-in test picture differs): run the same build "
        "on all machines, or test their memory");
  }
  const Ranks ranks = find_ranks(world, job, threads_for(world, options, job.alone()));
  Rendered rendered;
  rendered.threads = static_cast<int>(ranks.own.threads);
  rendered.transport = std::make_unique<Transport>(
      world, job.alone(), job.mode == MpiMode::messages, options.ledger_ranks);
  PassResources resources;
  ThreadTeam team(rendered.threads);
  Retracer retracer(kept, job.settings);
  MpiCoordinator coordinator(
      world, kept, team,
      {.patience = seconds(options.patience),
       .checkpoint = from_seconds(options.checkpoint),
       .following = options.following,
       .threads = ranks.own.threads,
       .all_threads = ranks.own.all_threads,
       .locate = [&retracer](const CellBatch& cell) { return retracer.locate(cell); },
       .trace = [&retracer](const CellBatch& cell) { return retracer.trace(cell); },
       .hosts = hosts_of(ranks),
       .reset_watchdog = [&watchdog] { watchdog.reset(); }});
  run_passes(world, ranks, job, kept, coordinator, resources, *rendered.transport);
  if (!job.alone()) world.announce_end();
  rendered.all_answer =
      coordinator.last_barrier(std::min<Time>(seconds(options.patience), last_patience));
  if (rendered.all_answer && !job.alone()) broadcast_pass(world, job, nullptr);
  const RenderFacts facts = coordinator.facts(ranks);
  FinishedPicture finished = finish_picture(kept.run().picture(), kept.run().record(), facts);
  rendered.picture = {std::move(finished.picture.image), std::move(finished.picture.statistics),
                      nlohmann::json::parse(finished.report)};
  coordinator.show_finished(rendered.picture.image);
  rendered.picture.report["mpi"] =
      mpi_report(coordinator, ranks, job.mode, rendered.transport->name(), facts.render_seconds,
                 options.row_seconds);
  return rendered;
}

/// Runs `action`, on which all ranks depend, and returns its result. If it throws, ends all ranks.
auto or_abort_all(auto action) {
  decltype(action()) result{};
  const int status = run_action(program, [&] {
    result = action();
    return 0;
  });
  if (status == interrupted_status) {
    // mpirun ends the other ranks, and loses the last output of a rank that ends too early.
    std::this_thread::sleep_for(milliseconds(300));
    std::_Exit(status);
  }
  if (status != 0) end_all(status);
  return result;
}

/// Writes all files, then runs the command of --on-end.
int finish(const LoadedJob& loaded, Rendered& rendered, const std::string& on_end, Time started) {
  const OutputPaths& outputs = loaded.outputs;
  const RenderSettings& settings = loaded.job.settings;
  CheckpointedJob& kept = *loaded.kept;
  const auto end = [&, id = kept.run().record().id](JobState state, const std::string& reason) {
    run_end_command(on_end, id, std::string(name_of(state)), reason, outputs.image.string());
  };
  try {
    kept.keep_picture(rendered.picture);
    auto scene = needs_scene(outputs, settings) ? kept.copy_scene() : nullptr;
    add_channels(rendered.picture,
                 extra_channels(outputs, settings, std::move(scene), rendered.threads));
    const int status =
        write_outputs(std::move(rendered.picture), outputs, CommandTimes{started, 0, true});
    kept.forget();
    end(JobState::done, "");
    return status;
  } catch (const RunError& error) {
    end(JobState::failed, error.what());
    throw;
  }
}

/// Loads and renders the job in rank 0, and writes the files. Returns the exit status.
int lead(const MpiOptions& options, const MpiWorld& world, Time started) {
  LoadedJob loaded;
  try {
    loaded = load_job(options, world, started);
  } catch (...) {
    broadcast_job(world, nullptr);
    throw;
  }
  const DeferredInterrupts deferred;
  Rendered rendered =
      or_abort_all([&] { return render_job(options, world, *loaded.kept, loaded.job); });
  const int status = run_action(
      program, [&] { return finish(loaded, rendered, options.following.on_end, started); });
  if (!rendered.all_answer || !world.barrier(last_patience)) {
    fail(program, status, "the work is done, but not all ranks answer: ending all ranks");
    end_all(status);
  }
  rendered.transport->close();
  return status;
}

/// Renders a scene with all ranks of this mpirun. Rank 0 returns the exit status, other ranks
/// return 0. Throws InputError, RunError or Interrupted before the ranks begin to render. An error
/// during rendering prints a line on stderr and ends all ranks. If rank 0 cannot write the files,
/// it prints a line on stderr and returns the exit status.
int render(const MpiOptions& options) {
  const SteadyClock clock;
  const Time started = clock.now();
  auto world = std::make_unique<MpiWorld>();
  const int status = world->first() ? lead(options, *world, started)
                                    : or_abort_all([&] { return follow(options, *world); });
  const Watchdog watchdog(seconds(options.patience), [status] {
    std::_Exit(status);  // another rank does not end, but this rank's work is done
  });
  world.reset();
  return status;
}

}  // namespace

/// All ranks read the same command line. Only rank 0 prints messages and returns a failure, because
/// mpirun ends all ranks, also rank 0, as soon as any rank fails.
int main(int argc, char** argv) {
  const bool speaks = rank_in_environment() == 0;
  if (speaks) stop_at_signals();
  MpiOptions options;
  const Program self = {program, "Render a scene with all the ranks of one mpirun",
                        "parray-mpi " PARRAY_VERSION, speaks, "mpirun -n P "};
  return run_main(self, argc, argv, [&](CommandLine& line) {
    options.add_to(line);
    return [&] { return render(options); };
  });
}
