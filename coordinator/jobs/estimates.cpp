// Estimates for people: what jobs wait for and for how long, and how good their pictures are.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <tuple>

#include "common/scene/settings.h"
#include "coordinator/disputes/dispute_desk.h"
#include "coordinator/jobs/fair_queue.h"
#include "coordinator/jobs/job_book.h"

namespace parray::coordinator {

using nlohmann::json;

namespace {

/// Estimates the thread-seconds that a job still needs on `threads` threads.
double work_left(const Farm& farm, const Job& job, std::uint64_t threads) {
  const double price = job.work && job.work->price > 0 ? job.work->price : farm.price;
  const double work = job.samples_left(farm.now) * price;
  const double limit = job.record.settings->time_limit;
  const double most = limit * (1 - job.progress(farm.now)) * static_cast<double>(threads);
  return limit > 0 ? std::min(work, most) : work;
}

bool work_known(const Job& job) {
  return job.samples_known() || job.record.settings->time_limit > 0;
}

double gibibytes(std::uint64_t bytes) { return static_cast<double>(bytes) * 0x1p-30; }

/// Returns what all workers lack. Empty: at least one may trace.
std::string lacking_worker(const WorkerRegistry& workers) {
  if (workers.usable() > 0) return {};
  const bool held_back =
      std::ranges::any_of(workers, [](const auto& w) { return w.second.held_back; });
  return workers.size() == 0     ? "a worker (none is connected)"
         : workers.all_drained() ? "a worker (all are drained: readmit one with parray workers "
                                   "readmit NAME, or a drained host with parray workers readmit "
                                   "HOST --host)"
         : held_back
             ? "a worker (none gets leases now: each has failed at a lease that another traced, or "
               "is drained or in quarantine: see parray workers)"
             : "a worker (all are drained or in quarantine: see parray workers, then readmit one)";
}

void add_wait(json& summary, const JobBook::Wait& wait) {
  summary["waits_for_job"] = wait.job == 0 ? json() : json(wait.job);
  summary["queue_place"] = wait.place == 0 ? json() : json(wait.place);
  summary["starts_in"] = wait.starts_in ? json(*wait.starts_in) : json();
}

/// Estimates per look of the housekeeping. Each reads about some_pixels pixels, which takes at most
/// 20 ms, so that they take less than 2 % of the job thread's time.
constexpr std::size_t most_estimates = 4;
constexpr std::size_t some_pixels = std::size_t{1} << 16;
/// Number of waiting tasks of the job thread from which nothing is estimated.
constexpr std::size_t busy_backlog = 64;
/// A picture gets a new estimate when it has this many times the samples.
constexpr double growth = 1.05;
/// Under a shorter time limit, every moment of the job thread counts.
constexpr double short_limit = 60;
/// Least time between two estimates of a picture that is rendered only in part.
constexpr Time part_interval = seconds(2);

bool wants_estimate(const Job& job, Time now) {
  const RenderSettings& s = job.record.settings;
  if (!job.tracing() || job.record.state == JobState::paused || s.target_error > 0 ||
      s.target_half_width > 0) {
    return false;
  }
  const auto& curve = job.record.course.curve;
  if (curve.empty() && job.work->error_at != never && now - job.work->error_at < part_interval) {
    return false;
  }
  return job.samples_a_pixel() >=
             std::max(curve.empty() ? 0 : growth * curve.back().samples, 2.0) &&
         (s.time_limit == 0 || s.time_limit >= short_limit);
}

/// Estimates the error from some rows of a large picture: that of the whole picture or, while some
/// pixels have fewer than two samples, that of the other pixels.
PartialError error_of_some_rows(const JobPicture& picture) {
  constexpr std::size_t least_stride = 8;  // a smaller stride reads nearly all rows
  const FramebufferView view = picture.view();
  const std::size_t part = view.pixels.size() / some_pixels;
  const std::size_t stride = part < 2 ? 1 : std::max(part, least_stride);
  const ErrorEstimate whole = estimate_error(view, stride);
  return whole.known() ? PartialError{whole, 1} : estimate_rmse_so_far(view, stride);
}

}  // namespace

json JobBook::summary_of(Time now, const Series& listed) {
  const Job& first = *listed.front();
  if (first.record.series_id == 0) return summary_of(now, first);
  const Job* open = first_unfinished(listed);
  const Wait wait = open == nullptr ? Wait{} : series_wait(*open);
  json summary = series_summary(listed, now, wait.what);
  add_wait(summary, wait);
  return summary;
}

json JobBook::summary_of(Time now, const Job& job) {
  const Wait wait = wait_of(job);
  json summary = job_summary(job, now, wait.what);
  add_wait(summary, wait);
  return summary;
}

/// Returns what keeps this job, and probably others, from being traced, apart from the queue.
JobBook::Wait JobBook::general_wait(const Job& job) {
  if (job.ended() || job.record.state == JobState::paused) return {};
  if (!farm_.storage.empty()) return {"storage (" + farm_.storage + ")"};
  if (job.phase == JobPhase::finishing || job.phase == JobPhase::preparing) return {};
  const std::string worker = lacking_worker(farm_.workers);
  if (!worker.empty()) return {worker};
  const std::uint64_t needed = job.phase == JobPhase::waiting ? memory_of(job) : 0;
  if (needed > farm_.options.memory) {
    return {fmt::format(
        "a coordinator with more memory: the job needs {:.3f} GiB, and --memory is {:.3f}",
        gibibytes(needed), gibibytes(farm_.options.memory))};
  }
  if (needed > 0 && means().memory + needed > farm_.options.memory) {
    const auto largest = std::ranges::max_element(
        farm_.at_work, {}, [this](JobId id) { return memory_of(farm_.jobs.at(id)); });
    if (largest == farm_.at_work.end()) {
      return {"memory (pictures and scenes that are being sent use it now)"};
    }
    const JobId holder = farm_.jobs.at(*largest).record.listed_as();
    return {fmt::format("memory that job {} uses", holder), holder};
  }
  return {job.work ? disputes_.referee().wait(farm_.now, job.work->generation) : ""};
}

/// Returns the place in the queue of a job or series.
JobBook::Wait JobBook::queue_wait(const Job& job) {
  if (job.ended() || job.record.state == JobState::paused) return {};
  renew_outlook();
  const QueueOutlook::Place* place = outlook_.of(job.record.listed_as());
  if (place == nullptr || (job.begun() && place->behind == 0)) {  // the places may be a second old
    return {};
  }
  Wait wait{"", place->behind, place->number, place->starts_in};
  if (place->behind != 0) {
    wait.what = fmt::format("job {} of priority {}", place->behind, place->priority_behind);
  } else if (!means().room) {
    wait.what = "a worker (all are busy)";
  }
  return wait;
}

JobBook::Wait JobBook::series_wait(const Job& first_unfinished) {
  Wait queue = queue_wait(first_unfinished);
  const Wait general = general_wait(first_unfinished);
  if (!general.what.empty()) {
    queue.what = general.what;
    queue.job = general.job;
  }
  return queue;
}

JobBook::Wait JobBook::wait_of(const Job& job) {
  Wait wait = series_wait(job);
  const bool queued = !job.ended() && job.phase == JobPhase::waiting &&
                      job.record.state != JobState::paused && job.record.series_id != 0;
  if (queued && wait.what.empty() && wait.place == 0) {  // other frames of it are being traced
    wait.what = fmt::format("other frames of series {}", job.record.series_id);
    wait.job = job.record.series_id;
  }
  return wait;
}

/// Counts once in a turn, because a list may need it for a thousand jobs.
const JobBook::Means& JobBook::means() {
  if (means_.at != farm_.now) {
    const bool room = std::ranges::any_of(
        farm_.workers, [](const auto& worker) { return worker.second.has_room(); });
    means_ = {farm_.now, memory_in_use(), room};
  }
  return means_;
}

/// Makes the outlook again if it is a second old, or a tenth of a second and jobs have changed.
void JobBook::renew_outlook() {
  const bool changed = outlook_of_changes_ != farm_.queue_changes;
  if (outlook_at_ != never &&
      farm_.now - outlook_at_ < (changed ? milliseconds(100) : milliseconds(1000))) {
    return;
  }
  outlook_at_ = farm_.now;
  outlook_of_changes_ = farm_.queue_changes;
  const std::uint64_t threads = farm_.workers.speed().threads;
  std::map<JobId, QueueOutlook::Entry> entries;
  for (const JobId id : farm_.index.open()) {
    const Job& job = farm_.jobs.at(id);
    if (job.record.state == JobState::paused || job.phase == JobPhase::finishing) continue;
    QueueOutlook::Entry& entry = entries[job.record.listed_as()];
    if (entry.id == 0) {
      const double waited = job.served == never ? 0 : to_seconds(farm_.now - job.served);
      entry.id = job.record.listed_as();
      entry.user = job.record.user;
      entry.share = job.record.share;
      entry.priority = job.record.priority;
      entry.until_starving = std::max(0.0, FairQueue::starving_after - waited);
    }
    entry.begun = entry.begun || job.begun();
    entry.work_left += work_left(farm_, job, threads);
    entry.work_known = entry.work_known && work_known(job);
  }
  std::vector<QueueOutlook::Entry> jobs;
  jobs.reserve(entries.size());
  for (auto& [id, entry] : entries) jobs.push_back(std::move(entry));
  const bool measured = farm_.tally.accepted > 0;
  outlook_.assign(jobs, measured ? static_cast<double>(threads) : 0,
                  farm_.options.lease_length.longest);
}

/// Gives a job whose forecast exceeds a day a warning, once. A coordinator cannot ask its user.
void JobBook::warn_of_long_jobs() {
  constexpr double day = 86400;
  constexpr double enough = 60;  // seconds of tracing that a forecast without passes needs
  const std::uint64_t threads = farm_.workers.speed().threads;
  for (const JobId id : farm_.at_work) {
    Job& job = farm_.jobs.at(id);
    const RenderSettings& settings = job.record.settings;
    if (!job.record.warning.empty() || threads == 0 || !job.tracing() || !job.begun() ||
        job.work->price <= 0 || !job.samples_known() || settings.time_limit > 0) {
      continue;
    }
    const bool judged = settings.in_passes() ? job.work->pass > 0
                                             : to_seconds(farm_.now - job.work->started) > enough;
    const double left = work_left(farm_, job, threads) / static_cast<double>(threads);
    if (!judged || left <= day) continue;
    job.record.warning = fmt::format(
        "needs about {:.0f} days of all {} present threads: cancel it, or submit it with {}",
        left / day, threads,
        settings.in_passes() ? "a larger target or a time limit" : "fewer samples or pixels");
    farm_.note(job, "warning: " + job.record.warning);
    farm_.keep(job);
    farm_.log->warn("job {} '{}' {}", id, job.record.name, job.record.warning);
  }
}

/// Estimates the errors of pictures without a target. Those with a target have an estimate after
/// each pass.
void JobBook::estimate_errors() {
  if (farm_.job_thread.backlog() > busy_backlog) return;
  std::vector<Job*> due;
  for (const JobId id : farm_.at_work) {
    Job& job = farm_.jobs.at(id);
    if (wants_estimate(job, farm_.now)) due.push_back(&job);
  }
  std::ranges::sort(due, {}, [](const Job* job) {
    return std::tuple(job->work->error_at == never ? Time(0) : job->work->error_at, job->record.id);
  });
  due.resize(std::min(due.size(), most_estimates));
  for (Job* job : due) {
    job->work->error_at = farm_.now;
    auto task = [this, run = job->work->run, id = job->record.id,
                 generation = job->work->generation]() -> JobThread::Completion {
      const PartialError part = error_of_some_rows(run->picture());
      const std::uint64_t samples = run->picture().framebuffer().counts().samples;
      return {[this, id, generation, part, samples] {
        Job* there = farm_.job_at_work(id, generation);
        if (there == nullptr || !there->tracing()) return;
        if (part.share < 1) {
          there->work->error_so_far = part;
        } else {
          there->record.course.error = part.error;
          note_error(*there, samples);
        }
      }};
    };
    farm_.for_log(fmt::format("estimating the error of job {}", job->record.id), std::move(task));
  }
}

/// Adds the latest error to the curve of a picture that had `samples` samples.
void JobBook::note_error(Job& job, std::uint64_t samples) {
  const auto pixels = static_cast<double>(pixel_count(job.record.settings));
  JobCourse& course = job.record.course;
  course.add(
      {job.seconds_taken(farm_.now), static_cast<double>(samples) / pixels, course.error.rmse});
  farm_.keep(job);
}

}  // namespace parray::coordinator
