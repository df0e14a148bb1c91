// What clients want changed of jobs, and administrators of workers.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/base/error.h"
#include "coordinator/loop/coordinator.h"

namespace parray::coordinator {

using nlohmann::json;

/// The job, or all frames of a series; none once the client has been told that there is no such
/// job, or that it is another's.
std::vector<Job*> Coordinator::asked_to_change(const PeerId& peer, std::uint64_t request,
                                               JobId id) {
  std::vector<Job*> jobs = frames_of(id);
  if (jobs.empty()) {
    Job* job = asked_for(peer, request, id);
    if (job == nullptr) {
      return {};
    }
    jobs = {job};
  }
  const std::string& user = jobs.front()->record.user;
  if (sender_.role == Role::client && user != sender_.name) {
    fail_request(peer, request, 2,
                 "job " + std::to_string(id) + " is " +
                     (user.empty() ? "nobody's" : "that of '" + user + "'") + ", not that of '" +
                     sender_.name + "': ask them, or an administrator");
    return {};
  }
  return jobs;
}

/// For a job's history.
std::string Coordinator::asker() const {
  return sender_.name.empty() ? "a client" : "'" + sender_.name + "'";
}

void Coordinator::on(Time now, const PeerId& peer, msg::SteerJob& m) {
  const std::vector<Job*> jobs = asked_to_change(peer, m.request, m.job);
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
      steer(*job, m);
    } catch (const InputError& error) {  // of a series, this frame is left as it is
      misfit = misfit.empty() ? error.what() : misfit;
      ++misfits;
    }
  }
  list_open_jobs();
  for (const Job* job : named) {
    if (job->ended()) {
      forget_scene(job->record.scene);
    }
  }
  make_room(0);
  const bool forget = m.action == msg::JobAction::forget;
  if (misfits == jobs.size() || (forget && misfits > 0)) {
    fail_request(peer, m.request, 2, misfit);
    return;
  }
  json summary = jobs.front()->record.id == m.job
                     ? job_summary(*jobs.front(), now, waits_for(*jobs.front()))
                     : summary_of(now, named);
  if (forget) {
    const std::string why = "as " + asker() + " wishes";
    jobs.front()->record.id == m.job ? forget_job(m.job, why) : forget_all(named, why);
  }
  send(peer, msg::Job{m.request, std::move(summary)});
}

/// Whether there is room for what is queued again; if not, the client has been told.
bool Coordinator::may_requeue(const PeerId& peer, std::uint64_t request, const Series& named) {
  const auto again = std::ranges::find_if(
      named, [](const Job* job) { return job->ended() && job->record.state != JobState::done; });
  try {
    if (again != named.end()) {
      check_limits((*again)->record);
    }
  } catch (const InputError& error) {
    fail_request(peer, request, 2, error.what());
    return false;
  }
  return true;
}

/// Throws InputError where the action does not fit the job's state. The list of open jobs, and the
/// queue, are the caller's.
void Coordinator::steer(Job& job, const msg::SteerJob& m) {
  using enum msg::JobAction;
  switch (m.action) {
    case pause:
      return this->pause(job, m.job);
    case resume:
      return this->resume(job);
    case cancel:
      return this->cancel(job);
    case requeue:
      return this->requeue(job);
    case prioritise:
      return this->prioritise(job, m.priority);
    case forget:
      break;
  }
  if (!job.ended()) {
    throw InputError("job " + std::to_string(job.record.id) + " has not ended: cancel it first");
  }
}

/// Leases that are granted are traced to their end. `named`: what the client has called it.
void Coordinator::pause(Job& job, JobId named) {
  if (job.ended() || job.phase == JobPhase::finishing || job.record.state == JobState::paused) {
    return;
  }
  job.record.state = JobState::paused;
  job.record.reason = "paused by " + asker() + ": parray resume " + std::to_string(named);
  note(job, "paused by " + asker());
  keep(job);
  log_->info("job {} '{}' is paused", job.record.id, job.record.name);
}

void Coordinator::resume(Job& job) {
  if (job.record.state != JobState::paused) {
    return;
  }
  job.record.state = job.work && job.work->started != never ? JobState::running : JobState::queued;
  job.record.reason.clear();
  note(job, "resumed by " + asker());
  keep(job);
  log_->info("job {} '{}' goes on", job.record.id, job.record.name);
}

void Coordinator::cancel(Job& job) {
  if (!job.ended()) {
    end_job(job, JobState::cancelled, "cancelled by " + asker());
  }
}

/// A job that has failed, or was cancelled, is to be rendered after all; it goes on from the rows
/// that are kept.
void Coordinator::requeue(Job& job) {
  const std::string number = std::to_string(job.record.id);
  if (!job.ended() || job.record.state == JobState::done) {
    throw InputError("job " + number + " is " + std::string(name_of(job.record.state)) +
                     ": only one that has failed or was cancelled is queued again");
  }
  if (store_ == nullptr && job.scene.size() == 0) {
    throw InputError("the scene of job " + number + " is no longer kept: submit it again");
  }
  job.record.state = JobState::queued;
  job.record.reason.clear();
  if (store_ == nullptr) {
    job.record.passes = {};  // they were decided by rows that are gone
  }
  job.phase = JobPhase::waiting;
  job.retry_at = never;
  index_.note_open(job);
  note(job, "queued again by " + asker());
  keep(job);
  log_->info("job {} '{}' is queued again", job.record.id, job.record.name);
}

void Coordinator::prioritise(Job& job, std::uint32_t priority) {
  if (job.ended()) {
    throw InputError("job " + std::to_string(job.record.id) + " has ended: it has no turn to come");
  }
  job.record.priority = priority;
  note(job, fmt::format("priority {} by {}", priority, asker()));
  keep(job);
}

void Coordinator::on(Time now, const PeerId& peer, msg::SteerWorkers& m) {
  if (sender_.role == Role::client) {
    fail_request(peer, m.request, 2,
                 "the key '" + sender_.name +
                     "' is that of a client: workers are an "
                     "administrator's");
    return;
  }
  m.action == msg::WorkerAction::drain ? drain(m.name, m.host) : readmit(m.name, m.host);
  keep_worker_notes();
  grants_due_ = true;
  auto list = json::array();
  for (const auto& [id, worker] : workers_) {
    if ((m.host ? worker.hello.host : worker.hello.name) == m.name) {
      list.push_back(worker_summary(worker, now));
    }
  }
  const std::uint64_t total = list.size();
  send(peer, msg::Workers{m.request, std::move(list), total});
}

/// They trace what they hold, and get no more, those that come later included.
void Coordinator::drain(const std::string& name, bool host) {
  drained_.insert({host, name});
  for (auto& [peer, worker] : workers_) {
    bar_as_due(worker);
  }
  log_->info("{} '{}' is drained by {}", host ? "host" : "worker", name, asker());
}

/// They get leases again, whatever they were barred for. A quarantine is that of a machine: it ends
/// for all workers there.
void Coordinator::readmit(const std::string& name, bool host) {
  drained_.erase({host, name});
  if (!host) {
    quarantines_.readmit(name);
  }
  for (auto& [peer, worker] : workers_) {
    if ((host ? worker.hello.host : worker.hello.name) == name) {
      drained_.erase({false, worker.hello.name});
      quarantines_.readmit(worker.machine_key);
      backoff_.forgive(worker.machine, worker.hello.name);
    }
  }
  for (auto& [peer, worker] : workers_) {
    bar_as_due(worker);
  }
  hold_back(now_);
  log_->info("{} '{}' is readmitted by {}", host ? "host" : "worker", name, asker());
}

bool Coordinator::is_drained(const WorkerRecord& worker) const {
  return drained_.contains({false, worker.hello.name}) ||
         drained_.contains({true, worker.hello.host});
}

/// Who is barred is barred in the next life, too.
void Coordinator::keep_worker_notes() {
  if (store_ == nullptr) {
    return;
  }
  json drained = json::array();
  for (const auto& [host, name] : drained_) {
    drained.push_back({host, name});
  }
  const json notes = {{"drained", std::move(drained)},
                      {"quarantines", quarantines_.to_json()},
                      {"convictions", convictions_.to_json()}};
  for_log("keeping the note of workers")
      .give([store = store_, text = notes.dump(-1, ' ', false, json::error_handler_t::replace)]()
                -> Backroom::Outcome {
        store->put_note("workers", text);
        return {};
      });
}

void Coordinator::restore_worker_notes() {
  const std::string text = store_ == nullptr ? "" : store_->note("workers");
  if (text.empty()) {
    return;
  }
  try {
    const json notes = json::parse(text);
    for (const json& drained : notes.at("drained")) {
      drained_.insert({drained.at(0).get<bool>(), drained.at(1).get<std::string>()});
    }
    // Earlier versions put processes into quarantine, which say nothing about machines.
    quarantines_ = QuarantineLedger::from_json(notes.value("quarantines", json::array()));
    convictions_ = Convictions::from_json(notes.value("convictions", json::array()));
    if (!notes.contains("convictions")) {  // of an earlier version
      for (const auto& [machine, quarantine] : quarantines_.all()) {
        convictions_.add(machine, quarantine.worker);
      }
    }
  } catch (const json::exception& error) {
    throw RunError(std::string("the state's note of workers is damaged: ") + error.what());
  }
}

}  // namespace parray::coordinator
