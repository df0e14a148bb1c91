#include "coordinator/loop/client_requests.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "common/base/error.h"
#include "coordinator/disputes/dispute_desk.h"
#include "coordinator/jobs/job_book.h"
#include "coordinator/leases/lease_desk.h"
#include "coordinator/loop/farm.h"
#include "coordinator/loop/worker_desk.h"

namespace parray::coordinator {

using nlohmann::json;

/// Returns whether the comma-separated list `names` contains `state`.
static bool is_among(std::string_view names, std::string_view state) {
  for (std::size_t begin = 0; begin < names.size();) {
    const std::size_t end = std::min(names.find(',', begin), names.size());
    if (names.substr(begin, end - begin) == state) return true;
    begin = end + 1;
  }
  return false;
}

void ClientRequests::on(Time now, const PeerId& peer, msg::ListJobs& m) {
  auto list = json::array();
  const auto& listed = farm_.index.listed();
  const auto end = m.before == 0 ? listed.end() : listed.lower_bound(m.before);
  for (auto entry = std::make_reverse_iterator(end);
       entry != listed.rend() && list.size() < m.limit; ++entry) {
    const Job& first = *entry->second.begin()->second;
    const bool alone = first.record.series_id == 0;
    if (!m.states.empty() && alone && !is_among(m.states, first.shown_state())) continue;
    json summary = alone ? job_summary(first, now, job_book_.waits_for(first))
                         : job_book_.summary_of(now, series_of(entry->second));
    if (m.states.empty() || is_among(m.states, summary["state"].get<std::string>())) {
      list.push_back(std::move(summary));
    }
  }
  std::reverse(list.begin(), list.end());
  farm_.send(peer, msg::Jobs{m.request, std::move(list)});
}

/// Finds a job. If there is none, sends an error and returns null.
Job* ClientRequests::find_or_refuse(const PeerId& peer, std::uint64_t request, JobId id) {
  Job* job = farm_.job_of(id);
  if (job == nullptr) {
    const bool series = !job_book_.frames_of(id).empty();
    farm_.fail_request(
        peer, request, 2,
        series ? fmt::format("{} is a series of frames: write #### in the picture's name, or "
                             "name the job of one frame (parray show {} lists them)",
                             id, id)
               : fmt::format("no job {}: parray jobs lists all jobs", id));
  }
  return job;
}

void ClientRequests::on(Time now, const PeerId& peer, msg::ShowJob& m) {
  const std::vector<Job*> frames = job_book_.frames_of(m.job);
  if (!frames.empty()) {
    const Series series(frames.begin(), frames.end());
    json summary = job_book_.summary_of(now, series);
    summary["frame_list"] = frame_list(series, m.from_frame);
    farm_.send(peer, msg::Job{m.request, std::move(summary)});
  } else if (const Job* job = find_or_refuse(peer, m.request, m.job)) {
    json summary = job_summary(*job, now, job_book_.waits_for(*job));
    summary["events"] = events_to_json(job->record.events);
    summary["passes"] = curve_to_json(job->record.course.curve);
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

using nlohmann::json;

/// Finds a job, or all frames of a series. If there is no such job, or it belongs to another user,
/// sends an error and returns nothing.
std::vector<Job*> ClientRequests::find_changeable(const PeerId& peer, std::uint64_t request,
                                                  JobId id) {
  std::vector<Job*> jobs = job_book_.frames_of(id);
  if (jobs.empty()) {
    Job* job = find_or_refuse(peer, request, id);
    if (job == nullptr) {
      return {};
    }
    jobs = {job};
  }
  const std::string& user = jobs.front()->record.user;
  if (farm_.sender.role == Role::client && user != farm_.sender.name) {
    farm_.fail_request(peer, request, 2,
                       "job " + std::to_string(id) + " belongs to " +
                           (user.empty() ? "no user" : "'" + user + "'") + ", not to '" +
                           farm_.sender.name + "': ask its owner or an administrator");
    return {};
  }
  return jobs;
}

void ClientRequests::on(Time now, const PeerId& peer, msg::SteerJob& m) {
  const std::vector<Job*> jobs = find_changeable(peer, m.request, m.job);
  if (jobs.empty()) {
    return;
  }
  const Series named(jobs.begin(), jobs.end());
  if (m.action == msg::JobAction::requeue && !may_requeue(peer, m.request, named)) {
    return;
  }
  std::string misfit;
  std::size_t misfits = 0;
  for (Job* job : jobs) {
    try {
      job_book_.steer(*job, m);
    } catch (const InputError& error) {  // this frame of a series stays as it is
      misfit = misfit.empty() ? error.what() : misfit;
      ++misfits;
    }
  }
  job_book_.list_open_jobs();
  for (const Job* job : named) {
    if (job->ended()) {
      worker_desk_.forget_scene(job->record.scene);
    }
  }
  job_book_.make_room(0);
  const bool forget = m.action == msg::JobAction::forget;
  if (misfits == jobs.size() || (forget && misfits > 0)) {
    farm_.fail_request(peer, m.request, 2, misfit);
    return;
  }
  json summary = jobs.front()->record.id == m.job
                     ? job_summary(*jobs.front(), now, job_book_.waits_for(*jobs.front()))
                     : job_book_.summary_of(now, named);
  if (forget) {
    const std::string why = "as " + job_book_.asker() + " requested";
    jobs.front()->record.id == m.job ? job_book_.forget_job(m.job, why)
                                     : job_book_.forget_all(named, why);
  }
  farm_.send(peer, msg::Job{m.request, std::move(summary)});
}

/// Returns whether there is room to queue the jobs again. If not, sends an error.
bool ClientRequests::may_requeue(const PeerId& peer, std::uint64_t request, const Series& named) {
  const auto again = std::ranges::find_if(
      named, [](const Job* job) { return job->ended() && job->record.state != JobState::done; });
  try {
    if (again != named.end()) {
      job_book_.check_limits((*again)->record);
    }
  } catch (const InputError& error) {
    farm_.fail_request(peer, request, 2, error.what());
    return false;
  }
  return true;
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
