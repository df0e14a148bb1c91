// What the backroom is given, and whom its failure concerns.
#include <spdlog/spdlog.h>

#include "coordinator/loop/coordinator.h"

namespace parray::coordinator {

/// For errands of the job's present work: if one throws, the job fails. `doing` says what it does.
Backroom::Guarded Coordinator::for_job(const Job& job, const std::string& doing) {
  return backroom_.guarded(
      [this, doing, id = job.record.id, generation = job.work->generation](const std::string& why) {
        if (Job* there = job_at_work(id, generation)) {
          fail_job(*there, doing + ": " + why);
        }
      });
}

/// For errands that answer a client: if one throws, the client gets the error.
Backroom::Guarded Coordinator::for_client(const PeerId& peer, std::uint64_t request,
                                          const std::string& doing) {
  return backroom_.guarded([this, peer, request, doing](const std::string& why) {
    log_->error("{}: {}", doing, why);
    fail_request(peer, request, 1, doing + ": " + why);
  });
}

/// For errands that nobody waits for: if one throws, the log says so.
Backroom::Guarded Coordinator::for_log(const std::string& doing) {
  return backroom_.guarded(
      [this, doing](const std::string& why) { log_->error("{}: {}", doing, why); });
}

/// The record as it is now goes to the store; one that is being finished has its last there
/// already.
void Coordinator::keep(const Job& job) {
  if (store_ != nullptr && job.phase != JobPhase::finishing) {
    const auto errands = for_log(fmt::format("keeping the record of job {}", job.record.id));
    errands.give([store = store_, record = job.record]() -> Backroom::Outcome {
      store->put_job(record);
      return {};
    });
  }
}

}  // namespace parray::coordinator
