#include "coordinator/loop/worker_map.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace parray::coordinator {

using nlohmann::json;

namespace {

/// Returns `value`, or null if it is 0 and therefore not known.
json known(auto value) { return value > 0 ? json(value) : json(); }

json tracing_of(const WorkerRecord& worker, Time now) {
  if (!worker.tracing || worker.held == 0) return {};
  return {{"job", worker.tracing->first}, {"seconds", to_seconds(now - worker.tracing_since)}};
}

}  // namespace

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

}  // namespace parray::coordinator
