// What the coordinator answers to clients.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <iterator>
#include <new>
#include <nlohmann/json.hpp>

#include "common/adaptive/rounding_limit.h"
#include "common/base/bytes.h"
#include "common/base/error.h"
#include "common/image/image.h"
#include "common/image/picture_bytes.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/scene_bytes.h"
#include "coordinator/loop/coordinator.h"
#include "coordinator/loop/submit_token.h"

namespace parray {

using nlohmann::json;

namespace {

std::string megabytes(std::uint64_t bytes) {
  return std::to_string((bytes + 999'999) / 1'000'000) + " MB";
}

}  // namespace

/// A submitted job that the backroom has looked at.
struct Coordinator::Accepted {
  Job job;
  std::string refusal;
  std::uint32_t status = 2;
  BulkLedger::Ticket ticket{};  ///< of the scene's bytes
};

void Coordinator::on(Time now, const PeerId& peer, msg::Submit& m) {
  const std::string user = sender_.role == Role::any ? m.user : sender_.name;
  const std::string token = name_in_token(m.token);
  if (const JobId id = index_.by_token(user, token); id != 0) {
    if (may_be_same_content(jobs_.at(id).record.token, m.token)) {  // a repeated submit
      send(peer, msg::Submitted{m.request, id});
    } else {
      fail_request(peer, m.request, 2,
                   "job " + std::to_string(id) +
                       " was submitted with this Idempotency-Key, and with another content: take "
                       "another key for another job");
    }
    return;
  }
  if (submitting_.contains(token)) {
    return;  // its answer is on its way
  }
  const auto accepted = std::make_shared<Accepted>();
  accepted->job.next_epoch = options_.first_epoch;
  accepted->job.submitted = now;
  JobRecord& record = accepted->job.record;
  static_cast<JobHead&>(record) = m;
  record.token = m.token;
  record.user = user;
  record.share = sender_.share;
  record.convictions = convictions_.latest();
  record.scene_bytes = m.scene.size();
  record.note(options_.wall_clock(), "submitted" + (user.empty() ? "" : " by " + user));
  try {
    join_series(record);
    check_limits(record);
    if (m.settings.target_denoised && !options_.judge_of) {
      throw InputError(
          "a coordinator does not trace, and cannot tell the error of a denoised "
          "picture: render it in one process, or let the target count the samples'");
    }
    const std::uint64_t needed = JobPicture::memory(m.settings) + m.scene.size();
    if (needed > options_.memory) {
      throw InputError("its picture takes " + megabytes(needed) +
                       " of memory, and this coordinator has " + megabytes(options_.memory) +
                       ": raise --memory, or render fewer pixels");
    }
    if (store_ == nullptr &&
        !(fits_beside_scenes(needed, m.scene.size()) && make_room(m.scene.size()))) {
      throw NoRoom("this coordinator's memory, " + megabytes(options_.memory) +
                   ", is full of waiting scenes: wait, raise --memory, or keep them with --state");
    }
    accepted->ticket = scenes_waiting_.admit(peer, m.scene.size());
    if (!accepted->ticket) {
      throw NoRoom("scenes that wait to be kept fill a quarter of this coordinator's memory: wait");
    }
    if (!record.series.empty() && record.series_id == 0) {
      record.series_id = next_job_++;
    }
    record.id = next_job_;
    submitting_[token] = record.listed_as();
    make_room_for_job();
  } catch (const NoRoom& error) {
    submitting_.erase(token);
    send(peer, msg::Error{m.request, 2, error.what(), true});
    return;
  } catch (const InputError& error) {
    submitting_.erase(token);
    fail_request(peer, m.request, 2, error.what());
    return;
  }
  ++next_job_;
  if (record.series_id != 0) {
    series_[{user, m.series}] = record.series_id;
  }
  const auto guarded =
      backroom_.guarded([this, accepted, peer, request = m.request](const std::string& why) {
        accepted->refusal = why;
        accepted->status = 1;
        accept_job(peer, request, *accepted);
      });
  guarded.give([this, accepted, store = store_, peer, request = m.request,
                scene = std::move(m.scene)]() -> Backroom::Outcome {
    Job& job = accepted->job;
    try {
      job.record.scene = scene.identity();
      const auto decoded = scene.scene();  // or it is no scene at all
      job.spheres = decoded->spheres.size();
      check_targets(job.record.settings, largest_radiance(*decoded));
      if (store != nullptr) {
        store->put_scene(job.record.scene, scene.bytes().data.view());
        store->put_job(job.record);
      } else {
        job.scene = scene;
      }
    } catch (const ChecksumError&) {  // damaged on its way: the client repeats it
      return {[this, accepted] { submitting_.erase(name_in_token(accepted->job.record.token)); },
              {}};
    } catch (const DecodeError& error) {
      accepted->refusal = error.what();
    } catch (const InputError& error) {
      accepted->refusal = error.what();
    } catch (const StorageFull& error) {
      accepted->refusal = error.what();
      accepted->status = 1;
    } catch (const std::bad_alloc&) {
      accepted->refusal = "not enough memory for this scene";
      accepted->status = 1;
    }
    const auto outcome = [this, accepted, peer, request] { accept_job(peer, request, *accepted); };
    return accepted->refusal.empty() ? Backroom::Outcome{{}, outcome}
                                     : Backroom::Outcome{outcome, {}};
  });
}

void Coordinator::accept_job(const PeerId& peer, std::uint64_t request, Accepted& accepted) {
  Job& job = accepted.job;
  submitting_.erase(name_in_token(job.record.token));
  if (!accepted.refusal.empty()) {
    fail_request(peer, request, accepted.status, accepted.refusal);
    return;
  }
  const RenderSettings& s = job.record.settings;
  log_->info("job {} '{}' submitted: {} spheres, {} x {} pixels, {} samples", job.record.id,
             job.record.name, job.spheres, s.width, s.height, s.samples_per_pixel);
  send(peer, msg::Submitted{request, job.record.id});
  const JobId id = job.record.id;
  index_.add(jobs_.emplace(id, std::move(job)).first->second);
  list_open_jobs();
}

/// Whether `state` is one of `names`, which have commas between them.
static bool is_among(std::string_view names, std::string_view state) {
  for (std::size_t begin = 0; begin < names.size();) {
    const std::size_t end = std::min(names.find(',', begin), names.size());
    if (names.substr(begin, end - begin) == state) return true;
    begin = end + 1;
  }
  return false;
}

void Coordinator::on(Time now, const PeerId& peer, msg::ListJobs& m) {
  auto list = json::array();
  const auto& listed = index_.listed();
  const auto end = m.before == 0 ? listed.end() : listed.lower_bound(m.before);
  for (auto entry = std::make_reverse_iterator(end);
       entry != listed.rend() && list.size() < m.limit; ++entry) {
    const Job& first = *entry->second.begin()->second;
    const bool alone = first.record.series_id == 0;
    if (!m.states.empty() && alone && !is_among(m.states, first.shown_state())) continue;
    json summary = alone ? job_summary(first, now, waits_for(first))
                         : summary_of(now, series_of(entry->second));
    if (m.states.empty() || is_among(m.states, summary["state"].get<std::string>())) {
      list.push_back(std::move(summary));
    }
  }
  std::reverse(list.begin(), list.end());
  send(peer, msg::Jobs{m.request, std::move(list)});
}

/// The job, or null once the client has been told that there is none.
Job* Coordinator::asked_for(const PeerId& peer, std::uint64_t request, JobId id) {
  Job* job = job_of(id);
  if (job == nullptr) {
    const bool series = !frames_of(id).empty();
    fail_request(peer, request, 2,
                 series
                     ? fmt::format("{} is a series of frames: write #### in the picture's name, or "
                                   "name the job of one of them, as "
                                   "parray show {} lists them",
                                   id, id)
                     : fmt::format("no job {}: see parray jobs", id));
  }
  return job;
}

/// The frames of a series, by number; none: there is no such series.
std::vector<Job*> Coordinator::frames_of(JobId series) {
  std::vector<Job*> frames;
  const JobIndex::Frames* listed = index_.listed_as(series);
  if (listed != nullptr && listed->begin()->second->record.series_id == series) {
    for (const auto& [key, job] : *listed) {
      frames.push_back(job);
    }
  }
  return frames;
}

/// A frame that comes later is treated like those that are there. Throws InputError where they were
/// cancelled.
void Coordinator::join_series(JobRecord& record) {
  const auto known = series_.find({record.user, record.series});
  if (record.series.empty() || known == series_.end()) {
    return;
  }
  record.series_id = known->second;
  const std::vector<Job*> frames = frames_of(record.series_id);
  const auto open = std::ranges::find_if(frames, [](const Job* job) { return !job->ended(); });
  if (open == frames.end()) {
    if (std::ranges::any_of(
            frames, [](const Job* job) { return job->record.state == JobState::cancelled; })) {
      throw InputError(fmt::format("series {} was cancelled: parray requeue it, or forget it",
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

/// The job map of what is listed: a job, or a series.
json Coordinator::summary_of(Time now, const Series& listed) const {
  const Job& first = *listed.front();
  if (first.record.series_id == 0) {
    return job_summary(first, now, waits_for(first));
  }
  const Job* open = first_unfinished(listed);
  return series_summary(listed, now, open == nullptr ? "" : waits_for(*open));
}

void Coordinator::on(Time now, const PeerId& peer, msg::ShowJob& m) {
  const std::vector<Job*> frames = frames_of(m.job);
  if (!frames.empty()) {
    const Series series(frames.begin(), frames.end());
    json summary = summary_of(now, series);
    summary["frame_list"] = frame_list(series, m.from_frame);
    send(peer, msg::Job{m.request, std::move(summary)});
  } else if (const Job* job = asked_for(peer, m.request, m.job)) {
    json summary = job_summary(*job, now, waits_for(*job));
    summary["events"] = events_to_json(job->record.events);
    send(peer, msg::Job{m.request, std::move(summary)});
  }
}

void Coordinator::on(Time now, const PeerId& peer, msg::ListWorkers& m) {
  auto list = json::array();
  std::uint32_t number = 0;
  for (const auto& [id, worker] : workers_) {
    if (list.size() == m.limit) {
      break;
    }
    if (number++ >= m.offset) {
      list.push_back(worker_summary(worker, now));
    }
  }
  const json elsewhere = quarantined_elsewhere();
  number = static_cast<std::uint32_t>(workers_.size());
  for (const json& machine : elsewhere) {
    if (list.size() < m.limit && number++ >= m.offset) {
      list.push_back(machine);
    }
  }
  const std::uint64_t total = workers_.size() + elsewhere.size();
  send(peer, msg::Workers{m.request, std::move(list), total});
}

/// The farm map of PROTOCOL.md.
void Coordinator::on(Time now, const PeerId& peer, msg::ShowFarm& m) {
  json jobs = json::object();
  for (const JobState state : {JobState::queued, JobState::running, JobState::paused,
                               JobState::done, JobState::failed, JobState::cancelled}) {
    jobs[std::string(name_of(state))] = 0;
  }
  double seconds_left = 0;
  for (const auto& [id, job] : jobs_) {
    auto& count = jobs[std::string(name_of(job.record.state))];
    count = count.get<std::uint64_t>() + 1;
    if (!job.ended()) seconds_left += job.samples_left(now) * price_;
  }
  json workers = {
      {"ready", 0}, {"backoff", 0}, {"draining", 0}, {"drained", 0}, {"quarantined", 0}};
  std::uint64_t threads = 0;
  std::uint64_t leases = 0;
  double speed = 0;
  for (const auto& [id, worker] : workers_) {
    auto& count = workers[std::string(worker.state())];
    count = count.get<std::uint64_t>() + 1;
    threads += worker.may_trace() ? worker.hello.threads : 0;
    leases += worker.held;
    speed += worker.held > 0 ? worker.samples_per_second : 0;
  }
  send(peer, msg::Farm{m.request,
                       {{"jobs", std::move(jobs)},
                        {"workers", std::move(workers)},
                        {"threads", threads},
                        {"leases", leases},
                        {"samples_per_second", speed},
                        {"thread_seconds_left", seconds_left},
                        {"memory", {{"used", memory_in_use()}, {"most", options_.memory}}},
                        {"disk", {{"used", usage_.total}, {"most", options_.limits.disk}}},
                        {"storage", storage_},
                        {"since_start",
                         {{"samples", tally_.samples},
                          {"granted", tally_.granted},
                          {"accepted", tally_.accepted},
                          {"duplicate", tally_.duplicate},
                          {"stale", tally_.stale},
                          {"mismatch", tally_.mismatch},
                          {"failed", tally_.failed},
                          {"malformed", tally_.malformed}}}}});
}

}  // namespace parray
