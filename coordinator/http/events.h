#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "coordinator/http/loop_client.h"
#include "coordinator/http/places.h"
#include "coordinator/store/job_record.h"

namespace parray::http {

/// Returns whether the job of this job map is done, failed or cancelled.
bool has_ended(const nlohmann::json& job);

/// Sends changes of jobs and workers to listeners: to the streams of listen() and to the callers of
/// await_end(). One thread polls the coordinator's loop about once per second, or more rarely, so
/// that it uses at most about 2 % of the loop's time. New listeners cause up to four polls per
/// second. Without listeners the thread does not poll. Callable from any thread.
class Events {
 public:
  /// `loop` must outlive this object. `most_streams`: limit of streams, and also limit of calls of
  /// await_end() at the same time. Each of these keeps a thread busy. `between_polls`: rest after a
  /// poll, unless a listener joins.
  Events(LoopClient& loop, std::size_t most_streams, Time between_polls = seconds(1));
  ~Events();
  Events& operator=(Events&&) = delete;

  /// Returns a stream of all events, or of one job's events until that job has ended or is deleted.
  /// The stream also ends if its client reads too slowly; the client may then open a new one.
  /// Throws Problem 503 if there are too many streams, or after stop().
  std::shared_ptr<BodyStream> listen(std::optional<JobId> job);
  /// Waits until the job has ended or was deleted, but at most for `patience`. Returns at once if
  /// stop() was called, or as soon as it is called. `owner`: the waiting user or address
  /// (owner_of()), which may wait in at most three quarters of `most_streams` calls. Throws Problem
  /// 503 if too many clients wait, or if the owner waits in too many calls.
  void await_end(JobId job, const std::string& owner, Time patience);
  /// Makes the next poll announce that a job was deleted. Does nothing without listeners.
  void forgotten(JobId job);
  /// Ends all streams, and all calls of await_end() that wait.
  void stop();

 private:
  class Stream;
  /// The latest event that was sent about a job or worker.
  struct Announced {
    std::string event;   ///< its text, as sent
    bool ended = false;  ///< the job has ended
    bool seen = false;   ///< the current poll has found it
  };

  void add(const std::shared_ptr<Stream>& stream);
  void run();
  void poll();
  void poll_jobs();
  void poll_workers();
  void poll_single_job(JobId job, const std::vector<std::shared_ptr<Stream>>& listening);
  void update_job(const nlohmann::json& job);
  void announce(Announced& announced, std::string event);
  void remove_unlisted(JobId oldest_listed);
  void send_to_all(const std::string& event);
  std::vector<std::shared_ptr<Stream>> streams();

  LoopClient& loop_;
  const std::size_t most_streams_;
  const Time between_polls_;
  Places waits_;      ///< only its entries are used
  std::mutex mutex_;  // guards streams_, stopped_, forgotten_
  std::condition_variable changed_;
  std::vector<std::weak_ptr<Stream>> streams_;
  std::atomic<std::uint64_t> joined_ = 0;  ///< number of streams so far; changed under mutex_
  std::vector<JobId> forgotten_;
  bool stopped_ = false;
  // Used by the thread only.
  std::map<JobId, Announced> jobs_;           ///< unfinished jobs and the newest ones
  std::map<std::string, Announced> workers_;  ///< by worker name
  std::uint64_t polls_ = 0;
  std::thread thread_;
};

}  // namespace parray::http
