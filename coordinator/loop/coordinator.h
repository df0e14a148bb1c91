#pragma once

#include <future>
#include <memory>
#include <string>
#include <vector>

#include "coordinator/disputes/dispute_desk.h"
#include "coordinator/jobs/job_book.h"
#include "coordinator/leases/lease_desk.h"
#include "coordinator/loop/client_requests.h"
#include "coordinator/loop/worker_desk.h"
#include "coordinator/loop/worker_logs.h"

namespace parray::coordinator {

/// The coordinator's side of PROTOCOL.md. Dispatches messages and time to its parts. Not
/// thread-safe. The job thread owns the store and does all expensive work.
class Coordinator final : public Actor {
 public:
  using Tally = coordinator::Tally;

  /// Resumes the jobs of `store`. Null: nothing outlives the process. Throws RunError if the store
  /// cannot be read.
  Coordinator(CoordinatorOptions options, Store* store, std::shared_ptr<spdlog::logger> log);

  void receive(Time now, Delivery delivery) override;
  Time tick(Time now, bool drained) override;
  std::vector<Delivery> take_outbox() override { return std::exchange(farm_.outbox, {}); }

  /// Sends `bye` to every worker; the next take_outbox() returns the messages. `reason`: one line.
  void leave(const std::string& reason);

  /// Stores the progress of all jobs. Waits until this and everything before is committed, at most
  /// two seconds. Call it last.
  void keep_progress();

  /// Stores a named text. The result is ready when the store has committed it. Callable from any
  /// thread if the job thread is threaded.
  std::future<void> keep_note(const std::string& name, std::string text);

  [[nodiscard]] const Tally& tally() const { return farm_.tally; }

 private:
  template <typename M>
  void dispatch(Time now, const PeerId& peer, M& m);
  void refuse(Time now, const PeerId& peer, const Message& message);

  Farm farm_;
  WorkerDesk worker_desk_;
  JobBook job_book_;
  LeaseDesk leases_;
  DisputeDesk disputes_;
  ClientRequests clients_;
  WorkerLogs worker_logs_;
  RequestBudget requests_;
  JobThread job_thread_;  ///< last: its tasks end before the parts that they report to
};

}  // namespace parray::coordinator
