#include <spdlog/spdlog.h>

#include "common/base/error.h"
#include "coordinator/jobs/job_book.h"

namespace parray::coordinator {

std::string JobBook::asker() const {
  return farm_.sender.name.empty() ? "a client" : "'" + farm_.sender.name + "'";
}

static InputError misfit(const Job& job, const char* rule) {
  return InputError(fmt::format("job {} is {}: {}", job.record.id, job.shown_state(), rule));
}

void JobBook::steer(Job& job, const msg::SteerJob& m) {
  using enum msg::JobAction;
  switch (m.action) {
    case pause: return this->pause(job, m.job);
    case resume: return this->resume(job);
    case cancel: return this->cancel(job);
    case requeue: return this->requeue(job);
    case prioritise: return this->prioritise(job, m.priority);
    case forget: break;
  }
  const JobId id = job.record.id;
  if (!job.ended()) throw InputError(fmt::format("job {0} has not ended yet: cancel it first", id));
  const JobId series = job.record.series_id;
  if (m.job == id && series != 0 && !has_ended(series_of(*farm_.index.listed_as(series)))) {
    throw InputError(
        fmt::format("job {} is a frame of series {}, which has not ended yet: cancel the series "
                    "first, or delete it as a whole",
                    id, series));
  }
}

/// Workers finish the leases that they hold. `named`: the number that the client used.
void JobBook::pause(Job& job, JobId named) {
  if (job.ended() || job.phase == JobPhase::finishing) {
    throw misfit(job, "only queued and running jobs can be paused");
  }
  if (job.record.state == JobState::paused) return;
  job.record.state = JobState::paused;
  job.record.reason = "paused by " + asker() + ": parray resume " + std::to_string(named);
  job.count_time(farm_.now, false);
  farm_.note(job, "paused by " + asker());
  farm_.keep(job);
  farm_.log->info("job {} '{}' is paused", job.record.id, job.record.name);
}

void JobBook::resume(Job& job) {
  if (job.record.state != JobState::paused) {
    if (job.shown_state() == name_of(JobState::paused)) {
      throw InputError(
          fmt::format("job {} continues by itself: no client has paused it; it waits: {}",
                      job.record.id, job.pause_reason));
    }
    throw misfit(job, "only paused jobs can be resumed");
  }
  job.record.state = job.work && job.work->started != never ? JobState::running : JobState::queued;
  job.record.reason.clear();
  job.count_time(farm_.now, job.record.state == JobState::running);
  farm_.note(job, "resumed by " + asker());
  farm_.keep(job);
  farm_.log->info("job {} '{}' is resumed", job.record.id, job.record.name);
}

void JobBook::cancel(Job& job) {
  if (job.ended()) throw misfit(job, "only unfinished jobs can be cancelled");
  end_job(job, JobState::cancelled, "cancelled by " + asker());
}

/// Queues a failed or cancelled job again. It continues from its stored results.
void JobBook::requeue(Job& job) {
  if (!job.ended() || job.record.state == JobState::done) {
    throw misfit(job, "only failed and cancelled jobs can be queued again");
  }
  if (farm_.store == nullptr && job.scene.size() == 0) {
    throw InputError(
        fmt::format("the coordinator no longer keeps the scene of job {}: submit the scene again",
                    job.record.id));
  }
  job.record.state = JobState::queued;
  job.record.reason.clear();
  if (farm_.store == nullptr) {
    job.record.passes = {};  // the results that determined them are gone
    job.record.course.forget_picture();
    job.picture = {};
    job.picture_bytes = 0;
  }
  job.phase = JobPhase::waiting;
  job.retry_at = never;
  job.queued_at = farm_.since_1970(farm_.now);
  farm_.index.note_open(job);
  farm_.note(job, "queued again by " + asker());
  farm_.keep(job);
  farm_.log->info("job {} '{}' is queued again", job.record.id, job.record.name);
}

void JobBook::prioritise(Job& job, std::uint32_t priority) {
  if (job.ended()) {
    throw InputError("job " + std::to_string(job.record.id) +
                     " has ended: only unfinished jobs have a priority");
  }
  job.record.priority = priority;
  farm_.note(job, fmt::format("priority {} by {}", priority, asker()));
  farm_.keep(job);
}

}  // namespace parray::coordinator
