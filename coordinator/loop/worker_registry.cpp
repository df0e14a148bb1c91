#include "coordinator/loop/worker_registry.h"

#include <algorithm>

#include "common/base/printable.h"
#include "coordinator/jobs/job_picture.h"

namespace parray::coordinator {

std::string_view WorkerRecord::state() const {
  if (!quarantined.empty()) return "quarantined";
  if (!drained) return held_back ? "backoff" : "ready";
  return held > 0 ? "draining" : "drained";
}

void WorkerRecord::note_failure(Time at, std::uint64_t job, const std::string& why) {
  constexpr std::size_t most = 20;
  constexpr std::size_t longest = 200;
  ++failures;
  recent_failures.push_front({at, job, printable(why, longest)});
  if (recent_failures.size() > most) recent_failures.pop_back();
}

void WorkerRecord::note_grant(const Granted& grant) {
  constexpr std::size_t most = 32;  // twice the leases that it may hold
  if (grants.size() == most) grants.pop_front();
  grants.push_back(grant);
}

WorkerRecord::Granted WorkerRecord::granted(std::uint64_t job, Epoch epoch, Time otherwise) const {
  const auto found = std::ranges::find_if(
      grants, [&](const Granted& grant) { return grant.job == job && grant.epoch == epoch; });
  return found == grants.end() ? Granted{job, epoch, otherwise} : *found;
}

WorkerRecord* WorkerRegistry::at(const PeerId& peer) {
  const auto found = workers_.find(peer);
  return found == workers_.end() ? nullptr : &found->second;
}

WorkerRecord* WorkerRegistry::by_id(WorkerId id) {
  const auto found = peers_.find(id);
  return found == peers_.end() ? nullptr : at(found->second);
}

const WorkerRecord* WorkerRegistry::by_name(const std::string& name) const {
  const WorkerRecord* latest = nullptr;
  for (const auto& [peer, worker] : workers_) {
    if (worker.hello.name == name && (latest == nullptr || worker.id > latest->id)) {
      latest = &worker;
    }
  }
  return latest;
}

std::vector<WorkerRecord*> WorkerRegistry::of_machine(TracerKey machine) {
  std::vector<WorkerRecord*> workers;
  for (auto& [peer, worker] : workers_) {
    if (worker.machine_key == machine) workers.push_back(&worker);
  }
  return workers;
}

std::vector<TracerKey> WorkerRegistry::usable_machines(const std::set<TracerKey>& but) const {
  std::vector<TracerKey> machines;
  for (const auto& [machine, workers] : usable_) {
    if (!but.contains(machine)) machines.push_back(machine);
  }
  return machines;
}

WorkerRecord& WorkerRegistry::add(Time now, const PeerId& peer, const msg::Hello& hello,
                                  const Sender& sender) {
  WorkerRecord record;
  record.id = next_id_++;
  record.peer = peer;
  record.hello = hello;
  record.key = tracer_key(hello.name, hello.instance);
  record.address = sender.address;
  record.machine = machine_of(sender, hello.name);
  record.machine_key = machine_key(record.machine);
  record.ours = sender.ours;
  record.joined = now;
  record.last_heard = now;
  record.traced_at = now;
  peers_[record.id] = peer;
  count(record, true);
  return workers_.emplace(peer, std::move(record)).first->second;
}

void WorkerRegistry::remove(const PeerId& peer) {
  const auto found = workers_.find(peer);
  if (found == workers_.end()) return;
  if (found->second.may_trace()) count(found->second, false);
  peers_.erase(found->second.id);
  workers_.erase(found);
}

bool WorkerRegistry::all_drained() const {
  return std::ranges::all_of(workers_, [](const auto& worker) { return worker.second.drained; });
}

/// Adds a worker to the sums over workers that may trace (`in`), or subtracts it.
void WorkerRegistry::count(const WorkerRecord& worker, bool in) {
  const auto change = [in](auto& sum, auto by) { sum = in ? sum + by : sum - std::min(sum, by); };
  change(speed_.workers, 1U);
  unsigned& of_machine = usable_[worker.machine_key];
  change(of_machine, 1U);
  if (of_machine == 0) usable_.erase(worker.machine_key);
  change(speed_.threads, std::uint64_t{worker.hello.threads});
  if (worker.samples_per_second > 0) {
    change(speed_.measured_threads, std::uint64_t{worker.hello.threads});
    change(speed_.samples_per_second, worker.samples_per_second);
  }
}

void WorkerRegistry::measure(WorkerRecord& worker, std::uint64_t samples, double took) {
  constexpr double shortest = 1e-6;  // clocks do not measure shorter times
  if (samples == 0) return;
  const double speed = static_cast<double>(samples) / std::max(took, shortest);
  const auto recount = [&](bool in) {
    if (worker.may_trace()) count(worker, in);
  };
  recount(false);
  // A lower speed applies at once: one lease that is too long costs more than several short ones.
  const double known = worker.samples_per_second;
  worker.samples_per_second = known > 0 && speed > known ? (known + speed) / 2 : speed;
  recount(true);
}

void WorkerRegistry::hold_back(WorkerRecord& worker, bool held_back, Time until) {
  const bool before = worker.may_trace();
  worker.held_back = held_back;
  worker.held_back_until = until;
  if (worker.may_trace() != before) count(worker, !before);
}

Time WorkerRegistry::end_denials(Time now) {
  Time next = never;
  for (auto& [peer, worker] : workers_) {
    std::erase_if(worker.denied_jobs, [now](const auto& denial) { return denial.second <= now; });
    for (const auto& [job, until] : worker.denied_jobs) next = std::min(next, until);
  }
  return next;
}

void WorkerRegistry::bar(WorkerRecord& worker, const std::string& why, bool drained) {
  const bool before = worker.may_trace();
  worker.quarantined = why;
  worker.drained = drained;
  if (worker.may_trace() != before) count(worker, !before);
}

std::vector<PeerId> WorkerRegistry::silent(Time now) {
  std::vector<PeerId> silent;
  if (now < next_look_) return silent;
  next_look_ = now + milliseconds(100);
  for (const auto& [peer, worker] : workers_) {
    if (worker.last_heard + worker.silence <= now) silent.push_back(peer);
  }
  return silent;
}

}  // namespace parray::coordinator
