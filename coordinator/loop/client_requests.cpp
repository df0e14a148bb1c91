#include "coordinator/loop/client_requests.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/base/error.h"
#include "coordinator/disputes/dispute_desk.h"
#include "coordinator/jobs/job_book.h"
#include "coordinator/jobs/job_list.h"
#include "coordinator/leases/lease_desk.h"
#include "coordinator/loop/farm.h"
#include "coordinator/loop/worker_desk.h"

namespace parray::coordinator {

using nlohmann::json;

void ClientRequests::on(Time now, const PeerId& peer, msg::ListJobs& m) {
  const JobList found = list_of(farm_.index, m, now, farm_.since_1970(now));
  auto list = json::array();
  for (const JobIndex::Frames* frames : found.page) {
    list.push_back(job_book_.summary_of(now, series_of(*frames)));
  }
  farm_.send(peer, msg::Jobs{m.request, std::move(list), found.total});
}

std::string ClientRequests::no_job_text(JobId id) const {
  return job_book_.frames_of(id).empty()
             ? fmt::format("no job {}: parray jobs lists all jobs", id)
             : fmt::format(
                   "{} is a series of frames: write #### in the picture's name, or "
                   "name the job of one frame (parray show {} lists them)",
                   id, id);
}

/// Finds a job. If there is none, sends an error and returns null.
Job* ClientRequests::find_or_refuse(const PeerId& peer, std::uint64_t request, JobId id) {
  Job* job = farm_.job_of(id);
  if (job == nullptr) {
    farm_.fail_request(peer, request, 2, no_job_text(id));
  }
  return job;
}

void ClientRequests::on(Time now, const PeerId& peer, msg::ShowJob& m) {
  const std::vector<Job*> frames = job_book_.frames_of(m.job);
  if (!frames.empty()) {
    const Series series(frames.begin(), frames.end());
    json summary = job_book_.summary_of(now, series);
    summary["frame_list"] = frame_list(series, now, m.from_frame, farm_.since_1970(now));
    summary["events"] = events_to_json(events_of(series));
    farm_.send(peer, msg::Job{m.request, std::move(summary)});
  } else if (const Job* job = find_or_refuse(peer, m.request, m.job)) {
    json summary = job_book_.summary_of(now, *job);
    summary["events"] = events_to_json(job->record.events);
    farm_.send(peer, msg::Job{m.request, std::move(summary)});
  }
}

void ClientRequests::on(Time now, const PeerId& peer, msg::ListWorkers& m) {
  auto list = json::array();
  std::uint32_t number = 0;
  for (const auto& [id, worker] : farm_.workers) {
    if (list.size() == m.limit) {
      break;
    }
    if (number++ >= m.offset) {
      list.push_back(worker_summary(worker, now));
    }
  }
  const json elsewhere = disputes_.quarantined_elsewhere();
  number = static_cast<std::uint32_t>(farm_.workers.size());
  for (const json& machine : elsewhere) {
    if (list.size() < m.limit && number++ >= m.offset) {
      list.push_back(machine);
    }
  }
  const std::uint64_t total = farm_.workers.size() + elsewhere.size();
  farm_.send(peer, msg::Workers{m.request, std::move(list), total});
}

/// Sends the farm map of PROTOCOL.md.
void ClientRequests::on(Time now, const PeerId& peer, msg::ShowFarm& m) {
  json jobs = json::object();
  for (const JobState state : {JobState::queued, JobState::running, JobState::paused,
                               JobState::done, JobState::failed, JobState::cancelled}) {
    jobs[std::string(name_of(state))] = 0;
  }
  double seconds_left = 0;
  for (const auto& [id, job] : farm_.jobs) {
    auto& count = jobs[std::string(name_of(job.record.state))];
    count = count.get<std::uint64_t>() + 1;
    if (!job.ended()) seconds_left += job.samples_left(now) * farm_.price;
  }
  json workers = {
      {"ready", 0}, {"backoff", 0}, {"draining", 0}, {"drained", 0}, {"quarantined", 0}};
  std::uint64_t threads = 0;
  std::uint64_t leases = 0;
  double speed = 0;
  for (const auto& [id, worker] : farm_.workers) {
    auto& count = workers[std::string(worker.state())];
    count = count.get<std::uint64_t>() + 1;
    threads += worker.may_trace() ? worker.hello.threads : 0;
    leases += worker.held;
    speed += worker.held > 0 ? worker.samples_per_second : 0;
  }
  farm_.send(
      peer,
      msg::Farm{m.request,
                {{"jobs", std::move(jobs)},
                 {"workers", std::move(workers)},
                 {"threads", threads},
                 {"leases", leases},
                 {"samples_per_second", speed},
                 {"thread_seconds_left", seconds_left},
                 {"memory", {{"used", job_book_.memory_in_use()}, {"most", farm_.options.memory}}},
                 {"disk", {{"used", job_book_.disk_used()}, {"most", farm_.options.limits.disk}}},
                 {"storage", farm_.storage},
                 {"since_start",
                  {{"samples", farm_.tally.samples},
                   {"granted", farm_.tally.granted},
                   {"accepted", farm_.tally.accepted},
                   {"duplicate", farm_.tally.duplicate},
                   {"stale", farm_.tally.stale},
                   {"mismatch", farm_.tally.mismatch},
                   {"failed", farm_.tally.failed},
                   {"malformed", farm_.tally.malformed}}}}});
}

/// Gives leases again to workers of this name or host, whatever the reason they got none.
void ClientRequests::readmit(Time now, const msg::SteerWorkers& m) {
  disputes_.readmit(m.name, m.host);
  for (const auto& [peer, worker] : farm_.workers) {
    if ((m.host ? worker.hello.host : worker.hello.name) == m.name) {
      leases_.forgive(worker);
    }
  }
  leases_.hold_back(now);
  farm_.log->info("{} readmitted {} '{}'", job_book_.asker(), m.host ? "host" : "worker", m.name);
}

void ClientRequests::on(Time now, const PeerId& peer, msg::SteerWorkers& m) {
  if (farm_.sender.role == Role::client) {
    farm_.fail_request(peer, m.request, 2,
                       "the key '" + farm_.sender.name +
                           "' is a client's: only an administrator may drain and readmit workers");
    return;
  }
  m.action == msg::WorkerAction::drain ? disputes_.drain(m.name, m.host, job_book_.asker())
                                       : readmit(now, m);
  disputes_.keep_worker_notes();
  farm_.grants_due = true;
  auto list = json::array();
  for (const auto& [id, worker] : farm_.workers) {
    if ((m.host ? worker.hello.host : worker.hello.name) == m.name) {
      list.push_back(worker_summary(worker, now));
    }
  }
  const std::uint64_t total = list.size();
  farm_.send(peer, msg::Workers{m.request, std::move(list), total});
}

}  // namespace parray::coordinator
