#include "coordinator/loop/farm.h"

#include <spdlog/spdlog.h>

#include <utility>

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
      log_pictures(options.memory, 1),
      scenes_waiting(options.memory / 4, SIZE_MAX) {}

void Farm::send(const PeerId& peer, Message message) {
  outbox.push_back({peer, Envelope(std::move(message))});
}

void Farm::fail_request(const PeerId& peer, std::uint64_t request, std::uint32_t status,
                        const std::string& message) {
  send(peer, msg::Error{request, status, message});
}

JobThread::Guarded Farm::for_client(const PeerId& peer, std::uint64_t request,
                                    const std::string& doing) {
  return job_thread.guarded([this, peer, request, doing](const std::string& why) {
    log->error("{}: {}", doing, why);
    fail_request(peer, request, 1, doing + ": " + why);
  });
}

JobThread::Guarded Farm::for_log(const std::string& doing) {
  return job_thread.guarded(
      [this, doing](const std::string& why) { log->error("{}: {}", doing, why); });
}

/// Does nothing for a job that is being finished: the store has its last record already.
void Farm::keep(const Job& job) {
  if (store != nullptr && job.phase != JobPhase::finishing) {
    const auto tasks = for_log(fmt::format("keeping the record of job {}", job.record.id));
    tasks.give([to = store, run = job.work ? job.work->run : nullptr,
                record = job.record]() -> JobThread::Completion {
      run ? run->put(record) : to->put_job(record);
      return {};
    });
  }
}

Job* Farm::job_of(JobId id) {
  const auto found = jobs.find(id);
  return found == jobs.end() ? nullptr : &found->second;
}

Job* Farm::job_at_work(JobId id, std::uint64_t generation) {
  Job* job = job_of(id);
  return job != nullptr && job->work && job->work->generation == generation ? job : nullptr;
}

void Farm::note(Job& job, const std::string& what) { job.record.note(options.wall_clock(), what); }

/// Adjustments of the system's clock do not change it.
double Farm::uptime() const {
  return uptime_before + (began == never ? 0 : to_seconds(now - began));
}

}  // namespace parray::coordinator
