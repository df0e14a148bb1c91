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

/// A thread that does one task at a time for the thread that owns this object, so that the owner
/// stays free for its link. The task's function may lead a team of its own.
template <typename Task, typename Result>
class TaskThread {
 public:
  /// Does a task; ends early, with any result, once `stop` is true. Must not throw.
  using Work = std::function<Result(const Task& task, const std::atomic<bool>& stop)>;

  /// `on_finished` is called from the thread when it has become idle or has a result.
  TaskThread(Work work, std::function<void()> on_finished)
      : work_(std::move(work)), on_finished_(std::move(on_finished)), thread_([this] { lead(); }) {}

  ~TaskThread() {
    {
      const std::scoped_lock lock(mutex_);
      quit_ = true;
      stop_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }
  TaskThread(const TaskThread&) = delete;
  TaskThread& operator=(const TaskThread&) = delete;

  /// Begins a task; only when idle.
  void start(Task task) {
    {
      const std::scoped_lock lock(mutex_);
      next_ = std::move(task);
      busy_ = true;
    }
    changed_.notify_all();
  }

  /// Neither at work nor with a result that has not been taken.
  [[nodiscard]] bool idle() const {
    const std::scoped_lock lock(mutex_);
    return !busy_ && !finished_;
  }

  /// The result, once.
  std::optional<Result> take() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(finished_, std::nullopt);
  }

  /// Gives the current task up: it ends early and its result is dropped.
  void abandon() {
    const std::scoped_lock lock(mutex_);
    next_.reset();
    finished_.reset();
    if (busy_) {
      abandoned_ = true;
      stop_ = true;
    }
  }

  /// Returns when the thread is not at work, or after `timeout`.
  void wait_until_done(Time timeout) {
    std::unique_lock lock(mutex_);
    done_.wait_for(lock, timeout, [this] { return !busy_; });
  }

 private:
  void lead() {
    const FloatMode ieee;  // building a kernel rounds too
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [this] { return quit_ || busy_; });
      if (quit_) {
        return;
      }
      if (next_) {
        Result finished = work_unlocked(lock);
        if (!abandoned_ && !quit_) {
          finished_ = std::move(finished);
        }
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

  /// What a task refers to is let go before the result is there.
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

  std::thread thread_;  // last, so that it finds everything else in place
};

}  // namespace parray::worker
