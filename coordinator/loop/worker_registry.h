#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/schedule/chunk_sizer.h"
#include "coordinator/leases/lease_table.h"
#include "coordinator/leases/result_collector.h"
#include "coordinator/loop/machine_id.h"
#include "coordinator/loop/rate_history.h"
#include "proto/clock.h"
#include "proto/link.h"
#include "proto/messages.h"

namespace parray::coordinator {

/// The facts about a connected worker.
struct WorkerRecord {
  WorkerId id = 0;
  PeerId peer;
  msg::Hello hello;
  std::string address;  ///< of its machine, as the coordinator sees it; empty: unknown
  MachineId machine;    ///< several workers may have the same
  TracerKey machine_key = 0;
  bool ours = false;  ///< see Sender::ours
  TracerKey key = 0;  ///< of its process: tracer_key()
  Time joined{};
  Time last_heard{};
  unsigned pace = 1;  ///< factor of its heartbeat that the coordinator sent last
  /// Silence after which it counts as lost. The longest that the coordinator sent, because a
  /// message with a shorter one may not have arrived.
  Time silence{};
  std::uint64_t traced = 0;       ///< samples, by its own count
  Time traced_at{};               ///< when `traced` last changed, or it was preparing
  Time preparing_since = never;   ///< when it began to prepare a job
  double samples_per_second = 0;  ///< measured; 0: not yet
  std::uint64_t accepted = 0;     ///< results
  std::size_t held = 0;           ///< leases, of all jobs
  /// Job and epoch of the lease that it was tracing at its last heartbeat.
  std::optional<std::pair<std::uint64_t, Epoch>> tracing;
  Time tracing_since{};        ///< when it began to trace that job
  double load = -1;            ///< of its machine, at its last heartbeat; negative: not known
  RateHistory samples;         ///< its samples that were merged
  std::uint64_t failures = 0;  ///< leases that it could not trace, or not in time
  struct Failure {
    Time at{};
    std::uint64_t job = 0;
    std::string reason{};
  };
  std::deque<Failure> recent_failures;  ///< the last 20, newest first
  /// When it got a lease.
  struct Granted {
    std::uint64_t job = 0;
    Epoch epoch = 0;
    Time at{};
    double charged = 0;  ///< expected thread-seconds, charged to the job's user
  };
  std::deque<Granted> grants;  ///< the latest
  std::string quarantined;     ///< why it gets no more leases; empty: it gets leases
  double quarantine_ends = 0;  ///< seconds since 1970; 0: when an administrator readmits it
  bool drained = false;        ///< an administrator requested that it gets no more leases
  bool held_back = false;      ///< it gets no leases for a while: see Backoff
  Time held_back_until{};      ///< not after the present: it is not held back
  /// Jobs at which it failed, and when it may get their leases again.
  std::map<std::uint64_t, Time> denied_jobs;

  /// Counts a failure and remembers it.
  void note_failure(Time at, std::uint64_t job, const std::string& why);
  /// Remembers a grant. Forgets the oldest of more than 32.
  void note_grant(const Granted& grant);
  /// Returns the grant of a lease. If it is forgotten: a grant at `otherwise` with a charge of 0.
  [[nodiscard]] Granted granted(std::uint64_t job, Epoch epoch, Time otherwise) const;

  /// Returns "ready", "backoff", "draining", "drained" or "quarantined".
  [[nodiscard]] std::string_view state() const;
  [[nodiscard]] bool may_trace() const { return quarantined.empty() && !drained && !held_back; }
  [[nodiscard]] bool has_room() const { return may_trace() && held < hello.capacity; }
};

/// The connected workers. Not thread-safe.
class WorkerRegistry {
 public:
  /// Find a worker. Null: it is not connected.
  WorkerRecord* at(const PeerId& peer);
  WorkerRecord* by_id(WorkerId id);
  /// Finds the worker of this name that joined last. Null: none is connected.
  [[nodiscard]] const WorkerRecord* by_name(const std::string& name) const;
  /// Returns the worker after `peer` in the order of peers. `peer` may have left. end(): it was the
  /// last.
  [[nodiscard]] auto after(const PeerId& peer) { return workers_.upper_bound(peer); }
  /// Adds a worker. No connected worker may have the same peer.
  WorkerRecord& add(Time now, const PeerId& peer, const msg::Hello& hello,
                    const Sender& sender = {});
  void remove(const PeerId& peer);
  [[nodiscard]] std::size_t size() const { return workers_.size(); }
  /// Returns the number of workers that may trace.
  [[nodiscard]] std::size_t usable() const { return speed_.workers; }
  [[nodiscard]] bool all_drained() const;  ///< also true without workers
  /// Returns the machines of the workers that may trace, without those in `but`.
  [[nodiscard]] std::vector<TracerKey> usable_machines(const std::set<TracerKey>& but = {}) const;
  /// Returns the connected workers of one machine.
  std::vector<WorkerRecord*> of_machine(TracerKey machine);

  /// Updates WorkerRecord::samples_per_second after a result of `samples` that took `took` seconds.
  /// The new value is the speed of this result, or, if the result was faster than the old value,
  /// the mean of both.
  void measure(WorkerRecord& worker, std::uint64_t samples, double took);
  /// Stops granting leases to a worker: `why` is the reason of a quarantine. Grants leases again if
  /// `why` is empty and `drained` is false.
  void bar(WorkerRecord& worker, const std::string& why, bool drained);
  /// Stops granting leases to a worker if `held_back`, otherwise grants leases again. `until`: when
  /// the caller will call this again to end the delay.
  void hold_back(WorkerRecord& worker, bool held_back, Time until);
  /// Removes the denials of WorkerRecord::denied_jobs that have ended. Returns when the next one
  /// ends; `never` if there is none.
  Time end_denials(Time now);
  /// Returns the sums over the workers that may trace.
  [[nodiscard]] const FarmSpeed& speed() const { return speed_; }

  /// Returns the workers that sent nothing for WorkerRecord::silence. Looks for them at most ten
  /// times a second and otherwise returns none.
  std::vector<PeerId> silent(Time now);

  [[nodiscard]] auto begin() { return workers_.begin(); }
  [[nodiscard]] auto end() { return workers_.end(); }
  [[nodiscard]] auto begin() const { return workers_.begin(); }
  [[nodiscard]] auto end() const { return workers_.end(); }

 private:
  void count(const WorkerRecord& worker, bool in);

  std::map<PeerId, WorkerRecord> workers_;
  std::map<WorkerId, PeerId> peers_;
  WorkerId next_id_ = 1;
  FarmSpeed speed_{0, 0, 0, 0};
  std::map<TracerKey, unsigned>
      usable_;  ///< number of workers that may trace, by machine; no zeros
  Time next_look_{};
};

}  // namespace parray::coordinator
