#pragma once

#include <spdlog/logger.h>
#include <spdlog/sinks/null_sink.h>

#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "common/scene/settings.h"
#include "coordinator/disputes/dispute_desk.h"
#include "coordinator/jobs/job_book.h"
#include "coordinator/leases/lease_desk.h"
#include "coordinator/loop/client_requests.h"
#include "coordinator/loop/worker_desk.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// The parts of a coordinator without the dispatcher, so that tests can call each part directly.
/// Time is virtual, and background tasks run at once.
struct FarmRig {
  explicit FarmRig(CoordinatorOptions options = rig_options(), Store* store = nullptr)
      : farm(std::move(options), store,
             std::make_shared<spdlog::logger>("null",
                                              std::make_shared<spdlog::sinks::null_sink_st>()),
             job_thread),
        workers(farm, jobs, leases, disputes),
        jobs(farm, disputes, workers),
        leases(farm, jobs, disputes, workers),
        disputes(farm, jobs),
        clients(farm, jobs, leases, disputes, workers),
        job_thread(store, farm.options.job_thread) {
    farm.now = seconds(1);
    farm.began = seconds(1);
  }

  static CoordinatorOptions rig_options() {
    CoordinatorOptions options;
    options.fingerprint = "same";
    options.job_thread.threaded = false;
    options.random = [] { return 0.5; };
    return options;
  }

  /// Adds a worker that this coordinator accepts.
  static msg::Hello hello(const std::string& name) {
    msg::Hello m;
    m.version = protocol_version;
    m.trace = trace_version;
    m.fingerprint = "same";
    m.name = name;
    m.host = "host of " + name;
    m.instance = "instance of " + name;
    m.threads = 2;
    return m;
  }
  WorkerRecord& join(const PeerId& peer, const std::string& name) {
    msg::Hello m = hello(name);
    workers.on(farm.now, peer, m);
    return *farm.workers.at(peer);
  }

  /// Adds a queued job without a picture in memory.
  Job& add_job(JobId id, const std::string& user = {}) {
    Job job;
    job.record.id = id;
    job.record.user = user;
    job.record.state = JobState::queued;
    job.record.settings->width = 8;
    job.record.settings->height = 8;
    Job& added = farm.jobs.emplace(id, std::move(job)).first->second;
    farm.index.add(added);
    return added;
  }

  /// Returns the messages of type M in the outbox, and empties it.
  template <typename M>
  std::vector<M> sent() {
    std::vector<M> found;
    for (Delivery& delivery : std::exchange(farm.outbox, {})) {
      Message message = delivery.content.open();
      if (M* m = std::get_if<M>(&message)) found.push_back(std::move(*m));
    }
    return found;
  }

  Farm farm;
  WorkerDesk workers;
  JobBook jobs;
  LeaseDesk leases;
  DisputeDesk disputes;
  ClientRequests clients;
  JobThread job_thread;  ///< the last member, as in Coordinator, so that it ends first
};

}  // namespace parray::test
