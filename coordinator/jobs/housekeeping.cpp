// What is taken in, and for how long it is kept.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <nlohmann/json.hpp>

#include "common/base/error.h"
#include "coordinator/loop/coordinator.h"

namespace parray::coordinator {
namespace {

constexpr Time between_looks = seconds(5);
constexpr const char* progress_note = "progress";  // shares of unfinished jobs, by number, as JSON

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
  const JobIndex::Open others = index_.open_of(record.user, record.listed_as());
  const std::size_t jobs = others.jobs;
  // Of a series one frame at a time.
  const std::uint64_t pixels =
      others.pixels +
      std::max(pixels_of(record), index_.open_pixels(record.user, record.listed_as()));
  const auto used = disk_of_.find(record.user);
  const std::uint64_t disk = record.scene_bytes + (used == disk_of_.end() ? 0 : used->second);
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

/// Forgets the oldest that has ended when there are too many.
void Coordinator::make_room_for_job() {
  const auto& listed = index_.listed();
  if (listed.size() + submitting_.size() <= options_.limits.jobs) {
    return;
  }
  std::size_t all = listed.size();
  for (const auto& [token, id] : submitting_) {
    all += listed.contains(id) ? 0 : 1;
  }
  if (all <= options_.limits.jobs) {
    return;
  }
  const auto oldest = std::ranges::find_if(index_.ended(), [&](JobId number) {
    return has_ended(series_of(listed.at(number)));  // and lacks no frame
  });
  if (oldest == index_.ended().end()) {
    throw NoRoom("this coordinator has its " + std::to_string(options_.limits.jobs) +
                 " jobs and none has ended: wait, cancel one, or raise --max-jobs");
  }
  forget_all(series_of(listed.at(*oldest)), "to make room");
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
    if (job.ended() && uptime() - job.record.ended > options_.limits.keep_seconds) {
      old.push_back(id);
    }
  }
  for (const JobId id : old) {
    forget_job(id, "because of its age");
  }
  if (store_ == nullptr) {
    return;
  }
  keep_farm_notes();
  for_log("tidying up and adding up what the jobs keep")
      .give([this, store = store_,
             keep_lost = options_.limits.keep_lost_seconds]() -> Backroom::Outcome {
        store->tidy(keep_lost);
        return {[this, usage = store->usage()]() mutable { note_usage(std::move(usage)); }, {}};
      });
}

/// Seconds for which coordinators have served this state. A clock that is set does not change them.
double Coordinator::uptime() const {
  return uptime_before_ + (began_ == never ? 0 : to_seconds(now_ - began_));
}

/// What the next life cannot know otherwise: the uptime, and how far jobs are.
void Coordinator::keep_farm_notes() {
  nlohmann::json progress = nlohmann::json::object();
  for (const auto& [id, job] : jobs_) {
    const double share = job.ended() ? 0 : job.progress(now_);
    if (share > 0) {
      progress[std::to_string(id)] = std::round(share * 1e4) / 1e4;
    }
  }
  constexpr double between = 60;  // seconds
  const std::string text = progress.dump();
  const bool later = uptime() >= uptime_kept_ + between;
  if (!later && text == progress_kept_) {
    return;
  }
  uptime_kept_ = later ? uptime() : uptime_kept_;
  progress_kept_ = text;
  for_log("keeping the uptime and the progress of jobs")
      .give([store = store_, text, seconds_up = uptime()]() -> Backroom::Outcome {
        store->put_note(progress_note, text);
        store->put_note(uptime_note, std::to_string(static_cast<std::uint64_t>(seconds_up)));
        return {};
      });
}

/// Jobs of earlier versions, which did not keep the uptime at which they ended, end now.
void Coordinator::restore_farm_notes() {
  uptime_before_ = uptime_kept_ = std::strtod(store_->note(uptime_note).c_str(), nullptr);
  const nlohmann::json progress =
      nlohmann::json::parse(store_->note(progress_note), nullptr, false);
  for (auto& [id, job] : jobs_) {
    if (job.ended() && job.record.ended == 0) {
      job.record.ended = std::max(uptime(), 1.0);
      keep(job);
    }
    const std::string name = std::to_string(id);
    if (progress.is_object() && progress.contains(name) && progress.at(name).is_number()) {
      job.kept_progress = std::clamp(progress.at(name).get<double>(), 0.0, 1.0);
    }
  }
}

void Coordinator::note_damaged_rows(Job& job, const std::string& damage) {
  if (!damage.empty()) {
    note(job, "rows that were kept are damaged and will be traced again: " + damage);
    log_->warn("job {}: {}: the rest will be traced again", job.record.id, damage);
    keep(job);
  }
}

/// Jobs that have ended make room, the oldest first.
void Coordinator::note_usage(Store::Usage usage) {
  usage_ = std::move(usage);
  make_room_on_disk();
  disk_of_.clear();
  for (const auto& [id, bytes] : usage_.jobs) {
    if (const Job* job = job_of(id)) {
      disk_of_[job->record.user] += bytes;
    }
  }
}

void Coordinator::make_room_on_disk() {
  if (usage_.total <= options_.limits.disk) {
    return;
  }
  std::vector<JobId> ended;
  for (const auto& [number, frames] : index_.listed()) {
    const Series listed = series_of(frames);
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
  const auto used = usage_.jobs.find(id);
  if (used != usage_.jobs.end()) {
    std::uint64_t& disk = disk_of_[found->second.record.user];
    disk -= std::min(disk, used->second);
    usage_.jobs.erase(used);
  }
  index_.remove(found->second);
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

}  // namespace parray::coordinator
