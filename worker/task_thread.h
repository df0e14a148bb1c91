#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "common/math/float_mode.h"
#include "proto/clock.h"

namespace parray::worker {

/// A background thread that does one task at a time for the owner of this object, so that the owner
/// can serve its connection to the coordinator. The task's function may run its own OpenMP team.
template <typename Task, typename Result>
class TaskThread {
 public:
  /// Does a task. Ends early, with any result, once `stop` is true. Must not throw.
  using Work = std::function<Result(const Task& task, const std::atomic<bool>& stop)>;

  /// The background thread calls `on_finished` after each task, when take() returns its result or
  /// the thread is idle.
  TaskThread(Work work, std::function<void()> on_finished)
      : work_(std::move(work)), on_finished_(std::move(on_finished)), thread_([this] { run(); }) {}

  ~TaskThread() {
    {
      const std::scoped_lock lock(mutex_);
      quit_ = true;
      stop_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }
  TaskThread& operator=(TaskThread&&) = delete;

  /// Begins a task. Call it only when idle.
  void start(Task task) {
    {
      const std::scoped_lock lock(mutex_);
      next_ = std::move(task);
      busy_ = true;
    }
    changed_.notify_all();
  }

  /// Returns whether the thread has no task and no result that waits.
  [[nodiscard]] bool idle() const {
    const std::scoped_lock lock(mutex_);
    return !busy_ && !finished_;
  }

  /// Returns the result, once.
  std::optional<Result> take() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(finished_, std::nullopt);
  }

  /// Gives up the current task: it ends early, and its result is dropped.
  void abandon() {
    const std::scoped_lock lock(mutex_);
    next_.reset();
    finished_.reset();
    if (busy_) {
      abandoned_ = true;
      stop_ = true;
    }
  }

  /// Waits until the thread has no task, at most for the duration `timeout`.
  void wait_until_done(Time timeout) {
    std::unique_lock lock(mutex_);
    done_.wait_for(lock, timeout, [this] { return !busy_; });
  }

 private:
  void run() {
    const FloatMode ieee;  // also for tasks that build accelerators: they round numbers
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [this] { return quit_ || busy_; });
      if (quit_) return;
      if (next_) {
        Result finished = work_unlocked(lock);
        if (!abandoned_ && !quit_) finished_ = std::move(finished);
      }
      busy_ = false;
      abandoned_ = false;
      stop_ = quit_;
      lock.unlock();
      done_.notify_all();
      on_finished_();
      lock.lock();
    }
  }

  /// Does the task without the lock. Releases everything that the task refers to before the result
  /// is visible.
  Result work_unlocked(std::unique_lock<std::mutex>& lock) {
    std::optional<Task> task = std::exchange(next_, std::nullopt);
    lock.unlock();
    Result result = work_(*task, stop_);
    task.reset();
    lock.lock();
    return result;
  }

  const Work work_;
  const std::function<void()> on_finished_;
  std::atomic<bool> stop_ = false;

  mutable std::mutex mutex_;  // guards the members down to quit_
  std::condition_variable changed_;
  std::condition_variable done_;
  std::optional<Task> next_;
  bool busy_ = false;
  bool abandoned_ = false;
  std::optional<Result> finished_;
  bool quit_ = false;

  std::thread thread_;  // last member: it starts when all others exist
};

}  // namespace parray::worker
