#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "coordinator/store/store.h"
#include "proto/clock.h"

namespace parray::coordinator {

/// What is too heavy for the coordinator's loop: decoding, digests, merging, the noise model,
/// pictures, the disk. One task after the other, in the order in which they were given, in a
/// thread of its own or, for tests and simulations, at once.
///
/// What tasks put into the store is committed every now and then, many tasks together.
class JobThread {
 public:
  /// What the loop is to do when an task is done.
  struct Completion {
    std::function<void()> done;  ///< as soon as may be; may be empty
    std::function<void()> kept;  ///< once what the task has put is committed; may be empty
  };
  /// Runs beside the loop and touches nothing of the loop's. It may throw: see give().
  using Task = std::function<Completion()>;
  /// What the loop does when an task has thrown. `why` is one line.
  using Failed = std::function<void(const std::string& why)>;

  struct Options {
    bool threaded = true;
    std::function<void()> wake;  ///< called when there is something for run_finished()
    /// The longest that anything waits for its commit.
    Time commit_interval = milliseconds(100);
    /// How often to commit where nothing was put, for a store that has other things to do then.
    Time idle_commits = never;
    /// That an task may take (OpenMP's of its thread).
    int threads = 1;
  };
  /// `store` may be null: nothing is kept, and everything counts as committed. It belongs to the
  /// tasks from now on.
  JobThread(Store* store, Options options);
  /// Waits for the task under way; drops the others.
  ~JobThread();
  JobThread(const JobThread&) = delete;
  JobThread& operator=(const JobThread&) = delete;

  /// Queues tasks. If one throws, run_finished() calls `failed` instead of its completion: one
  /// request or one job fails, and everything else goes on.
  class Guarded {
   public:
    void give(Task task) const { job_thread_.give({std::move(task), failed_}); }

   private:
    friend class JobThread;
    Guarded(JobThread& job_thread, Failed failed)
        : job_thread_(job_thread), failed_(std::move(failed)) {}
    JobThread& job_thread_;
    Failed failed_;
  };
  [[nodiscard]] Guarded guarded(Failed failed) { return {*this, std::move(failed)}; }

  /// Runs outcomes. Throws what a commit has thrown: a store that cannot commit is of no use. (A
  /// full disk is no such error: see blocked().) Called by the loop's turn.
  void run_finished();

  /// Why nothing can be committed now: a full disk. Empty: all is well. It is tried again every
  /// second.
  [[nodiscard]] std::string blocked() const;
  /// Errands that wait or are under way.
  [[nodiscard]] std::size_t backlog() const;

 private:
  struct Given {
    Task task;
    Failed failed;
  };
  void give(Given given);
  void run_task(Given given);
  void commit();
  void lead();

  Store* const store_;
  const Options options_;

  mutable std::mutex mutex_;  // guards the members down to quit_
  std::condition_variable changed_;
  std::deque<Given> waiting_;
  bool busy_ = false;
  std::vector<std::function<void()>> finished_;
  std::vector<std::function<void()>> uncommitted_;
  std::string blocked_;
  std::exception_ptr failure_;
  bool quit_ = false;

  std::thread thread_;
};

}  // namespace parray::coordinator
