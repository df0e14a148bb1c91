#pragma once

#include <condition_variable>
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

/// Runs tasks that take too long for the coordinator's loop: decoding, digests, merging, the noise
/// model, pictures, the disk. Tasks run one at a time in the order of give(), in a background
/// thread or, for tests and simulations, within give(). One commit saves the data of many tasks.
class JobThread {
 public:
  /// What the loop calls after a task. Both may be empty.
  struct Completion {
    std::function<void()> done{};  ///< called as soon as possible
    std::function<void()> kept{};  ///< called when the store has committed what the task put there
  };
  /// Runs in the background thread and must not use data of the loop. It may throw: see give().
  using Task = std::function<Completion()>;
  /// What the loop calls after a task that threw. `why` is one line.
  using Failed = std::function<void(const std::string& why)>;

  struct Options {
    bool threaded = true;        ///< false: tasks run within give()
    std::function<void()> wake;  ///< called when run_finished() has something to do
    /// Longest time between a task and its commit.
    Time commit_interval = milliseconds(100);
    /// Time between commits when no task has run, for a store that does other work in commit().
    Time idle_commits = never;
    /// OpenMP threads that a task may use.
    int threads = 1;
  };
  /// `store` may be null: then everything counts as committed. From now on only tasks may use it.
  JobThread(Store* store, Options options);
  /// Waits for the running task and drops the others. Does not commit.
  ~JobThread();
  JobThread& operator=(JobThread&&) = delete;

  /// Queues a task. If it throws, run_finished() calls `failed` instead of its completion. So one
  /// request or one job fails, and all others continue.
  void give(Task task, Failed failed);

  /// Waits until all tasks have run and the store has committed their data, at most `most`.
  void settle(Time most);

  /// Calls the completions of finished tasks in the caller's thread, the loop. Rethrows what a
  /// commit has thrown, except StorageFull: see blocked().
  void run_finished();

  /// Returns why the store cannot commit now: the message of its StorageFull. Empty: it can.
  /// Retries come every second.
  [[nodiscard]] std::string blocked() const;
  /// Returns the number of tasks that wait or run.
  [[nodiscard]] std::size_t backlog() const;

 private:
  struct Given {
    Task task;
    Failed failed;
  };
  void run_task(Given given);
  void commit();
  void run();

  Store* const store_;
  const Options options_;

  mutable std::mutex mutex_;  // guards the members down to quit_
  std::condition_variable changed_;
  std::deque<Given> waiting_;
  bool busy_ = false;
  bool unsaved_ = false;  ///< a task has run since the latest commit
  std::vector<std::function<void()>> finished_;
  std::vector<std::function<void()>> uncommitted_;
  std::string blocked_;
  std::exception_ptr failure_;
  bool quit_ = false;

  std::thread thread_;
};

}  // namespace parray::coordinator
