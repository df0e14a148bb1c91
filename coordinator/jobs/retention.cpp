// Decides which jobs and files the coordinator keeps, and for how long; counts their memory.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "common/scene/settings_fwd.h"
#include "coordinator/disputes/dispute_desk.h"
#include "coordinator/jobs/job_book.h"
#include "coordinator/loop/worker_desk.h"

namespace parray::coordinator {
namespace {

constexpr Time between_looks = seconds(5);
/// JSON: of each unfinished job, by number, its progress, seconds taken and samples.
constexpr const char* progress_note = "progress";
constexpr double longest_taken = 1e12;       // seconds
constexpr const char* users_note = "users";  // thread-seconds by user, as JSON

}  // namespace

void JobBook::keep_house(Time now) {
  if (now < next_housekeeping_) return;
  next_housekeeping_ = now + between_looks;
  disputes_.end_quarantines();
  warn_of_long_jobs();
  forget_old_jobs();
  estimate_errors();
  if (farm_.store == nullptr) return;
  keep_farm_notes();
  const double keep_lost = farm_.options.limits.keep_lost_seconds;
  const auto task = [this, store = farm_.store, keep_lost]() -> JobThread::Completion {
    store->tidy(keep_lost);
    return {[this, usage = store->usage()]() mutable { note_usage(std::move(usage)); }};
  };
  farm_.for_log("removing old files and counting the bytes of jobs", task);
}

void JobBook::keep_farm_notes() {
  nlohmann::json progress = nlohmann::json::object();
  for (const auto& [id, job] : farm_.jobs) {
    const double share = job.ended() ? 0 : job.progress(farm_.now);
    if (share > 0 || (!job.ended() && job.samples() > 0)) {
      progress[std::to_string(id)] = {std::round(share * 1e4) / 1e4,
                                      std::round(job.seconds_taken(farm_.now)), job.samples()};
    }
  }
  constexpr double between = 60;  // seconds
  const std::string text = progress.dump();
  const bool later = farm_.uptime() >= uptime_kept_ + between;
  if (!later && text == progress_kept_) return;
  uptime_kept_ = later ? farm_.uptime() : uptime_kept_;
  progress_kept_ = text;
  auto task = [store = farm_.store, text, users = farm_.watch.accounts_text(),
               seconds_up = farm_.uptime()]() -> JobThread::Completion {
    store->put_note(progress_note, text);
    store->put_note(users_note, users);
    store->put_note(uptime_note, std::to_string(static_cast<std::uint64_t>(seconds_up)));
    return {};
  };
  farm_.for_log("storing the uptime and the progress of jobs", std::move(task));
}

/// Restores the farm's uptime and the progress of its jobs.
void JobBook::restore_farm_notes() {
  farm_.uptime_before = uptime_kept_ = std::strtod(farm_.store->note(uptime_note).c_str(), nullptr);
  farm_.watch.restore_accounts(farm_.store->note(users_note));
  const nlohmann::json progress =
      nlohmann::json::parse(farm_.store->note(progress_note), nullptr, false);
  for (auto& [id, job] : farm_.jobs) {
    const auto found = progress.is_object() ? progress.find(std::to_string(id)) : progress.end();
    if (found == progress.end() || job.ended()) continue;
    JobCourse& course = job.record.course;
    const bool list = found->is_array() && found->size() == 3;  // older versions: the share alone
    const nlohmann::json share = list ? found->at(0) : *found;
    course.progress = share.is_number() ? std::clamp(share.get<double>(), 0.0, 1.0) : 0;
    if (list && found->at(1).is_number() && found->at(2).is_number_unsigned()) {
      course.taken = std::max(course.taken, std::min(found->at(1).get<double>(), longest_taken));
      course.samples = found->at(2).get<std::uint64_t>();
    }
  }
}

/// A series is as old as its frame that ended last.
void JobBook::forget_old_jobs() {
  const double ended_before = farm_.uptime() - farm_.options.limits.keep_seconds;
  const auto is_old = [&](const Job* job) { return job->record.ended < ended_before; };
  std::vector<JobId> old;
  for (const JobId number : farm_.index.ended()) {
    if (std::ranges::all_of(series_of(farm_.index.listed().at(number)), is_old)) {
      old.push_back(number);
    }
  }
  for (const JobId number : old) forget_listed(number, "because of its age (--keep-days)");
}

/// Takes over a new count. Forgets the oldest ended jobs if there is too little room.
void JobBook::note_usage(Store::Usage usage) {
  usage_ = std::move(usage);
  make_room_on_disk();
  disk_of_.clear();
  for (const auto& [id, bytes] : usage_.jobs) {
    if (const Job* job = farm_.job_of(id)) disk_of_[job->record.user] += bytes;
  }
}

/// Series go as a whole: the rest of one would count as unfinished.
void JobBook::make_room_on_disk() {
  std::vector<JobId> ended;
  for (const auto& [number, frames] : farm_.index.listed()) {
    if (has_ended(series_of(frames))) ended.push_back(number);
  }
  for (const JobId number : ended) {
    if (usage_.total <= farm_.options.limits.disk) return;
    forget_listed(number, "to keep within --max-disk");
  }
}

void JobBook::forget_job(JobId id, const std::string& why) {
  const auto found = farm_.jobs.find(id);
  if (found == farm_.jobs.end()) {
    return;  // a quick look is forgotten with its job
  }
  const JobId listed = found->second.record.listed_as();
  farm_.log->info("forgot job {} '{}' {}", id, found->second.record.name, why);
  const auto used = usage_.jobs.find(id);
  if (used != usage_.jobs.end()) {
    std::uint64_t& disk = disk_of_[found->second.record.user];
    disk -= std::min(disk, used->second);
    usage_.total -= std::min(usage_.total, used->second);
    usage_.jobs.erase(used);
  }
  farm_.index.remove(found->second);
  farm_.jobs.erase(found);
  if (farm_.store != nullptr) {
    const auto task = [store = farm_.store, id]() -> JobThread::Completion {
      store->drop_job(id);
      return {};
    };
    farm_.for_log(fmt::format("forgetting job {}", id), task);
  }
  if (farm_.index.listed_as(listed) == nullptr) forget_previews(listed);
}

void JobBook::forget_previews(JobId of) {
  for (const JobId id : farm_.index.previews_of(of)) {
    Job& preview = farm_.jobs.at(id);
    if (!preview.ended()) {
      end_job(preview, JobState::cancelled, "its job was deleted");
      list_open_jobs();
      worker_desk_.forget_scene(preview.record.scene);
    }
    forget_job(id, "with its job");
  }
}

void JobBook::forget_listed(JobId number, const std::string& why) {
  const JobIndex::Frames* frames = farm_.index.listed_as(number);
  if (frames != nullptr) forget_all(series_of(*frames), why);
}

void JobBook::forget_all(const Series& listed, const std::string& why) {
  const JobId number = listed.front()->record.listed_as();
  for (const Job* job : listed) forget_job(job->record.id, why);
  std::erase_if(series_, [number](const auto& series) { return series.second == number; });
}

/// Drops data of the oldest ended jobs first, and the last picture only if there is no other way.
bool JobBook::make_room(std::uint64_t bytes) {
  if (farm_.store != nullptr) {
    return memory_in_use() + bytes <= farm_.options.memory;  // the store keeps ended jobs
  }
  std::uint64_t in_use = memory_in_use() + bytes;
  drop_unfinished(in_use);
  std::uint64_t kept = 0;
  std::size_t pictures = 0;
  bool at_work = false;
  for (const auto& [id, job] : farm_.jobs) {
    kept += job.kept_bytes();
    pictures += job.picture_bytes > 0 ? 1 : 0;
    at_work = at_work || job.work;
  }
  if (in_use - kept > farm_.options.memory) {
    return false;  // dropping everything would not suffice
  }
  for (auto& [id, job] : farm_.jobs) {
    if (in_use <= farm_.options.memory) break;
    const bool last_picture = job.picture_bytes > 0 && pictures == 1;
    if (job.kept_bytes() == 0 || (last_picture && (at_work || bytes == 0))) continue;
    in_use -= job.kept_bytes();
    pictures -= job.picture_bytes > 0 ? 1 : 0;
    job.picture = {};
    job.journal = {};
    job.picture_bytes = 0;
    job.scene = {};
  }
  return in_use <= farm_.options.memory;
}

std::uint64_t JobBook::memory_of(const Job& job) const {
  return JobPicture::memory(job.record.settings) +
         (farm_.store != nullptr ? job.record.scene_bytes : 0);
}

std::uint64_t JobBook::memory_in_use() const {
  std::uint64_t bytes = disputes_.referee().memory() + farm_.bulk.bytes() +
                        farm_.log_pictures.bytes() + farm_.scenes_waiting.bytes();
  for (const JobId id : farm_.at_work) bytes += memory_of(farm_.jobs.at(id));
  if (farm_.store == nullptr) {
    for (const auto& [id, job] : farm_.jobs) bytes += job.scene.size() + job.picture_bytes;
  }
  return bytes;
}

/// Returns whether memory suffices for all scenes and the largest picture of the open jobs and a
/// new job that needs `needed` bytes with its scene. Otherwise some job could never start.
bool JobBook::fits_beside_scenes(std::uint64_t needed, std::uint64_t scene) const {
  std::uint64_t scenes = scene;
  std::uint64_t largest = needed - scene;
  for (const JobId id : farm_.index.open()) {
    scenes += farm_.jobs.at(id).scene.size();
    largest = std::max(largest, JobPicture::memory(farm_.jobs.at(id).record.settings));
  }
  return scenes + largest <= farm_.options.memory;
}

/// Without a store: keeps the unfinished picture of a job that has ended, if there is room.
void JobBook::keep_unfinished(const Job& job, std::shared_ptr<JobRun> run) {
  const auto& settings = job.record.settings;
  const std::uint64_t bytes =
      picture_size(width_of(settings), height_of(settings), PictureDetail::statistics);
  const auto fits = [this, bytes] { return memory_in_use() + bytes <= farm_.options.memory; };
  if (!fits()) return;
  auto task = [this, fits, bytes, run = std::move(run), id = job.record.id,
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
  };
  farm_.for_log(fmt::format("keeping the picture of job {}", job.record.id), std::move(task));
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
