#pragma once

#include <string>

#include "coordinator/loop/farm.h"

namespace parray::coordinator {

class DisputeDesk;
class JobBook;
class LeaseDesk;

/// Handles joins, heartbeats and departures of workers, their requests for scenes, and a store that
/// cannot commit.
class WorkerDesk {
 public:
  WorkerDesk(Farm& farm, JobBook& job_book, LeaseDesk& leases, DisputeDesk& disputes)
      : farm_(farm), job_book_(job_book), leases_(leases), disputes_(disputes) {}

  /// Handle the workers' messages of PROTOCOL.md.
  void on(Time now, const PeerId& peer, msg::Hello& m);
  void on(Time now, const PeerId& peer, msg::Heartbeat& m);
  void on(Time now, const PeerId& peer, msg::NeedScene& m);
  void on(Time now, const PeerId& peer, msg::NeedChunk& m);
  void on(Time now, const PeerId& peer, msg::Bye& m);

  /// Notes that a worker sent a message, and returns the worker. If the sender is unknown, returns
  /// null and asks the sender to identify itself; after note_storage() has sent the workers away,
  /// it does not ask.
  WorkerRecord* heard_from(Time now, const PeerId& peer);
  /// Removes a worker and makes the cells of its leases available to other workers. `failed`: the
  /// worker left without `bye`, and the lease that it was tracing may be the cause.
  void lose_worker(Time now, const PeerId& peer, const std::string& why, bool failed);
  /// Stops the granting of leases while the store cannot commit, and sends `bye` to the workers
  /// after CoordinatorOptions::release_after. Tries again to finish jobs that a full disk has
  /// delayed. Call it in every turn of the loop.
  void note_storage(Time now);
  /// Drops the bytes that were kept to send a scene, if no job at work needs it.
  void forget_scene(const std::string& scene);

 private:
  [[nodiscard]] std::string refusal_of(const msg::Hello& hello) const;
  [[nodiscard]] unsigned pace() const;
  void welcome(WorkerRecord& worker);
  void note_progress(Time now, WorkerRecord& worker, const msg::Heartbeat& heartbeat) const;
  void release_workers(Time now);
  [[nodiscard]] const ScenePayload* scene_at_work(const std::string& scene) const;

  Farm& farm_;
  JobBook& job_book_;
  LeaseDesk& leases_;
  DisputeDesk& disputes_;
  Time blocked_since_ = never;  ///< when the store stopped to commit
  bool released_ = false;       ///< the workers were sent away because of that
};

}  // namespace parray::coordinator
