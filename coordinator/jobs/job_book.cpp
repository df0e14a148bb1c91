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
#include "coordinator/jobs/report.h"
#include "coordinator/jobs/taking_up.h"
#include "coordinator/loop/farm.h"
#include "coordinator/loop/worker_desk.h"

namespace parray::coordinator {

using nlohmann::json;

/// The frames of a series, by number; none: there is no such series.
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

/// The job map of what is listed: a job, or a series.
json JobBook::summary_of(Time now, const Series& listed) const {
  const Job& first = *listed.front();
  if (first.record.series_id == 0) {
    return job_summary(first, now, waits_for(first));
  }
  const Job* open = first_unfinished(listed);
  return series_summary(listed, now, open == nullptr ? "" : waits_for(*open));
}

/// For errands of the job's present work: if one throws, the job fails. `doing` says what it does.
Backroom::Guarded JobBook::for_job(const Job& job, const std::string& doing) {
  return farm_.backroom.guarded(
      [this, doing, id = job.record.id, generation = job.work->generation](const std::string& why) {
        if (Job* there = farm_.job_at_work(id, generation)) {
          fail_job(*there, doing + ": " + why);
        }
      });
}

/// Jobs have come, ended or changed: before the next grant the queue is made anew, once for all.
void JobBook::list_open_jobs() {
  farm_.queue_again_at = Time(0);
  farm_.grants_due = true;
}

/// Only the records are read; pictures under way are taken up when their turn comes.
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
    farm_.log->info("{} unfinished jobs taken up", farm_.index.open().size());
  }
}

/// What the backroom has made ready for tracing.
struct JobBook::Prepared {
  std::shared_ptr<JobPicture> picture;
  SceneParcel scene;
  std::vector<CellRange> missing;
  std::vector<std::uint64_t> passes;
  std::uint64_t samples = 0;
  std::uint64_t cells = 0;
  std::uint64_t expected_samples = 0;
  ErrorFigures error;
  bool complete = false;
  bool whole = false;
  std::string damage;  ///< of kept rows; empty: none
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

/// Whether there is time for the system to clear the memory of a picture with a time limit.
static bool may_touch(const RenderSettings& settings, bool waiting_counts) {
  constexpr double byte_seconds = 2.5e-9;  // of a virtual machine that has not had it yet
  const double bytes =
      static_cast<double>(Framebuffer::pixel_bytes) * settings.width * settings.height;
  return !waiting_counts ||
         bytes * byte_seconds / static_cast<double>(touching_threads()) < settings.time_limit / 6;
}

/// Gives a job the memory that it needs.
void JobBook::prepare(Job& job) {
  job.phase = JobPhase::preparing;
  job.work = std::make_unique<JobWork>();
  job.work->generation = next_generation_++;
  farm_.at_work.insert(job.record.id);
  const auto prepared = std::make_shared<Prepared>();
  const auto errands = for_job(job, "taking it up");
  errands.give([this, prepared, store = farm_.store, record = job.record, scene = job.scene,
                at = farm_.since_1970(farm_.now), id = job.record.id,
                generation = job.work->generation, waiting_counts = farm_.options.waiting_counts,
                judge = judge_of(job.record)]() mutable -> Backroom::Outcome {
    Prepared& p = *prepared;
    try {
      if (store != nullptr) {
        auto bytes = store->scene(record.scene);
        if (!bytes) {
          throw RunError("its scene is missing");
        }
        scene = SceneParcel(Bulk::of(std::move(*bytes)));
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
      p.failure = "not enough memory for its picture";
    }
    return {[this, prepared, id, generation] { trace_prepared(id, generation, *prepared); }, {}};
  });
}

/// Of a job that may have ended meanwhile.
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
  // No more than a few thousand leases a second, however many workers there are.
  LeaseLength length = farm_.options.lease_length;
  constexpr double most_leases = 4000;
  length.longest =
      std::max(length.longest, static_cast<double>(farm_.workers.size()) / most_leases);
  // A result stays below 32 MiB as the collector has it, so that no errand takes long.
  constexpr std::uint64_t most_bytes = std::uint64_t{1} << 25;
  const std::uint64_t most_cells =
      most_bytes / record_bytes(work.plan->grid()->shape().cell_pixels);
  if (work.leases) {
    job.next_epoch = work.leases->next_epoch();
  }
  work.leases.emplace(ChunkSizer(job.record.settings->schedule, *work.plan, length),
                      prepared.missing, job.next_epoch, most_cells);
  farm_.grants_due = true;
  disputes_.retract_later_convicted(job);
  if (prepared.complete) {
    work.started = work.started == never ? farm_.now : work.started;
    if (work.errands == 0) {  // else disputes_.note_retracted() looks at it again
      finish_job(job);
    }
  }
}

/// All of it is to be traced once more.
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
  if (!job.tracing() || job.work->errands > 0 || job.work->cells < job.work->plan->cells()) {
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
        "{} of its leases were to be checked, and neither another machine nor the referee could",
        work.unchecked);
    farm_.note(job, job.record.flag);
  }
  if (job.record.settings->has_passes()) {
    next_pass(job);
  } else {
    finish_job(job);
  }
}

/// The sums of one pass may decide the next.
void JobBook::next_pass(Job& job) {
  job.phase = JobPhase::preparing;
  job.work->pass_ended = farm_.now;
  const auto prepared = std::make_shared<Prepared>();
  prepared->scene = job.work->scene;
  const auto errands = for_job(job, "deciding on its next pass");
  errands.give([this, prepared, store = farm_.store, record = job.record, id = job.record.id,
                picture = job.work->picture, times = job.times(farm_.now),
                at = farm_.since_1970(farm_.now),
                generation = job.work->generation]() mutable -> Backroom::Outcome {
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
      p.failure = "not enough memory to decide on its next pass";
    }
    return {[this, prepared, id, generation] { trace_prepared(id, generation, *prepared); }, {}};
  });
}

/// Image, error and report are made; the job is done once they are kept.
void JobBook::finish_job(Job& job) {
  job.phase = JobPhase::finishing;
  job.work->facts.render_seconds = to_seconds(farm_.now - job.work->started);
  struct Finished {
    PictureParcel picture;
    std::uint64_t bytes = 0;
    std::string report;
    std::vector<JobEvent> events;
    std::string journal;
    std::string failure;
    std::string full;  ///< why it cannot be kept now; empty: it can
  };
  const auto finished = std::make_shared<Finished>();
  const auto errands = for_job(job, "finishing its picture");
  errands.give([this, finished, store = farm_.store, record = job.record, id = job.record.id,
                picture = job.work->picture, facts = job.work->facts,
                clock = farm_.options.wall_clock, ended = std::max(farm_.uptime(), 1.0),
                generation = job.work->generation]() mutable -> Backroom::Outcome {
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
        // Nothing is known of them where there are none.
        made.picture.statistics.half_width.resize(parts.image.rgb.size(),
                                                  std::numeric_limits<float>::infinity());
        auto pieces = picture_pieces(parts.image, parts.statistics);
        pieces.push_back(picture->journal().bytes());  // behind what everybody reads
        store->put_picture(id, pieces);
        store->put_job(record);
        store->drop_work(id);
      } else {
        finished->journal = picture->journal().bytes();
        finished->picture =
            PictureParcel(std::make_shared<const PictureParts>(std::move(made.picture)));
      }
    } catch (const StorageFull& full) {
      finished->full = full.what();
    } catch (const std::bad_alloc&) {
      finished->failure = "not enough memory to finish its picture";
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

/// A job that has ended needs nothing but its record, and its picture; or, while there is room,
/// what it takes to go on after all. The list of open jobs is the caller's.
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
    job.scene = {};  // its record is kept, with its picture
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
