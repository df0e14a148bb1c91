#include "coordinator/jobs/job_book.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <new>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/scene/settings.h"
#include "coordinator/disputes/dispute_desk.h"
#include "coordinator/jobs/report.h"
#include "coordinator/loop/worker_desk.h"

namespace parray::coordinator {

using nlohmann::json;

std::vector<Job*> JobBook::frames_of(JobId series) const {
  std::vector<Job*> frames;
  const JobIndex::Frames* listed = farm_.index.listed_as(series);
  if (listed != nullptr && listed->begin()->second->record.series_id == series) {
    for (const auto& [key, job] : *listed) frames.push_back(job);
  }
  return frames;
}

void JobBook::for_job(const Job& job, const std::string& doing, JobThread::Task task) {
  farm_.job_thread.give(
      std::move(task),
      [this, doing, id = job.record.id, generation = job.work->generation](const std::string& why) {
        if (Job* there = farm_.job_at_work(id, generation)) fail_job(*there, doing + ": " + why);
      });
}

/// The next grant rebuilds the queue, once for all changes.
void JobBook::list_open_jobs() {
  farm_.queue_again_at = Time(0);
  ++farm_.queue_changes;
  farm_.grants_due = true;
}

/// Returns when a job with these events was submitted or queued again, whichever is later.
/// Negative: it has had a lease since then, or the time is not known.
static double queued_at(const std::vector<JobEvent>& events) {
  for (auto event = events.rbegin(); event != events.rend(); ++event) {
    const std::string& what = event->what;
    if (what == "started" || what == "continued") return -1;
    if (what.starts_with("submitted") || what.starts_with("queued again")) return event->at;
  }
  return -1;
}

void JobBook::restore_jobs() {
  if (farm_.store == nullptr) return;
  for (JobRecord& record : farm_.store->jobs()) {
    Job job;
    job.record = std::move(record);
    job.next_epoch = farm_.options.first_epoch;
    const JobId id = job.record.id;
    next_job_ = std::max({next_job_, id + 1, job.record.series_id + 1});
    if (job.record.series_id != 0) {
      series_[{job.record.user, job.record.series}] = job.record.series_id;
    }
    const bool may_have_waited =
        job.record.state == JobState::queued || job.record.state == JobState::paused;
    if (may_have_waited) job.queued_at = queued_at(job.record.events);
    if (job.record.state == JobState::running) job.record.state = JobState::queued;
    job.phase = is_unfinished(job.record.state) ? JobPhase::waiting : JobPhase::ended;
    job.stored = true;
    job.read_report();
    if (!job.ended() && job.record.course.started > 0) {
      farm_.note(job, "the coordinator was started again");
    }
    farm_.index.add(farm_.jobs.emplace(id, std::move(job)).first->second);
  }
  restore_farm_notes();
  list_open_jobs();
  if (!farm_.index.open().empty()) {
    farm_.log->info("resumed {} unfinished jobs", farm_.index.open().size());
  }
}

/// What the job thread has prepared for tracing.
struct JobBook::Prepared {
  ScenePayload scene;
  std::uint64_t spheres = 0;  ///< see Job; 0: counted before
  RunState state;
  std::vector<CellRange> missing;
  /// Cells whose checks an earlier run did not finish.
  std::vector<ResultCollector::Unchecked> unchecked;
  bool complete = false;  ///< the picture is complete, and there is no pass to trace
  std::string damage;     ///< of stored results; empty: none
  std::string failure;
};

/// A decoded result stays below 32 MiB, so that no task takes long.
static std::uint64_t most_cells_of_result(const WorkPlan& plan) {
  constexpr std::uint64_t most_bytes = std::uint64_t{1} << 25;
  return most_bytes / record_bytes(plan.grid()->shape().cell_pixels);
}

static std::size_t touching_threads() {
  return static_cast<std::size_t>(std::clamp(usable_cpus(), 1, 4));
}

static void touch(JobPicture& picture) {
  std::vector<std::jthread> threads;
  for (std::size_t part = 0; part < touching_threads(); ++part) {
    threads.emplace_back([&picture, part] { picture.touch(part, touching_threads()); });
  }
}

/// Returns whether the time limit leaves time to clear the memory of the picture in advance.
static bool may_touch(const RenderSettings& settings, bool waiting_counts) {
  constexpr double byte_seconds = 2.5e-9;  // on a virtual machine that uses the page the first time
  const double bytes =
      static_cast<double>(Framebuffer::pixel_bytes) * settings.width * settings.height;
  return !waiting_counts ||
         bytes * byte_seconds / static_cast<double>(touching_threads()) < settings.time_limit / 6;
}

/// Returns the cells of the current pass that are not checked, in ranges for checks: all cells, or
/// those whose check was drawn.
static std::vector<ResultCollector::Unchecked> unchecked_of(const JobPicture& picture, bool all) {
  constexpr std::uint64_t checks = 256;  // so that many workers can share a whole picture
  if (!picture.has_begun()) return {};
  const WorkPlan& plan = *picture.plan();
  const ResultCollector& collector = picture.collector();
  const auto most = std::clamp<std::uint64_t>(plan.cells() / checks, 1, most_cells_of_result(plan));
  return all ? collector.unchecked_cells(most) : collector.wanted_cells(most);
}

/// Returns the scene with this SHA-256. Throws RunError if the store lacks it.
static ScenePayload stored_scene(Store& store, const std::string& digest) {
  auto bytes = store.scene(digest);
  if (!bytes) throw RunError("the store lacks its scene: submit the job again");
  return ScenePayload(Bulk::of(std::move(*bytes)));
}

void JobBook::prepare(Job& job) {
  job.work = std::make_unique<JobWork>();
  job.work->generation = next_generation_++;
  job.work->run = std::make_shared<JobRun>(job.record, farm_.store);
  farm_.at_work.insert(job.record.id);
  prepare_pass(
      job, "preparing the job", "for its picture",
      [store = farm_.store, scene = job.scene, at = farm_.since_1970(farm_.now),
       waiting_counts = farm_.options.waiting_counts, checks = farm_.options.checks.share,
       judge = job.record.settings->target_denoised && farm_.options.judge_of
                   ? farm_.options.judge_of(job.record)
                   : PictureJudge{}](JobRun& run, Prepared& prepared) {
        const RenderSettings& settings = run.record().settings;
        prepared.scene = store != nullptr ? stored_scene(*store, run.record().scene) : scene;
        const bool limited = settings.time_limit > 0;
        const bool touches = limited && may_touch(settings, waiting_counts);
        run.create_picture(SceneFacts(*prepared.scene.scene()), !limited || touches, judge);
        prepared.spheres = run.picture().scene().requirements.shapes();
        if (touches) touch(run.picture());
        prepared.damage = run.replay(JobRun::OnDamage::cut);
        if (checks > 0) prepared.unchecked = unchecked_of(run.picture(), checks >= 1);
        if (prepared.unchecked.empty()) {  // else the checks belong to the current pass
          prepared.complete = !run.begin_pass({}, at);
        }
      });
}

void JobBook::prepare_pass(Job& job, const std::string& doing, const std::string& purpose,
                           std::function<void(JobRun&, Prepared&)> step) {
  job.phase = JobPhase::preparing;
  const auto prepared = std::make_shared<Prepared>();
  prepared->scene = job.work->scene;
  auto task = [this, prepared, purpose, step = std::move(step), run = job.work->run,
               record = job.record,
               generation = job.work->generation]() mutable -> JobThread::Completion {
    const JobId id = record.id;
    try {
      run->put(std::move(record));
      step(*run, *prepared);
      prepared->state = run->state();
      prepared->missing = run->picture().collector().missing();
    } catch (const std::bad_alloc&) {
      prepared->failure = "not enough memory " + purpose + ": render fewer pixels or free memory";
    }
    return {[this, prepared, id, generation] {
      if (Job* there = farm_.job_at_work(id, generation)) trace_prepared(*there, *prepared);
    }};
  };
  for_job(job, doing, std::move(task));
}

void JobBook::trace_prepared(Job& job, Prepared& prepared) {
  if (!prepared.failure.empty()) {
    fail_job(job, prepared.failure);
    return;
  }
  if (const std::string& damage = prepared.damage; !damage.empty()) {
    farm_.note(job, "stored results are damaged and will be traced again: " + damage);
    farm_.log->warn("job {}: {}: workers will trace the rest again", job.record.id, damage);
    farm_.keep(job);
  }
  JobWork& work = *job.work;
  work.scene = std::move(prepared.scene);
  job.spheres = std::max(job.spheres, prepared.spheres);
  begin_tracing(job, prepared.state, prepared.missing);
  for (const auto& [range, tracer] : prepared.unchecked) {
    work.leases->want_check({range, 0, {tracer}});  // place_orphans() finds a machine
  }
  if (!prepared.complete) {
    end_pass_if_done(job);       // only checks may remain: no result would call this
  } else if (work.tasks == 0) {  // else disputes_.note_retracted() finishes it
    finish_job(job);
  }
}

void JobBook::begin_tracing(Job& job, const RunState& state,
                            const std::vector<CellRange>& missing) {
  JobWork& work = *job.work;
  const bool began_again = state.samples < work.samples;
  const bool next_pass = work.pass_ended != never;
  work.pass_progress = began_again ? 0 : job.progress(farm_.now);
  static_cast<RunState&>(work) = state;
  work.pass_samples = state.samples;
  job.record.passes = state.passes;
  if (state.error.known() || began_again) job.record.course.error = state.error;
  job.phase = JobPhase::tracing;
  if (job.record.settings->in_passes() && work.started != never) {
    work.deciding = work.pass_ended == never ? 0 : to_seconds(farm_.now - work.pass_ended);
    work.facts.deciding_seconds += work.deciding;
    work.pass_began = farm_.now;
    work.pass_ended = never;
  }
  // A limit of a few thousand leases per second, however many workers there are.
  LeaseLength length = farm_.options.lease_length;
  constexpr double most_leases = 4000;
  length.longest =
      std::max(length.longest, static_cast<double>(farm_.workers.size()) / most_leases);
  if (work.leases) job.next_epoch = work.leases->next_epoch();
  work.leases.emplace(ChunkSizer(job.record.settings->schedule, *work.plan, length), missing,
                      job.next_epoch, most_cells_of_result(*work.plan));
  farm_.grants_due = true;
  const bool traced =
      work.started != never || next_pass;  // since the last start of the coordinator
  if (state.error.known() && traced && work.pass > 0) note_error(job, work.samples);
  disputes_.retract_later_faulty(job);
}

void JobBook::restart_leases(Job& job, const RunState& state) {
  disputes_.referee().drop(job.work->generation);
  for (auto& [peer, worker] : farm_.workers) {
    worker.held -= job.work->leases->held_by(worker.id);  // heartbeats revoke them
  }
  begin_tracing(job, state, {{0, state.plan->cells()}});
}

void JobBook::end_pass_if_done(Job& job) {
  if (!job.tracing() || job.work->tasks > 0 || job.work->cells < job.work->plan->cells()) return;
  JobWork& work = *job.work;
  disputes_.place_orphans(job);
  if (work.leases->checks_remain() || disputes_.referee().busy_with(work.generation) ||
      (disputes_.referee().may_check(farm_.now) &&
       disputes_.referee().checks(work.generation) > 0)) {
    return;
  }
  work.unchecked += disputes_.referee().drop_checks(work.generation);
  if (work.unchecked > 0 && job.record.flag.empty()) {
    job.record.flag = fmt::format(
        "{} of its leases were not checked completely: neither another machine nor the referee "
        "could trace all their cells again",
        work.unchecked);
    farm_.note(job, job.record.flag);
  }
  if (!job.record.settings->has_passes()) {
    finish_job(job);
    return;
  }
  work.pass_ended = farm_.now;
  prepare_pass(  // the job thread decides on the next pass, which may depend on the sums
      job, "planning the next pass", "to plan the next pass",
      [times = job.times(farm_.now), at = farm_.since_1970(farm_.now)](
          JobRun& run, Prepared& prepared) { prepared.complete = !run.begin_pass(times, at); });
}

/// What the job thread has made of a complete picture.
struct JobBook::FinishedJob {
  PicturePayload picture;  ///< empty if a store has it, as the next two
  std::uint64_t bytes = 0;
  std::string journal;
  std::string report;
  std::vector<JobEvent> events;
  JobCourse course;
  std::string failure;
  std::string full;  ///< why the store cannot commit it now; empty: it can
};

/// Notes in the record of a run that its picture is complete. `at`: seconds since 1970.
static void note_done(JobRun& run, double at, const std::string& report) {
  JobCourse& course = run.record().course;
  const auto pixels = static_cast<double>(pixel_count(run.record().settings));
  course.finished = at;
  course.samples = run.picture().framebuffer().counts().samples;
  course.progress = 1;
  course.error = error_in(report);
  course.add({course.taken, static_cast<double>(course.samples) / pixels, course.error.rmse});
  run.record().note(at, "done");
}

void JobBook::finish_job(Job& job) {
  job.phase = JobPhase::finishing;
  const Time started = std::min(job.work->started, farm_.now);  // never: all came from the store
  job.work->facts.render_seconds = to_seconds(farm_.now - started);
  job.work->facts.samples_before = job.work->samples_before;
  job.count_time(farm_.now, false);
  const auto finished = std::make_shared<FinishedJob>();
  auto task = [this, finished, record = job.record, run = job.work->run, facts = job.work->facts,
               in_memory = farm_.store == nullptr, clock = farm_.options.wall_clock,
               ended = std::max(farm_.uptime(), 1.0),
               generation = job.work->generation]() mutable -> JobThread::Completion {
    const JobId id = record.id;
    try {
      run->put(std::move(record));
      FinishedPicture made = finish_picture(run->picture(), run->record(), facts);
      note_done(*run, clock(), made.report);
      run->record().ended = ended;
      const std::string& journal = run->picture().journal().bytes();
      run->finish(made.picture.image, made.picture.statistics, made.report, journal);
      finished->report = std::move(made.report);
      finished->events = run->record().events;
      finished->course = run->record().course;
      if (in_memory) {
        const RenderSettings& s = run->record().settings;
        finished->bytes = picture_size(s.width, s.height, kept_detail(s)) + journal.size();
        finished->journal = journal;
        finished->picture =
            PicturePayload(std::make_shared<const PictureParts>(std::move(made.picture)));
      }
    } catch (const StorageFull& full) {
      finished->full = full.what();
    } catch (const std::bad_alloc&) {
      finished->failure =
          "not enough memory to finish the picture: render fewer pixels or free memory";
    }
    const auto outcome = [this, finished, id, generation] {
      if (Job* there = farm_.job_at_work(id, generation)) note_finished(*there, *finished);
    };
    const bool made = finished->full.empty() && finished->failure.empty();
    return made ? JobThread::Completion{{}, outcome} : JobThread::Completion{outcome};
  };
  for_job(job, "finishing the picture", std::move(task));
}

void JobBook::note_finished(Job& job, FinishedJob& finished) {
  if (!finished.full.empty()) {
    job.retry_at = farm_.now + seconds(1);
    job.pause_reason = finished.full;
    return;
  }
  if (!finished.failure.empty()) {
    fail_job(job, finished.failure);
    return;
  }
  job.record.report = std::move(finished.report);
  job.record.events = std::move(finished.events);
  job.record.course = std::move(finished.course);
  job.read_report();
  job.picture = std::move(finished.picture);
  job.picture_bytes = finished.bytes;
  job.journal = std::move(finished.journal);
  close_job(job, JobState::done, "");
}

/// Keeps what an ended job shows of its work. A done job has it from finish_job().
void JobBook::note_end(Job& job, JobState state) {
  if (state == JobState::done) return;
  JobCourse& course = job.record.course;
  course.progress = job.progress(farm_.now);
  course.samples = job.samples();
  course.finished = farm_.wall_now();
  job.count_time(farm_.now, false);
}

/// Ends a job. Keeps its record, its picture and, while there is room, what a requeue needs. The
/// caller calls list_open_jobs().
void JobBook::end_job(Job& job, JobState state, const std::string& reason) {
  const std::shared_ptr<JobRun> run = job.work && job.has_picture() ? job.work->run : nullptr;
  note_end(job, state);
  job.record.state = state;
  job.record.reason = reason;
  job.phase = JobPhase::ended;
  job.pause_reason.clear();
  if (job.work) disputes_.referee().drop(job.work->generation);
  job.record.ended = std::max(farm_.uptime(), 1.0);
  if (job.work && job.work->leases) {
    job.next_epoch = job.work->leases->next_epoch();
    for (auto& [peer, worker] : farm_.workers) {
      worker.held -= job.work->leases->held_by(worker.id);  // heartbeats revoke them
    }
  }
  job.work.reset();
  farm_.at_work.erase(job.record.id);
  farm_.index.note_ended(job);
  if (state == JobState::done) {
    if (!job.record.keeps_scene()) job.scene = {};  // only its record and picture stay
  } else {
    const bool said = reason.starts_with(name_of(state));
    farm_.note(job, said ? reason : fmt::format("{}: {}", name_of(state), reason));
    farm_.keep(job);
    if (run && !job.stored) keep_unfinished(job, run);
  }
  farm_.announce_end(job);
  farm_.log->info("job {} '{}' is {}{}{}", job.record.id, job.record.name, name_of(state),
                  reason.empty() ? "" : ": ", reason);
}

void JobBook::close_job(Job& job, JobState state, const std::string& reason) {
  end_job(job, state, reason);
  list_open_jobs();
  worker_desk_.forget_scene(job.record.scene);
  make_room(0);
}

void JobBook::fail_job(Job& job, const std::string& reason) {
  close_job(job, JobState::failed, reason);
}

}  // namespace parray::coordinator
