// What is taken in, and for how long it is kept.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <iterator>

#include "common/base/error.h"
#include "coordinator/coordinator.h"

namespace parray {
namespace {

constexpr Time between_looks = seconds(5);

std::string gigabytes(std::uint64_t bytes) {
  return fmt::format("{:.1f} GiB", static_cast<double>(bytes) * 0x1p-30);
}

std::uint64_t pixels_of(const JobRecord& record) {
  return std::uint64_t{record.settings.width} * record.settings.height;
}

}  // namespace

/// Whether one more job may wait to be rendered. Throws InputError.
void Coordinator::check_limits(const JobRecord& record) const {
  const Limits& limits = options_.limits;
  const std::string whose = record.user.empty() ? "you have" : "'" + record.user + "' has";
  if (pixels_of(record) > limits.pixels) {
    throw InputError(
        fmt::format("its picture has {} pixels, and this coordinator takes {}: render "
                    "fewer, or raise --max-pixels",
                    pixels_of(record), limits.pixels));
  }
  std::map<JobId, std::uint64_t> open = {{record.listed_as(), pixels_of(record)}};
  std::uint64_t disk = record.scene_bytes;
  for (const auto& [id, job] : jobs_) {
    if (job.record.user != record.user) {
      continue;
    }
    if (!job.ended()) {  // of a series one frame at a time
      std::uint64_t& pixels = open[job.record.listed_as()];
      pixels = std::max(pixels, pixels_of(job.record));
    }
    const auto used = usage_.jobs.find(id);
    disk += used == usage_.jobs.end() ? 0 : used->second;
  }
  const std::size_t jobs = open.size() - 1;
  std::uint64_t pixels = 0;
  for (const auto& [id, of_job] : open) {
    pixels += of_job;
  }
  if (jobs >= limits.user_jobs) {
    throw NoRoom(
        fmt::format("{} {} unfinished jobs, as many as may be: wait, cancel one, or "
                    "raise --max-user-jobs",
                    whose, jobs));
  }
  if (pixels > limits.user_pixels) {
    throw NoRoom(
        fmt::format("with it {} {} pixels in unfinished jobs, more than {}: wait, or "
                    "raise --max-user-pixels",
                    whose, pixels, limits.user_pixels));
  }
  if (disk > limits.user_disk) {
    throw NoRoom(
        fmt::format("with it {} {} on this coordinator's disk, more than {}: parray "
                    "forget some jobs, or raise --max-user-disk",
                    whose, gigabytes(disk), gigabytes(limits.user_disk)));
  }
  if (usage_.total + record.scene_bytes > limits.disk) {
    throw NoRoom(
        fmt::format("this coordinator's jobs take {} of its disk, of {} that they "
                    "may: parray forget some, or raise --max-disk",
                    gigabytes(usage_.total), gigabytes(limits.disk)));
  }
}

/// Every now and then: what is too old goes, and what is too much.
void Coordinator::keep_house(Time now) {
  if (now < next_housekeeping_) {
    return;
  }
  next_housekeeping_ = now + between_looks;
  end_quarantines();
  std::vector<JobId> old;
  for (const auto& [id, job] : jobs_) {
    if (job.ended() &&
        job.ended_seconds(now, options_.wall_clock()) > options_.limits.keep_seconds) {
      old.push_back(id);
    }
  }
  for (const JobId id : old) {
    forget_job(id, "because of its age");
  }
  if (store_ == nullptr) {
    return;
  }
  for_log("tidying up and adding up what the jobs keep")
      .give([this, store = store_,
             keep_lost = options_.limits.keep_lost_seconds]() -> Backroom::Outcome {
        store->tidy(keep_lost);
        return {[this, usage = store->usage()]() mutable { note_usage(std::move(usage)); }, {}};
      });
}

/// Jobs that have ended make room, the oldest first.
void Coordinator::note_usage(Store::Usage usage) {
  usage_ = std::move(usage);
  std::vector<JobId> ended;
  for (const auto& [id, listed] : listed_jobs()) {
    if (has_ended(listed)) {
      std::ranges::transform(listed, std::back_inserter(ended),
                             [](const Job* job) { return job->record.id; });
    }
  }
  for (const JobId id : ended) {
    if (usage_.total <= options_.limits.disk) {
      return;
    }
    const auto used = usage_.jobs.find(id);
    if (used != usage_.jobs.end()) {
      usage_.total -= std::min(usage_.total, used->second);
      usage_.jobs.erase(used);
    }
    forget_job(id, "to keep within --max-disk");
  }
}

/// Of an ended job nothing is left.
void Coordinator::forget_job(JobId id, const std::string& why) {
  const auto found = jobs_.find(id);
  log_->info("job {} '{}' forgotten {}", id, found->second.record.name, why);
  jobs_.erase(found);
  if (store_ != nullptr) {
    for_log(fmt::format("forgetting job {}", id)).give([store = store_, id]() -> Backroom::Outcome {
      store->drop_job(id);
      return {};
    });
  }
}

/// A job, or all frames of a series.
void Coordinator::forget_all(const Series& listed, const std::string& why) {
  const JobId number = listed.front()->record.listed_as();
  std::vector<JobId> ids;
  std::ranges::transform(listed, std::back_inserter(ids),
                         [](const Job* job) { return job->record.id; });
  for (const JobId id : ids) {
    forget_job(id, why);
  }
  std::erase_if(series_, [number](const auto& series) { return series.second == number; });
}

}  // namespace parray
