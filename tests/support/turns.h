#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

#include "proto/clock.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// Threads in virtual time. One thread runs until it sleeps. Then time advances to the thread that
/// wakes first. Every run has the same order. Any two threads may be interleaved
/// wherever one of them sleeps.
class Turns final : public Clock {
 public:
  /// Thrown by sleep() in every thread when virtual time is over.
  struct Over : std::runtime_error {
    Over() : std::runtime_error("virtual time is over") {}
  };

  explicit Turns(Time end) : end_(end) {}

  [[nodiscard]] Time now() const override { return now_; }

  /// Runs all tasks in one thread each, and returns when all have ended.
  void run(const std::vector<std::function<void(std::size_t)>>& tasks) {
    wakes_.assign(tasks.size(), Time(0));
    woken_.resize(tasks.size());
    std::vector<std::thread> threads;
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      threads.emplace_back([this, i, &tasks] {
        {
          std::unique_lock lock(mutex_);
          woken_[i].wait(lock, [&] { return turn_ == i; });
        }
        tasks[i](i);
        const std::scoped_lock lock(mutex_);
        wakes_[i] = never;
        pass_on();
      });
    }
    {
      const std::scoped_lock lock(mutex_);
      pass_on();
    }
    for (std::thread& thread : threads) thread.join();
  }

  /// Lets the current thread `self` sleep. Throws Over when virtual time is over.
  void sleep(std::size_t self, Time time) {
    std::unique_lock lock(mutex_);
    wakes_[self] = now_ + time;
    pass_on();
    woken_[self].wait(lock, [&] { return turn_ == self; });
    if (now_ > end_) throw Over();
  }

 private:
  void pass_on() {
    std::size_t next = 0;
    for (std::size_t i = 1; i < wakes_.size(); ++i) {
      if (wakes_[i] < wakes_[next]) next = i;
    }
    if (wakes_[next] == never) {
      turn_ = wakes_.size();
      return;
    }
    turn_ = next;
    now_ = std::max(now_, wakes_[next]);
    woken_[next].notify_one();
  }

  const Time end_;
  Time now_{};  // written by the running thread, under mutex_
  std::mutex mutex_;
  std::deque<std::condition_variable>
      woken_;  ///< one for each thread, so that only the next thread wakes up
  std::size_t turn_ = SIZE_MAX;
  std::vector<Time> wakes_;
};

}  // namespace parray::test
