#include "coordinator/loop/farm.h"

#include <spdlog/spdlog.h>

#include <utility>

#include "common/base/printable.h"

namespace parray::coordinator {

/// Pictures and journals that one client may be receiving at a time.
static constexpr std::size_t most_bulk_of_peer = 4;

Farm::Farm(CoordinatorOptions options_of_farm, Store* kept_in,
           std::shared_ptr<spdlog::logger> log_of_farm, JobThread& tasks)
    : options(std::move(options_of_farm)),
      store(kept_in),
      log(std::move(log_of_farm)),
      job_thread(tasks),
      warnings(log),
      arrivals(log, 100),
      bulk(options.memory / 4, most_bulk_of_peer),
      log_pictures(0, 1),
      scenes_waiting(options.memory / 4, SIZE_MAX) {}

void Farm::send(const PeerId& peer, Message message) {
  outbox.push_back({peer, Envelope(std::move(message))});
}

void Farm::fail_request(const PeerId& peer, std::uint64_t request, std::uint32_t status,
                        const std::string& message) {
  send(peer, msg::Error{request, status, message});
}

void Farm::for_client(const PeerId& peer, std::uint64_t request, const std::string& doing,
                      JobThread::Task task) {
  job_thread.give(std::move(task), [this, peer, request, doing](const std::string& why) {
    log->error("{}: {}", doing, why);
    fail_request(peer, request, 1, doing + ": " + why);
  });
}

void Farm::for_log(const std::string& doing, JobThread::Task task) {
  job_thread.give(std::move(task),
                  [this, doing](const std::string& why) { log->error("{}: {}", doing, why); });
}

void Farm::keep(const Job& job) {
  if (store != nullptr && job.phase != JobPhase::finishing) {
    auto task = [to = store, run = job.work ? job.work->run : nullptr,
                 record = job.record]() -> JobThread::Completion {
      run ? run->put(record) : to->put_job(record);
      return {};
    };
    for_log(fmt::format("keeping the record of job {}", job.record.id), std::move(task));
  }
}

void Farm::when_kept(std::function<void()> then) {
  if (store == nullptr) {
    then();
    return;
  }
  for_log("answering a request", [then = std::move(then)]() -> JobThread::Completion {
    return {{}, then};
  });
}

Job* Farm::job_of(JobId id) {
  const auto found = jobs.find(id);
  return found == jobs.end() ? nullptr : &found->second;
}

Job* Farm::job_at_work(JobId id, std::uint64_t generation) {
  Job* job = job_of(id);
  return job != nullptr && job->work && job->work->generation == generation ? job : nullptr;
}

void Farm::announce(FarmEventKind kind, const std::string& worker, const std::string& text) {
  watch.note({now, kind, worker, 0, text});
}

void Farm::announce_end(const Job& job) {
  const JobRecord& record = job.record;
  const auto kind = record.state == JobState::done     ? FarmEventKind::job_done
                    : record.state == JobState::failed ? FarmEventKind::job_failed
                                                       : FarmEventKind::job_cancelled;
  ++(record.state == JobState::done     ? tally.done
     : record.state == JobState::failed ? tally.failed_jobs
                                        : tally.cancelled);
  const std::string reason = record.reason.empty() ? "" : ": " + record.reason;
  watch.note({now, kind, "", record.listed_as(),
              fmt::format("'{}' is {}{}", record.name, name_of(record.state), reason),
              record.series_id != 0 ? std::size_t{1} : 0});
}

void Farm::note_begun(Job& job) {
  if (job.queued_at < 0) return;
  const double waited = std::max(since_1970(now) - job.queued_at, 0.0);
  job.queued_at = -1;
  tally.queue_seconds += waited;
  ++tally.begun;
  UserAccount& account = watch.account(job.record.user);
  account.queue_seconds += waited;
  ++account.begun;
}

void Farm::note_history() {
  if (!watch.gauges_due(now)) return;
  FarmWatch::Gauges gauges;
  for (const auto& [peer, worker] : workers) {
    gauges.busy_threads += worker.held > 0 ? worker.hello.threads : 0;
    gauges.threads += worker.may_trace() ? worker.hello.threads : 0;
  }
  for (const JobId id : index.open()) {
    gauges.queued += jobs.at(id).record.state == JobState::queued ? 1 : 0;
  }
  watch.note_gauges(now, gauges);
}

std::string Farm::why_no_worker(const std::string& name) {
  watch.forget_old(now);
  const auto found = std::ranges::find(watch.left(), name, &LeftWorker::name);
  const std::string what = "no worker '" + printable(name) + "' is connected";
  return found == watch.left().end()
             ? what + ": parray workers lists those that are"
             : fmt::format("{}: it {} {:.0f} s ago ({})", what, found->lost ? "was lost" : "left",
                           to_seconds(now - found->at), found->reason);
}

/// Adjustments of the system's clock do not change it.
double Farm::uptime() const {
  return uptime_before + (began == never ? 0 : to_seconds(now - began));
}

}  // namespace parray::coordinator
