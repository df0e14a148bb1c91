// Accepts submitted jobs, or refuses them with a reason.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <new>
#include <nlohmann/json.hpp>

#include "common/adaptive/rounding_limit.h"
#include "common/base/bytes.h"
#include "common/base/error.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/settings.h"
#include "coordinator/disputes/dispute_desk.h"
#include "coordinator/jobs/job_book.h"

namespace parray::coordinator {

using nlohmann::json;

namespace {

std::string megabytes(std::uint64_t bytes) {
  return std::to_string((bytes + 999'999) / 1'000'000) + " MB";
}

std::string disk_text(std::uint64_t bytes) {
  return fmt::format("{:.1f} GiB", static_cast<double>(bytes) * 0x1p-30);
}

/// Returns what identifies a submitted job: two users may use the same token.
std::pair<std::string, std::string> submit_key(const JobRecord& record) {
  return {record.user, name_in_token(record.token)};
}

}  // namespace

/// A submitted job that the job thread has checked.
struct JobBook::Accepted {
  Job job;
  std::string refusal;
  std::uint32_t status = 2;
  BulkLedger::Ticket ticket{};  ///< of the scene's bytes
};

void JobBook::on(Time now, const PeerId& peer, msg::Submit& m) {
  const std::string user = farm_.sender.role == Role::any ? m.user : farm_.sender.name;
  const std::string token = name_in_token(m.token);
  if (const JobId id = farm_.index.by_token(user, token); id != 0) {
    if (may_be_same_content(farm_.jobs.at(id).record.token, m.token)) {  // a repeated submit
      farm_.send(peer, msg::Submitted{m.request, id});
    } else {
      farm_.fail_request(
          peer, m.request, 2,
          "job " + std::to_string(id) +
              " was submitted with this Idempotency-Key and different content: use a new key for "
              "a new job");
    }
    return;
  }
  const std::pair key(user, token);
  if (submitting_.contains(key)) {
    return;  // the first submit will be answered
  }
  const auto accepted = std::make_shared<Accepted>();
  accepted->job.next_epoch = farm_.options.first_epoch;
  accepted->job.submitted = now;
  JobRecord& record = accepted->job.record;
  static_cast<JobHead&>(record) = m;
  record.token = m.token;
  record.user = user;
  record.share = farm_.sender.share;
  record.fault_findings = disputes_.latest_finding();
  record.scene_bytes = m.scene.size();
  record.course.submitted = farm_.wall_now();
  accepted->job.stored = farm_.store != nullptr;
  record.note(farm_.options.wall_clock(), "submitted" + (user.empty() ? "" : " by " + user));
  try {
    join_series(record);
    check_limits(record);
    check_preview(record);
    if (m.settings->target_denoised && !farm_.options.judge_of) {
      throw InputError(
          "target_denoised: a coordinator cannot estimate the error of a denoised picture: use "
          "parray render, or let the target apply to the picture before denoising");
    }
    if (m.denoise && !m.settings->replicates) {
      throw InputError("denoise: the settings lack `replicates`, which the denoiser needs");
    }
    const std::uint64_t needed = JobPicture::memory(m.settings) + m.scene.size();
    if (needed > farm_.options.memory) {
      throw InputError("the picture and its scene need " + megabytes(needed) +
                       " of memory, and this coordinator has " + megabytes(farm_.options.memory) +
                       ": raise the coordinator's --memory, or submit fewer pixels or shapes");
    }
    if (farm_.store == nullptr &&
        !(fits_beside_scenes(needed, m.scene.size()) && make_room(m.scene.size()))) {
      throw NoRoom("this coordinator's memory, " + megabytes(farm_.options.memory) +
                   ", is full of waiting scenes: wait, raise the coordinator's --memory, or start "
                   "it with --state");
    }
    accepted->ticket = farm_.scenes_waiting.admit(peer, m.scene.size());
    if (!accepted->ticket) {
      throw NoRoom(
          "scenes that wait for the disk fill a quarter of this coordinator's memory: wait");
    }
    if (!record.series.empty() && record.series_id == 0) record.series_id = next_job_++;
    record.id = next_job_;
    submitting_[key] = {record.listed_as(), pixel_count(record.settings)};
    make_room_for_job();
  } catch (const NoRoom& error) {
    submitting_.erase(key);
    farm_.send(peer, msg::Error{m.request, 2, error.what(), true});
    return;
  } catch (const InputError& error) {
    submitting_.erase(key);
    farm_.fail_request(peer, m.request, 2, error.what());
    return;
  }
  ++next_job_;
  if (record.series_id != 0) series_[{user, m.series}] = record.series_id;
  auto failed = [this, accepted, peer, request = m.request](const std::string& why) {
    accepted->refusal = why;
    accepted->status = 1;
    accept_job(peer, request, *accepted);
  };
  auto task = [this, accepted, store = farm_.store, peer, request = m.request,
               scene = std::move(m.scene)]() -> JobThread::Completion {
    Job& job = accepted->job;
    try {
      job.record.scene = scene.identity();
      const auto decoded = scene.scene();  // throws if it is not a scene
      job.spheres = decoded->spheres.size() + decoded->capsules.size();
      check_targets(job.record.settings, largest_radiance(*decoded));
      if (store != nullptr) {
        store->put_scene(job.record.scene, scene.bytes().data.view());
        store->put_job(job.record);
      } else {
        job.scene = scene;
      }
    } catch (const ChecksumError&) {  // damaged in transit: the client repeats it
      return {[this, accepted] { submitting_.erase(submit_key(accepted->job.record)); }};
    } catch (const DecodeError& error) {
      accepted->refusal = error.what();
    } catch (const InputError& error) {
      accepted->refusal = error.what();
    } catch (const StorageFull& error) {
      accepted->refusal = error.what();
      accepted->status = 1;
    } catch (const std::bad_alloc&) {
      accepted->refusal =
          "the coordinator has too little memory for this scene: try again later, or submit a "
          "smaller one";
      accepted->status = 1;
    }
    const auto outcome = [this, accepted, peer, request] { accept_job(peer, request, *accepted); };
    return accepted->refusal.empty() ? JobThread::Completion{{}, outcome}
                                     : JobThread::Completion{outcome};
  };
  farm_.job_thread.give(std::move(task), std::move(failed));
}

void JobBook::accept_job(const PeerId& peer, std::uint64_t request, Accepted& accepted) {
  Job& job = accepted.job;
  submitting_.erase(submit_key(job.record));
  if (!accepted.refusal.empty()) {
    farm_.fail_request(peer, request, accepted.status, accepted.refusal);
    return;
  }
  const RenderSettings& s = job.record.settings;
  farm_.log->info("job {} '{}' submitted: {} shapes, {} x {} pixels, {} samples", job.record.id,
                  job.record.name, job.spheres, s.width, s.height, s.samples_per_pixel);
  farm_.send(peer, msg::Submitted{request, job.record.id});
  job.queued_at = farm_.since_1970(farm_.now);
  const JobId id = job.record.id;
  farm_.index.add(farm_.jobs.emplace(id, std::move(job)).first->second);
  list_open_jobs();
}

/// Gives a new frame the priority and pause of its series. Throws InputError for a cancelled one.
void JobBook::join_series(JobRecord& record) {
  const auto known = series_.find({record.user, record.series});
  if (record.series.empty() || known == series_.end()) return;
  record.series_id = known->second;
  const std::vector<Job*> frames = frames_of(record.series_id);
  const auto open = std::ranges::find_if(frames, [](const Job* job) { return !job->ended(); });
  if (open == frames.end()) {
    if (std::ranges::any_of(
            frames, [](const Job* job) { return job->record.state == JobState::cancelled; })) {
      throw InputError(
          fmt::format("series {0} was cancelled: use parray requeue {0} or "
                      "parray forget {0}",
                      record.series_id));
    }
    return;
  }
  record.priority = (*open)->record.priority;
  if ((*open)->record.state == JobState::paused) {
    record.state = JobState::paused;
    record.reason = (*open)->record.reason;
  }
}

/// Throws InputError if the job cannot be a quick look of the job that it names.
void JobBook::check_preview(const JobRecord& record) const {
  constexpr std::size_t most = 8;
  const JobId of = record.preview_of;
  if (of == 0) return;
  const JobIndex::Frames* named = farm_.index.listed_as(of);
  if (named == nullptr) {
    const auto frame = farm_.jobs.find(of);
    throw InputError(
        frame == farm_.jobs.end()
            ? fmt::format(
                  "preview_of: there is no job or series {}: submit it before its quick look", of)
            : fmt::format("preview_of: job {} is a frame of series {}: name the series", of,
                          frame->second.record.series_id));
  }
  const JobRecord& job = named->begin()->second->record;
  if (job.user != record.user) {
    throw InputError(fmt::format(
        "preview_of: job {} belongs to another user: a quick look needs a job of your own", of));
  }
  if (job.preview_of != 0) {
    throw InputError(
        fmt::format("preview_of: job {} is itself a quick look: name job {}", of, job.preview_of));
  }
  if (!record.series.empty()) {
    throw InputError(
        "preview_of: a frame of a series cannot be the quick look of another job: submit the quick "
        "look outside the series");
  }
  if (farm_.index.previews_of(of).size() >= most) {
    throw InputError(
        fmt::format("preview_of: job {} has {} quick looks, the most: delete one first", of, most));
  }
}

void JobBook::check_limits(const JobRecord& record) const {
  const Limits& limits = farm_.options.limits;
  const std::string whose =
      record.user.empty() ? "clients without a key have" : "'" + record.user + "' has";
  const std::uint64_t own_pixels = pixel_count(record.settings);
  if (own_pixels > limits.pixels) {
    throw InputError(
        fmt::format("the picture has {} pixels, and this coordinator allows {}: render "
                    "fewer, or raise --max-pixels",
                    own_pixels, limits.pixels));
  }
  const JobIndex::Open others = farm_.index.open_of(record.user, record.listed_as());
  std::map<JobId, std::uint64_t> arriving;  // jobs that the index does not contain yet
  for (const auto& [key, job] : submitting_) {
    if (key.first == record.user && job.listed != record.listed_as() &&
        farm_.index.open_pixels(record.user, job.listed) == 0) {
      arriving[job.listed] = std::max(arriving[job.listed], job.pixels);
    }
  }
  const std::size_t jobs = others.jobs + arriving.size();
  // A series counts with its largest frame.
  std::uint64_t pixels = others.pixels + std::max(own_pixels, farm_.index.open_pixels(
                                                                  record.user, record.listed_as()));
  for (const auto& [listed, of_job] : arriving) pixels += of_job;
  const auto used = disk_of_.find(record.user);
  const std::uint64_t disk = record.scene_bytes + (used == disk_of_.end() ? 0 : used->second);
  if (jobs >= limits.user_jobs) {
    throw NoRoom(
        fmt::format("{} {} unfinished jobs, the limit per user: wait, cancel one, or "
                    "raise --max-user-jobs",
                    whose, jobs));
  }
  if (pixels > limits.user_pixels) {
    throw NoRoom(
        fmt::format("with this job {} {} pixels in unfinished jobs, more than {}: wait, or "
                    "raise --max-user-pixels",
                    whose, pixels, limits.user_pixels));
  }
  if (farm_.store == nullptr) return;
  if (disk > limits.user_disk) {
    throw NoRoom(
        fmt::format("with this job {} {} on this coordinator's disk, more than {}: remove jobs "
                    "with parray forget, or raise --max-user-disk",
                    whose, disk_text(disk), disk_text(limits.user_disk)));
  }
  if (usage_.total + record.scene_bytes > limits.disk) {
    throw NoRoom(fmt::format(
        "with this job all jobs have {} on this coordinator's disk, more than {}: remove "
        "jobs with parray forget, or raise --max-disk",
        disk_text(usage_.total + record.scene_bytes), disk_text(limits.disk)));
  }
}

/// Forgets the oldest ended job or series if there are too many. Throws NoRoom if none has ended.
void JobBook::make_room_for_job() {
  const auto& listed = farm_.index.listed();
  if (listed.size() + submitting_.size() <= farm_.options.limits.jobs) return;
  std::size_t all = listed.size();
  for (const auto& [key, job] : submitting_) all += listed.contains(job.listed) ? 0 : 1;
  if (all <= farm_.options.limits.jobs) return;
  const auto oldest = std::ranges::find_if(farm_.index.ended(), [&](JobId number) {
    return has_ended(series_of(listed.at(number)));  // a series may get more frames
  });
  if (oldest == farm_.index.ended().end()) {
    throw NoRoom("this coordinator already has " + std::to_string(farm_.options.limits.jobs) +
                 " jobs and none has ended: wait, cancel one, or raise --max-jobs");
  }
  forget_all(series_of(listed.at(*oldest)), "to make room");
}

}  // namespace parray::coordinator
