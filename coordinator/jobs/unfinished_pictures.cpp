// What clients see of an unfinished picture: its error, and what is kept of it.
#include <algorithm>
#include <tuple>
#include <utility>

#include "common/adaptive/error_estimate.h"
#include "common/scene/settings.h"
#include "coordinator/jobs/job_book.h"
#include "coordinator/jobs/report.h"
#include "coordinator/loop/farm.h"

namespace parray::coordinator {
namespace {

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
    farm_.for_log(fmt::format("estimating the error of job {}", job->record.id))
        .give([this, run = job->work->run, id = job->record.id,
               generation = job->work->generation]() -> JobThread::Completion {
          const PartialError part = error_of_some_rows(run->picture());
          const std::uint64_t samples = run->picture().framebuffer().counts().samples;
          return {[this, id, generation, part, samples] {
            Job* there = farm_.job_at_work(id, generation);
            if (there == nullptr || !there->tracing()) return;
            if (part.share < 1) {
              there->work->error_so_far = part;
            } else {
              there->error = part.error;
              note_error(*there, samples);
            }
          }};
        });
  }
}

/// Adds Job::error to the curve of a picture that had `samples` samples.
void JobBook::note_error(Job& job, std::uint64_t samples) {
  const auto pixels = static_cast<double>(pixel_count(job.record.settings));
  job.record.course.add(
      {job.seconds_taken(farm_.now), static_cast<double>(samples) / pixels, job.error.rmse});
  farm_.keep(job);
}

/// Without a store: keeps the unfinished picture of a job that has ended, if there is room.
void JobBook::keep_unfinished(const Job& job, std::shared_ptr<JobRun> run) {
  const RenderSettings& s = job.record.settings;
  const std::uint64_t bytes = picture_size(s.width, s.height, PictureDetail::statistics);
  const auto fits = [this, bytes] { return memory_in_use() + bytes <= farm_.options.memory; };
  if (!fits()) return;
  farm_.for_log(fmt::format("keeping the picture of job {}", job.record.id))
      .give([this, fits, bytes, run = std::move(run), id = job.record.id,
             ended = job.record.ended]() -> JobThread::Completion {
        const auto parts = std::make_shared<const PictureParts>(parts_so_far(run->picture(), true));
        return {[this, fits, bytes, id, ended, parts] {
          Job* there = farm_.job_of(id);
          if (there != nullptr && there->ended() && there->record.state != JobState::done &&
              there->record.ended == ended && fits()) {
            there->picture = PicturePayload(parts);
            there->picture_bytes = bytes;
          }
        }};
      });
}

/// Drops what is left of the pictures of cancelled and failed jobs, until `in_use` fits.
void JobBook::drop_unfinished(std::uint64_t& in_use) {
  for (auto& [id, job] : farm_.jobs) {
    if (in_use <= farm_.options.memory) return;
    if (job.ended() && job.record.state != JobState::done && job.picture_bytes > 0) {
      in_use -= job.picture_bytes;
      job.picture = {};
      job.picture_bytes = 0;
    }
  }
}

}  // namespace parray::coordinator
