// Answers requests about the farm as a whole and about workers.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

#include "coordinator/disputes/dispute_desk.h"
#include "coordinator/jobs/job_book.h"
#include "coordinator/leases/lease_desk.h"
#include "coordinator/loop/client_requests.h"

namespace parray::coordinator {

using nlohmann::json;

namespace {

constexpr std::size_t job_states = 6;

/// The jobs of a user, or of all users.
struct JobCounts {
  std::array<std::uint64_t, job_states> in_state{};
  double share = 0;  ///< of the latest job; 0: there is none

  [[nodiscard]] std::uint64_t in(JobState state) const {
    return in_state[static_cast<std::size_t>(state)];
  }
  [[nodiscard]] std::uint64_t open() const {
    return in(JobState::queued) + in(JobState::running) + in(JobState::paused);
  }
};

/// What one walk over all jobs finds.
struct JobSurvey {
  JobCounts all;
  std::map<std::string_view, JobCounts> users;
  double thread_seconds_left = 0;
  double oldest_queued = -1;  ///< seconds since 1970; negative: no job waits for a first lease
};

JobSurvey survey_jobs(const Farm& farm, Time now) {
  JobSurvey survey;
  for (const auto& [id, job] : farm.jobs) {
    const auto state = static_cast<std::size_t>(job.record.state);
    JobCounts& user = survey.users[job.record.user];
    ++survey.all.in_state[state];
    ++user.in_state[state];
    user.share = job.record.share;
    if (!job.ended()) survey.thread_seconds_left += job.samples_left(now) * farm.price;
    if (job.record.state == JobState::queued && job.queued_at >= 0 &&
        (survey.oldest_queued < 0 || job.queued_at < survey.oldest_queued)) {
      survey.oldest_queued = job.queued_at;
    }
  }
  return survey;
}

json count_map(const JobCounts& counts) {
  json map = json::object();
  for (std::size_t state = 0; state < job_states; ++state) {
    map[std::string(name_of(static_cast<JobState>(state)))] = counts.in_state[state];
  }
  return map;
}

/// Lists the users with jobs or an account: those with the most thread-seconds first, then by name.
json users_list(const Farm& farm, const JobSurvey& survey) {
  std::map<std::string_view, UserAccount> users;
  for (const auto& [name, account] : farm.watch.accounts()) users[name] = account;
  for (const auto& [name, counts] : survey.users) users[name].share = counts.share;
  std::vector<std::pair<std::string_view, UserAccount>> order(users.begin(), users.end());
  std::ranges::stable_sort(order, std::greater<>(),
                           [](const auto& user) { return user.second.thread_seconds; });
  order.resize(std::min(order.size(), FarmWatch::most_users));
  json list = json::array();
  for (const auto& [name, account] : order) {
    const auto found = survey.users.find(name);
    const JobCounts counts = found == survey.users.end() ? JobCounts{} : found->second;
    list.push_back(
        {{"user", name},
         {"share", account.share},
         {"open_jobs", counts.open()},
         {"done_jobs", counts.in(JobState::done)},
         {"failed_jobs", counts.in(JobState::failed)},
         {"cancelled_jobs", counts.in(JobState::cancelled)},
         {"thread_seconds", account.thread_seconds},
         {"queue_seconds_mean",
          account.begun > 0 ? json(account.queue_seconds / static_cast<double>(account.begun))
                            : json()}});
  }
  return list;
}

json events_list(const Farm& farm) {
  json list = json::array();
  for (const FarmEvent& event : farm.watch.events()) {
    json map = {
        {"at", farm.since_1970(event.at)},
        {"kind", farm_event_names[static_cast<std::size_t>(event.kind)]},
        {"text", event.frames > 1 ? fmt::format("{} frames; the last: {}", event.frames, event.text)
                                  : event.text}};
    if (!event.worker.empty()) map["worker"] = event.worker;
    if (event.job != 0) map["job"] = event.job;
    list.push_back(std::move(map));
  }
  return list;
}

json left_list(const Farm& farm) {
  json list = json::array();
  for (const LeftWorker& worker : farm.watch.left()) {
    list.push_back({{"name", worker.name},
                    {"host", worker.host},
                    {"at", farm.since_1970(worker.at)},
                    {"reason", worker.reason},
                    {"machine", worker.machine},
                    {"lost", worker.lost}});
  }
  return list;
}

json since_start(const Tally& tally) {
  return {{"samples", tally.samples},
          {"granted", tally.granted},
          {"accepted", tally.accepted},
          {"duplicate", tally.duplicate},
          {"stale", tally.stale},
          {"mismatch", tally.mismatch},
          {"failed", tally.failed},
          {"malformed", tally.malformed},
          {"workers_lost", tally.lost},
          {"jobs_ended",
           {{"done", tally.done}, {"failed", tally.failed_jobs}, {"cancelled", tally.cancelled}}},
          {"jobs_begun", tally.begun},
          {"queue_seconds", tally.queue_seconds}};
}

/// Returns the last hour, in intervals of ten seconds.
json history_map(const Farm& farm) {
  const FarmWatch& watch = farm.watch;
  json busy = json::array();
  json threads = json::array();
  json queued = json::array();
  for (const FarmWatch::Gauges& gauges : watch.gauges()) {
    busy.push_back(gauges.busy_threads);
    threads.push_back(gauges.threads);
    queued.push_back(gauges.queued);
  }
  const std::int64_t end = watch.end_of_history();
  return {{"interval", to_seconds(RateHistory::interval)},
          {"end", farm.since_1970(end * RateHistory::interval)},
          {"samples_per_second", watch.samples.before(end, watch.gauges().size())},
          {"busy_threads", std::move(busy)},
          {"threads", std::move(threads)},
          {"queued", std::move(queued)}};
}

/// Returns `value`, or null if it is 0 and therefore not known.
json known(auto value) { return value > 0 ? json(value) : json(); }

json tracing_of(const WorkerRecord& worker, Time now) {
  if (!worker.tracing || worker.held == 0) return {};
  return {{"job", worker.tracing->first}, {"seconds", to_seconds(now - worker.tracing_since)}};
}

/// Returns the worker map of PROTOCOL.md: what clients see of one worker.
json worker_summary(const Farm& farm, const WorkerRecord& worker, Time now) {
  const double backoff =
      worker.state() == "backoff" ? std::max(0.0, to_seconds(worker.held_back_until - now)) : 0.0;
  const std::string reason =
      backoff > 0 ? "it failed at leases that others traced: it gets no leases for a while"
                  : worker.quarantined;
  return {{"name", worker.hello.name},
          {"host", worker.hello.host},
          {"threads", worker.hello.threads},
          {"leases", worker.held},
          {"accepted", worker.accepted},
          {"samples_per_second", worker.samples_per_second},
          {"contribution", worker.samples.last_minute(now, farm.began)},
          {"state", worker.state()},
          {"reason", reason},
          {"backoff_seconds", backoff},
          {"machine", text_of(worker.machine)},
          {"quarantine_ends", worker.quarantine_ends},
          {"seconds_silent", to_seconds(now - worker.last_heard)},
          {"version", worker.hello.release},
          {"processors", known(worker.hello.processors)},
          {"memory_bytes", known(worker.hello.memory_bytes)},
          {"load", worker.load < 0 ? json() : json(worker.load)},
          {"address", worker.address},
          {"since", farm.since_1970(worker.joined)},
          {"failures", worker.failures},
          {"tracing", tracing_of(worker, now)}};
}

/// Returns the worker map with `history` and `recent_failures`.
json worker_details(const Farm& farm, const WorkerRecord& worker, Time now) {
  json map = worker_summary(farm, worker, now);
  const std::int64_t end = RateHistory::number_of(now);
  // The intervals that began before it joined are not part of its history.
  const auto count = static_cast<std::size_t>(
      std::clamp<std::int64_t>(end - RateHistory::number_of(worker.joined), 0, RateHistory::most));
  map["history"] = {{"interval", to_seconds(RateHistory::interval)},
                    {"end", farm.since_1970(end * RateHistory::interval)},
                    {"samples_per_second", worker.samples.before(end, count)}};
  json failures = json::array();
  for (const auto& failure : worker.recent_failures) {
    failures.push_back(
        {{"at", farm.since_1970(failure.at)}, {"job", failure.job}, {"reason", failure.reason}});
  }
  map["recent_failures"] = std::move(failures);
  return map;
}

}  // namespace

/// Returns the farm map of PROTOCOL.md.
json ClientRequests::farm_map(Time now) {
  farm_.watch.forget_old(now);
  const JobSurvey survey = survey_jobs(farm_, now);
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
  const double left = survey.thread_seconds_left;
  const json seconds_left = left == 0     ? json(0.0)
                            : threads > 0 ? json(left / static_cast<double>(threads))
                                          : json();
  const double queued_for =
      survey.oldest_queued < 0 ? 0 : std::max(farm_.since_1970(now) - survey.oldest_queued, 0.0);
  return {{"jobs", count_map(survey.all)},
          {"workers", std::move(workers)},
          {"threads", threads},
          {"leases", leases},
          {"samples_per_second", speed},
          {"contribution", farm_.watch.samples.last_minute(now, farm_.began)},
          {"thread_seconds_left", left},
          {"seconds_left", seconds_left},
          {"oldest_queued_seconds", queued_for},
          {"memory", {{"used", job_book_.memory_in_use()}, {"most", farm_.options.memory}}},
          {"disk", {{"used", job_book_.disk_used()}, {"most", farm_.options.limits.disk}}},
          {"storage", farm_.storage},
          {"since_start", since_start(farm_.tally)},
          {"users", users_list(farm_, survey)},
          {"events", events_list(farm_)},
          {"left", left_list(farm_)}};
}

void ClientRequests::on(Time now, const PeerId& peer, msg::ShowFarm& m) {
  farm_.note_history();
  farm_.send(peer, msg::Farm{m.request, m.history ? history_map(farm_) : farm_map(now)});
}

void ClientRequests::on(Time now, const PeerId& peer, msg::ShowWorker& m) {
  const WorkerRecord* worker = farm_.workers.by_name(m.name);
  if (worker == nullptr) {
    farm_.fail_request(peer, m.request, 2, farm_.why_no_worker(m.name));
    return;
  }
  farm_.send(peer, msg::Worker{m.request, worker_details(farm_, *worker, now)});
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
