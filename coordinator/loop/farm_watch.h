#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "coordinator/loop/rate_history.h"
#include "coordinator/store/job_record.h"
#include "proto/clock.h"

namespace parray::coordinator {

/// Kinds of events of the coordinator, its workers and its jobs.
enum class FarmEventKind : std::uint8_t {
  started,
  joined,
  left,
  lost,
  quarantined,
  readmitted,
  drained,
  backoff,
  job_done,
  job_failed,
  job_cancelled
};
inline constexpr std::array<std::string_view, 11> farm_event_names = {
    "started", "joined",  "left",     "lost",       "quarantined",  "readmitted",
    "drained", "backoff", "job_done", "job_failed", "job_cancelled"};

/// An event of the coordinator, a worker or a job.
struct FarmEvent {
  Time at{};
  FarmEventKind kind = FarmEventKind::started;
  std::string worker{};    ///< empty: it concerns no worker
  JobId job = 0;           ///< 0: it concerns no job
  std::string text{};      ///< for people
  std::size_t frames = 0;  ///< number of frames that ended, if `job` is a series; otherwise 0
};

/// A worker that is no longer connected.
struct LeftWorker {
  Time at{};
  std::string name{};
  std::string host{};
  std::string machine{};
  std::string reason{};
  bool lost = false;  ///< it did not send `bye`
};

/// The time that the farm has spent on the jobs of one user.
struct UserAccount {
  double share = 1;           ///< part of the farm's time, relative to other users' shares
  double thread_seconds = 0;  ///< of accepted results, also those of earlier processes
  double queue_seconds = 0;   ///< sum of the times that jobs waited from queueing to a lease
  std::uint64_t begun = 0;    ///< number of the times in queue_seconds
};

/// Remembers what an operator of the farm wants to know: the last events, workers that left, the
/// last hour, and the thread-seconds of each user. Every list has a limit. Not thread-safe.
class FarmWatch {
 public:
  static constexpr std::size_t most_events = 200;
  static constexpr std::size_t most_left = 200;
  static constexpr std::size_t most_users = 1000;

  /// Adds an event. Consecutive events of one kind about frames of one series become one.
  void note(FarmEvent event);
  /// Remembers a worker that left, until note_joined() or forget_old() drops it.
  void note_left(LeftWorker worker);
  /// Forgets that workers of this name left, because a worker of this name has joined.
  void note_joined(const std::string& name);
  /// The events, newest first.
  [[nodiscard]] const std::deque<FarmEvent>& events() const { return events_; }
  /// The workers that left, the latest first.
  [[nodiscard]] const std::deque<LeftWorker>& left() const { return left_; }
  /// Drops workers that left more than an hour ago.
  void forget_old(Time now);

  /// Returns the account of a user. Creates it if necessary; if there are most_users already, drops
  /// the one with the fewest thread-seconds.
  UserAccount& account(const std::string& user);
  [[nodiscard]] const std::map<std::string, UserAccount>& accounts() const { return accounts_; }
  /// Returns the thread-seconds by user as JSON text, for the store.
  [[nodiscard]] std::string accounts_text() const;
  /// Reads the output of accounts_text(). Ignores what it cannot read.
  void restore_accounts(std::string_view text);

  /// The state of the farm at the end of an interval.
  struct Gauges {
    std::uint32_t busy_threads = 0;  ///< of workers that hold leases
    std::uint32_t threads = 0;       ///< of workers that may trace
    std::uint32_t queued = 0;        ///< jobs in the state `queued`
  };
  /// Returns whether an interval of the history has ended and note_gauges() is due.
  [[nodiscard]] bool gauges_due(Time now) const { return RateHistory::number_of(now) > number_; }
  /// Notes the state at the end of all intervals that have ended since the last call.
  void note_gauges(Time now, const Gauges& gauges);
  /// The samples that were merged.
  RateHistory samples;
  /// The intervals, oldest first. The last ends where interval number end_of_history() begins.
  [[nodiscard]] const std::deque<Gauges>& gauges() const { return gauges_; }
  [[nodiscard]] std::int64_t end_of_history() const { return number_; }

 private:
  std::deque<FarmEvent> events_;
  std::deque<LeftWorker> left_;
  std::map<std::string, UserAccount> accounts_;
  std::deque<Gauges> gauges_;
  std::int64_t number_ = -1;  ///< of the present interval; -1: nothing is noted
};

}  // namespace parray::coordinator
