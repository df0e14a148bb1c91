// The life of a job inside the coordinator: opened, restored, finished, closed.
#include <spdlog/spdlog.h>

#include <algorithm>

#include "common/base/bytes.h"
#include "common/base/error.h"
#include "common/image/image.h"
#include "coordinator/coordinator.h"

namespace parray {

Job* Coordinator::job_of(JobId id) {
  const auto found = jobs_.find(id);
  return found == jobs_.end() ? nullptr : &found->second;
}

void Coordinator::sort_open_jobs() {
  open_jobs_.clear();
  for (auto& [id, job] : jobs_) {
    if (job.open()) {
      open_jobs_.push_back(&job);
    }
  }
  std::stable_sort(open_jobs_.begin(), open_jobs_.end(), [](const Job* a, const Job* b) {
    return a->record.priority > b->record.priority;
  });
}

void Coordinator::restore_jobs() {
  for (JobRecord& record : store_.jobs()) {
    Job job;
    job.record = std::move(record);
    const JobId id = job.record.id;
    next_job_ = std::max(next_job_, id + 1);
    if (job.record.state == JobState::queued || job.record.state == JobState::running) {
      try {
        job.take_up(store_);
        log_->info("job {} '{}' taken up at {:.1f} %", id, job.record.name,
                   100 * job.work->leases.progress());
      } catch (const std::exception& error) {
        throw RunError("the state of job " + std::to_string(id) + " is damaged: " + error.what());
      }
    }
    jobs_.emplace(id, std::move(job));
  }
  sort_open_jobs();
  store_.commit();
}

/// Jobs of which an earlier life has kept everything but the picture.
void Coordinator::finish_complete_jobs(Time now) {
  const std::vector<Job*> open = open_jobs_;
  for (Job* job : open) {
    if (job->work->leases.done()) {
      job->work->started = now;
      finish_job(now, *job);
    }
  }
}

void Coordinator::finish_job(Time now, Job& job) {
  const FinishedPicture picture = finish_picture(job, now);
  job.record.report = picture.report.dump();
  store_.put_picture(job.record.id, picture_to_bytes(picture.image, picture.statistics));
  close_job(job, JobState::done, "");
}

void Coordinator::close_job(Job& job, JobState state, const std::string& reason) {
  job.record.state = state;
  job.record.reason = reason;
  job.work.reset();
  sort_open_jobs();
  store_.put_job(job.record);
  store_.drop_work(job.record.id);
  store_dirty_ = true;
  log_->info("job {} '{}' is {}{}{}", job.record.id, job.record.name, name_of(state),
             reason.empty() ? "" : ": ", reason);
}

/// Forgets the oldest closed job when there are too many.
void Coordinator::make_room_for_job() {
  if (jobs_.size() < options_.max_jobs) {
    return;
  }
  const auto oldest =
      std::find_if(jobs_.begin(), jobs_.end(), [](const auto& j) { return !j.second.open(); });
  if (oldest == jobs_.end()) {
    throw InputError("this coordinator has its " + std::to_string(options_.max_jobs) +
                     " jobs and none has ended: wait, cancel one, or raise --max-jobs");
  }
  log_->info("job {} '{}' forgotten to make room", oldest->first, oldest->second.record.name);
  store_.drop_job(oldest->first);
  store_dirty_ = true;
  jobs_.erase(oldest);
}

}  // namespace parray
