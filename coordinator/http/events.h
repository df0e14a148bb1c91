#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "coordinator/http/loop_client.h"
#include "coordinator/store/job_record.h"

namespace parray::http {

/// Tells any number of listeners what changes. One thread asks the loop what there is, once a
/// second and such that the loop spends at most a fiftieth of its time on it, however many listen;
/// and not at all while nobody does. Any thread.
class Events {
 public:
  /// `loop` must outlive this.
  Events(LoopClient& loop, std::size_t most_streams);
  ~Events();
  Events(const Events&) = delete;
  Events& operator=(const Events&) = delete;

  /// Of everything, or of one job until it has ended. Throws Problem 503: too many listen.
  std::shared_ptr<EventStream> listen(std::optional<JobId> job);
  /// A job that is no more: tells at once, without waiting for the next look.
  void forgotten(JobId job);
  /// Ends all streams.
  void stop();

 private:
  class Stream;
  /// What everybody has been told: the text, and what it is of.
  struct Told {
    std::string event;
    bool ended = false;
    bool seen = false;
  };

  void run();
  void look();
  void look_at_jobs();
  void look_at_workers();
  void look_at_lone(JobId job, const std::vector<std::shared_ptr<Stream>>& listening);
  void take_job(const nlohmann::json& job);
  void lose_jobs(JobId oldest_listed);
  void tell(const std::string& event);
  std::vector<std::shared_ptr<Stream>> streams();

  LoopClient& loop_;
  const std::size_t most_streams_;
  std::mutex mutex_;  // guards streams_, stopped_, gone_
  std::condition_variable changed_;
  std::vector<std::weak_ptr<Stream>> streams_;
  std::vector<JobId> gone_;
  bool stopped_ = false;
  // The thread's own.
  std::map<JobId, Told> jobs_;           ///< unfinished ones, and the newest
  std::map<std::string, Told> workers_;  ///< by name
  std::uint64_t looks_ = 0;
  std::thread thread_;
};

}  // namespace parray::http
