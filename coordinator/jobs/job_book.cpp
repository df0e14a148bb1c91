#include "coordinator/jobs/job_book.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <limits>
#include <new>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/bytes.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/image/image.h"
#include "common/image/picture_bytes.h"
#include "common/scene/settings.h"
#include "coordinator/disputes/dispute_desk.h"
#include "coordinator/jobs/replaying.h"
#include "coordinator/jobs/report.h"
#include "coordinator/loop/farm.h"
#include "coordinator/loop/worker_desk.h"

namespace parray::coordinator {

using nlohmann::json;

std::vector<Job*> JobBook::frames_of(JobId series) {
  std::vector<Job*> frames;
  const JobIndex::Frames* listed = farm_.index.listed_as(series);
  if (listed != nullptr && listed->begin()->second->record.series_id == series) {
    for (const auto& [key, job] : *listed) {
      frames.push_back(job);
    }
  }
  return frames;
}

json JobBook::summary_of(Time now, const Series& listed) const {
  const Job& first = *listed.front();
  if (first.record.series_id == 0) {
    return job_summary(first, now, waits_for(first));
  }
  const Job* open = first_unfinished(listed);
  return series_summary(listed, now, open == nullptr ? "" : waits_for(*open));
}

JobThread::Guarded JobBook::for_job(const Job& job, const std::string& doing) {
  return farm_.job_thread.guarded(
      [this, doing, id = job.record.id, generation = job.work->generation](const std::string& why) {
        if (Job* there = farm_.job_at_work(id, generation)) {
          fail_job(*there, doing + ": " + why);
        }
      });
}

/// The next grant rebuilds the queue, once for all changes.
void JobBook::list_open_jobs() {
  farm_.queue_again_at = Time(0);
  farm_.grants_due = true;
}

void JobBook::restore_jobs() {
  if (farm_.store == nullptr) {
    return;
  }
  for (JobRecord& record : farm_.store->jobs()) {
    Job job;
    job.record = std::move(record);
    job.next_epoch = farm_.options.first_epoch;
    const JobId id = job.record.id;
    next_job_ = std::max({next_job_, id + 1, job.record.series_id + 1});
    if (job.record.series_id != 0) {
      series_[{job.record.user, job.record.series}] = job.record.series_id;
    }
    if (job.record.state == JobState::running) {
      job.record.state = JobState::queued;
    }
    job.phase = is_unfinished(job.record.state) ? JobPhase::waiting : JobPhase::ended;
    job.error = error_in(job.record.report);
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
  std::shared_ptr<JobPicture> picture;
  ScenePayload scene;
  std::vector<CellRange> missing;
  std::vector<std::uint64_t> passes;
  std::uint64_t samples = 0;
  std::uint64_t cells = 0;
  std::uint64_t expected_samples = 0;
  ErrorFigures error;
  bool complete = false;
  bool whole = false;
  std::string damage;  ///< of stored results; empty: none
  std::string failure;
};

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

void JobBook::prepare(Job& job) {
  job.phase = JobPhase::preparing;
  job.work = std::make_unique<JobWork>();
  job.work->generation = next_generation_++;
  farm_.at_work.insert(job.record.id);
  const auto prepared = std::make_shared<Prepared>();
  const auto tasks = for_job(job, "preparing the job");
  tasks.give([this, prepared, store = farm_.store, record = job.record, scene = job.scene,
              at = farm_.since_1970(farm_.now), id = job.record.id,
              generation = job.work->generation, waiting_counts = farm_.options.waiting_counts,
              judge = judge_of(job.record)]() mutable -> JobThread::Completion {
    Prepared& p = *prepared;
    try {
      if (store != nullptr) {
        auto bytes = store->scene(record.scene);
        if (!bytes) {
          throw RunError("the store lacks its scene: submit the job again");
        }
        scene = ScenePayload(Bulk::of(std::move(*bytes)));
      }
      p.scene = scene;
      const bool limited = record.settings->time_limit > 0;
      const bool touches = limited && may_touch(record.settings, waiting_counts);
      p.picture =
          std::make_shared<JobPicture>(record.settings, SceneFacts(*scene.scene()), record.passes,
                                       record.tile, !limited || touches, std::move(judge));
      if (touches) {
        touch(*p.picture);
      }
      TakenUp taken = take_up(*p.picture, store, id);
      p.complete = taken.complete;
      p.damage = std::move(taken.damage);
      keep_journal(*p.picture, store, id, begun_entries(*p.picture, at));
      record.passes = p.passes = p.picture->passes().begun();
      p.missing = p.picture->collector().missing();
      p.samples = p.picture->framebuffer().counts().samples;
      p.cells = p.picture->collector().done_cells();
      p.expected_samples = p.picture->passes().expected_samples();
      p.error = p.picture->passes().error();
      p.whole = p.picture->framebuffer().whole();
      if (store != nullptr) {
        store->put_job(record);
      }
    } catch (const std::bad_alloc&) {
      p.failure = "not enough memory for its picture: render fewer pixels or free memory";
    }
    return {[this, prepared, id, generation] { trace_prepared(id, generation, *prepared); }, {}};
  });
}

/// Begins tracing a prepared job, unless it has ended meanwhile.
void JobBook::trace_prepared(JobId id, std::uint64_t generation, const Prepared& prepared) {
  Job* job = farm_.job_at_work(id, generation);
  if (job == nullptr) {
    return;
  }
  if (!prepared.failure.empty()) {
    fail_job(*job, prepared.failure);
  } else {
    note_damaged_rows(*job, prepared.damage);
    begin_tracing(*job, prepared);
  }
}

void JobBook::begin_tracing(Job& job, const Prepared& prepared) {
  JobWork& work = *job.work;
  work.picture = prepared.picture;
  work.scene = prepared.scene;
  work.plan = prepared.picture->plan();
  work.pass = prepared.picture->passes().pass();
  work.samples = prepared.samples;
  work.cells = prepared.cells;
  work.whole = prepared.whole;
  work.expected_samples = prepared.expected_samples;
  job.record.passes = prepared.passes;
  job.error = prepared.error;
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
  // A decoded result stays below 32 MiB, so that no task takes long.
  constexpr std::uint64_t most_bytes = std::uint64_t{1} << 25;
  const std::uint64_t most_cells =
      most_bytes / record_bytes(work.plan->grid()->shape().cell_pixels);
  if (work.leases) {
    job.next_epoch = work.leases->next_epoch();
  }
  work.leases.emplace(ChunkSizer(job.record.settings->schedule, *work.plan, length),
                      prepared.missing, job.next_epoch, most_cells);
  farm_.grants_due = true;
  disputes_.retract_later_faulty(job);
  if (prepared.complete) {
    work.started = work.started == never ? farm_.now : work.started;
    if (work.tasks == 0) {  // else disputes_.note_retracted() finishes it
      finish_job(job);
    }
  }
}

void JobBook::restart_leases(Job& job, const WorkPlan& plan) {
  disputes_.referee().drop(job.work->generation);
  Prepared prepared;
  prepared.picture = job.work->picture;
  prepared.scene = job.work->scene;
  prepared.missing = {{0, plan.cells()}};
  for (auto& [peer, worker] : farm_.workers) {
    worker.held -= job.work->leases->held_by(worker.id);  // heartbeats revoke them
  }
  begin_tracing(job, prepared);
}

void JobBook::end_pass_if_done(Job& job) {
  if (!job.tracing() || job.work->tasks > 0 || job.work->cells < job.work->plan->cells()) {
    return;
  }
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
        "{} of its leases were not checked: neither another machine nor the referee could trace "
        "them again",
        work.unchecked);
    farm_.note(job, job.record.flag);
  }
  if (job.record.settings->has_passes()) {
    next_pass(job);
  } else {
    finish_job(job);
  }
}

/// Lets the job thread decide on the next pass, which may depend on the sums.
void JobBook::next_pass(Job& job) {
  job.phase = JobPhase::preparing;
  job.work->pass_ended = farm_.now;
  const auto prepared = std::make_shared<Prepared>();
  prepared->scene = job.work->scene;
  const auto tasks = for_job(job, "planning the next pass");
  tasks.give([this, prepared, store = farm_.store, record = job.record, id = job.record.id,
              picture = job.work->picture, times = job.times(farm_.now),
              at = farm_.since_1970(farm_.now),
              generation = job.work->generation]() mutable -> JobThread::Completion {
    Prepared& p = *prepared;
    p.picture = picture;
    try {
      p.complete = !picture->begin_pass(times);
      keep_journal(*picture, store, id, begun_entries(*picture, at));
      p.passes = record.passes = picture->passes().begun();
      p.missing = picture->collector().missing();
      p.samples = picture->framebuffer().counts().samples;
      p.cells = picture->collector().done_cells();
      p.expected_samples = picture->passes().expected_samples();
      p.error = picture->passes().error();
      p.whole = picture->framebuffer().whole();
      if (store != nullptr && !p.complete) {
        store->put_job(record);
      }
    } catch (const std::bad_alloc&) {
      p.failure = "not enough memory to plan the next pass: render fewer pixels or free memory";
    }
    return {[this, prepared, id, generation] { trace_prepared(id, generation, *prepared); }, {}};
  });
}

void JobBook::finish_job(Job& job) {
  job.phase = JobPhase::finishing;
  job.work->facts.render_seconds = to_seconds(farm_.now - job.work->started);
  struct LeaseResult {
    PicturePayload picture;
    std::uint64_t bytes = 0;
    std::string report;
    std::vector<JobEvent> events;
    std::string journal;
    std::string failure;
    std::string full;  ///< why the store cannot commit it now; empty: it can
  };
  const auto finished = std::make_shared<LeaseResult>();
  const auto tasks = for_job(job, "finishing the picture");
  tasks.give([this, finished, store = farm_.store, record = job.record, id = job.record.id,
              picture = job.work->picture, facts = job.work->facts,
              clock = farm_.options.wall_clock, ended = std::max(farm_.uptime(), 1.0),
              generation = job.work->generation]() mutable -> JobThread::Completion {
    try {
      auto made = finish_picture(*picture, record, facts);
      finished->report = made.report;
      record.report = std::move(made.report);
      record.state = JobState::done;
      record.reason.clear();
      record.note(clock(), "done");
      record.ended = ended;
      finished->events = record.events;
      const auto& parts = made.picture;
      finished->bytes =
          picture_size(parts.image.width, parts.image.height, kept_detail(picture->settings()));
      if (store != nullptr) {
        // Unknown half-widths are infinite.
        made.picture.statistics.half_width.resize(parts.image.rgb.size(),
                                                  std::numeric_limits<float>::infinity());
        auto pieces = picture_pieces(parts.image, parts.statistics);
        pieces.push_back(picture->journal().bytes());  // after the part that all fetches read
        store->put_picture(id, pieces);
        store->put_job(record);
        store->drop_work(id);
      } else {
        finished->journal = picture->journal().bytes();
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
      Job* there = farm_.job_at_work(id, generation);
      if (there == nullptr) {
        return;
      }
      if (!finished->full.empty()) {
        there->retry_at = farm_.now + seconds(1);
        there->pause_reason = finished->full;
        return;
      }
      if (!finished->failure.empty()) {
        fail_job(*there, finished->failure);
        return;
      }
      there->record.report = finished->report;
      there->error = error_in(finished->report);
      there->record.events = finished->events;
      if (farm_.store == nullptr) {
        there->picture = finished->picture;
        there->picture_bytes = finished->bytes + finished->journal.size();
        there->journal = std::move(finished->journal);
      }
      close_job(*there, JobState::done, "");
    };
    if (!finished->full.empty() || !finished->failure.empty()) {
      return {outcome, {}};
    }
    return {{}, outcome};
  });
}

/// Ends a job. Keeps its record, its picture and, while there is room, what a requeue needs. The
/// caller calls list_open_jobs().
void JobBook::end_job(Job& job, JobState state, const std::string& reason) {
  job.record.state = state;
  job.record.reason = reason;
  job.phase = JobPhase::ended;
  job.pause_reason.clear();
  if (job.work) {
    disputes_.referee().drop(job.work->generation);
  }
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
    job.scene = {};  // only its record and picture stay
  } else {
    farm_.note(job, fmt::format("{}: {}", name_of(state), reason));
    farm_.keep(job);
  }
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

PictureJudge JobBook::judge_of(const JobRecord& record) const {
  return record.settings->target_denoised && farm_.options.judge_of ? farm_.options.judge_of(record)
                                                                    : PictureJudge{};
}

}  // namespace parray::coordinator
