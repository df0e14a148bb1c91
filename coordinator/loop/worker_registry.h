#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/schedule/chunk_sizer.h"
#include "coordinator/leases/lease_table.h"
#include "coordinator/leases/result_collector.h"
#include "coordinator/loop/machine_id.h"
#include "proto/clock.h"
#include "proto/link.h"
#include "proto/messages.h"

namespace parray::coordinator {

/// A worker, as long as it is connected.
struct WorkerRecord {
  WorkerId id = 0;
  PeerId peer;
  msg::Hello hello;
  std::string address;  ///< of its machine, as this side sees it; empty: unknown
  MachineId machine;    ///< several workers may have the same
  TracerKey machine_key = 0;
  bool ours = false;  ///< see Sender::ours
  TracerKey key = 0;  ///< of its process: tracer_key()
  Time last_heard{};
  unsigned pace = 1;  ///< of its heartbeat, as it was told last
  /// After which it is lost: the longest that it was told, as it may not have heard of a shorter
  /// one.
  Time silence{};
  std::uint64_t traced = 0;
  Time traced_at{};  ///< when `traced` last grew
  Time preparing_since = never;
  double samples_per_second = 0;  ///< measured; 0: not yet
  std::uint64_t accepted = 0;     ///< results
  std::size_t held = 0;           ///< leases, of all jobs
  /// Job and epoch of the lease that it was tracing when it was last heard.
  std::optional<std::pair<std::uint64_t, Epoch>> tracing;
  /// When it got its latest leases.
  struct Granted {
    std::uint64_t job = 0;
    Epoch epoch = 0;
    Time at{};
    double charged = 0;  ///< thread-seconds that it was expected to take
  };
  std::deque<Granted> grants;
  std::string quarantined;     ///< why it gets no more leases; empty: it does
  double quarantine_ends = 0;  ///< seconds since 1970; 0: when it is readmitted
  bool drained = false;        ///< it gets no more because somebody has asked for that
  bool held_back = false;      ///< it gets none for a while: see Backoff
  Time held_back_until{};
  std::map<std::uint64_t, Time> shunned;  ///< jobs that it has failed at, and until when it gets
                                          ///< none of their leases

  void note_grant(const Granted& grant);
  /// How it got that lease; at `otherwise`, for nothing, if that is long ago.
  [[nodiscard]] Granted granted(std::uint64_t job, Epoch epoch, Time otherwise) const;

  /// "ready", "backoff", "draining", "drained" or "quarantined".
  [[nodiscard]] std::string_view state() const;
  [[nodiscard]] bool may_trace() const { return quarantined.empty() && !drained && !held_back; }
  [[nodiscard]] bool has_room() const { return may_trace() && held < hello.capacity; }
};

/// The worker map of PROTOCOL.md.
nlohmann::json worker_summary(const WorkerRecord& worker, Time now);

/// All workers that are connected. Plain state; one thread.
class WorkerRegistry {
 public:
  WorkerRecord* at(const PeerId& peer);
  WorkerRecord* by_id(WorkerId id);
  /// The next one behind `peer`, which may have left; end() behind the last.
  [[nodiscard]] auto after(const PeerId& peer) { return workers_.upper_bound(peer); }
  /// `hello.name` and `.instance` are not known yet.
  WorkerRecord& add(Time now, const PeerId& peer, const msg::Hello& hello,
                    const Sender& sender = {});
  void remove(const PeerId& peer);
  [[nodiscard]] std::size_t size() const { return workers_.size(); }
  /// Of those that may trace.
  [[nodiscard]] std::size_t usable() const;
  [[nodiscard]] bool all_drained() const;
  /// The machines of those that may trace, but for some.
  [[nodiscard]] std::vector<TracerKey> usable_machines(const std::set<TracerKey>& but) const;
  [[nodiscard]] std::set<TracerKey> usable_machines() const;
  /// All that are connected from one machine.
  std::vector<WorkerRecord*> of_machine(TracerKey machine);

  /// A result of `samples` took so many seconds: a worker's speed is the mean of the last few.
  void measure(WorkerRecord& worker, std::uint64_t samples, double took);
  /// No more leases for it, or, where `why` is empty and it is not `drained`, again.
  void bar(WorkerRecord& worker, const std::string& why, bool drained);
  /// No leases for it until then; or, if not `held_back`, leases again.
  void hold_back(WorkerRecord& worker, bool held_back, Time until);
  /// Forgets which jobs were denied to workers until `now` or earlier. Returns when the next such
  /// denial ends; `never` if there is none.
  Time end_denials(Time now);
  [[nodiscard]] const FarmSpeed& speed() const { return speed_; }

  /// Those that have said nothing for their silence. Looked for at most ten times a second.
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
  std::map<TracerKey, unsigned> usable_;  ///< workers that may trace, by machine; no zeros
  Time next_look_{};
};

}  // namespace parray::coordinator
