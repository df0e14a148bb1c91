#include "coordinator/loop/client_requests.h"

#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>

#include "coordinator/disputes/dispute_desk.h"
#include "coordinator/jobs/job_book.h"
#include "coordinator/jobs/job_list.h"
#include "coordinator/leases/lease_desk.h"
#include "coordinator/loop/worker_desk.h"
#include "coordinator/loop/worker_map.h"

namespace parray::coordinator {

using nlohmann::json;

void ClientRequests::on(Time now, const PeerId& peer, msg::ListJobs& m) {
  const JobList found = list_of(farm_.index, m, now);
  auto list = json::array();
  for (const JobIndex::Frames* frames : found.page) {
    list.push_back(short_map(job_book_.summary_of(now, series_of(*frames)), found.page.size()));
  }
  farm_.send(peer, msg::Jobs{m.request, std::move(list), found.total});
}

std::string ClientRequests::no_job_text(JobId id, bool picture) const {
  return job_book_.frames_of(id).empty()
             ? fmt::format("no job {}: parray jobs lists all jobs", id)
             : fmt::format(
                   "{} is a series of frames: {}name the job of one frame (parray show {} lists "
                   "them)",
                   id, picture ? "write #### in the picture's name, or " : "", id);
}

/// Finds a job. If there is none, sends an error and returns null. `picture`: the request is a
/// fetch.
Job* ClientRequests::find_or_refuse(const PeerId& peer, std::uint64_t request, JobId id,
                                    bool picture) {
  Job* job = farm_.job_of(id);
  if (job == nullptr) farm_.fail_request(peer, request, 2, no_job_text(id, picture));
  return job;
}

void ClientRequests::on(Time now, const PeerId& peer, msg::ShowJob& m) {
  const std::vector<Job*> frames = job_book_.frames_of(m.job);
  if (!frames.empty()) {
    const Series series(frames.begin(), frames.end());
    json summary = job_book_.summary_of(now, series);
    summary["frame_list"] = frame_list(series, now, m.from_frame);
    summary["events"] = events_to_json(events_of(series));
    farm_.send(peer, msg::Job{m.request, std::move(summary)});
  } else if (const Job* job = find_or_refuse(peer, m.request, m.job)) {
    json summary = job_book_.summary_of(now, *job);
    summary["events"] = events_to_json(job->record.events);
    summary["passes"] = curve_to_json(job->record.course.curve);
    farm_.send(peer, msg::Job{m.request, std::move(summary)});
  }
}

void ClientRequests::on(Time now, const PeerId& peer, msg::ListWorkers& m) {
  auto list = json::array();
  std::uint32_t number = 0;
  for (const auto& [id, worker] : farm_.workers) {
    if (list.size() == m.limit) break;
    if (number++ >= m.offset) list.push_back(worker_summary(farm_, worker, now));
  }
  const json elsewhere = disputes_.quarantined_elsewhere();
  number = static_cast<std::uint32_t>(farm_.workers.size());
  for (const json& machine : elsewhere) {
    if (list.size() < m.limit && number++ >= m.offset) list.push_back(machine);
  }
  const std::uint64_t total = farm_.workers.size() + elsewhere.size();
  farm_.send(peer, msg::Workers{m.request, std::move(list), total});
}

/// Gives leases again to workers of this name or host, whatever the reason they got none.
void ClientRequests::readmit(Time now, const msg::SteerWorkers& m) {
  disputes_.readmit(m.name, m.host);
  for (const auto& [peer, worker] : farm_.workers) {
    if ((m.host ? worker.hello.host : worker.hello.name) == m.name) leases_.forgive(worker);
  }
  leases_.hold_back(now);
  farm_.log->info("{} readmitted {} '{}'", job_book_.asker(), m.host ? "host" : "worker", m.name);
  farm_.announce(
      FarmEventKind::readmitted, m.host ? "" : m.name,
      fmt::format("{}readmitted by {}", m.host ? "host '" + m.name + "' " : "", job_book_.asker()));
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
      list.push_back(worker_summary(farm_, worker, now));
    }
  }
  const std::uint64_t total = list.size();
  farm_.when_kept([this, peer, answer = msg::Workers{m.request, std::move(list), total}] {
    farm_.send(peer, answer);
  });
}

}  // namespace parray::coordinator
