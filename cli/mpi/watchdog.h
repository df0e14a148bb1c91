#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

#include "proto/clock.h"

namespace parray::mpi {

/// Ends a program whose main thread hangs in an MPI call, because another rank never answers. The
/// main thread cannot read the clock there.
class Watchdog {
 public:
  /// If reset() has not been called for `patience`, a thread of the watchdog calls `on_silence`,
  /// which must not return.
  Watchdog(Time patience, std::function<void()> on_silence)
      : patience_(patience), on_silence_(std::move(on_silence)), thread_([this] { watch(); }) {}
  ~Watchdog() {
    {
      const std::scoped_lock lock(mutex_);
      quit_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }
  Watchdog& operator=(Watchdog&&) = delete;

  /// Tells the watchdog that the main thread does not hang. Thread-safe.
  void reset() {
    const std::scoped_lock lock(mutex_);
    reset_ = true;
  }

 private:
  /// Counts steps instead of reading the clock, so that a process that was stopped misses only one
  /// step.
  void watch() {
    constexpr int most_silent_steps = 8;
    std::unique_lock lock(mutex_);
    for (int silent = 0; !quit_; ++silent) {
      if (std::exchange(reset_, false)) silent = 0;
      if (silent == most_silent_steps) on_silence_();
      changed_.wait_for(lock, patience_ / most_silent_steps, [this] { return quit_; });
    }
  }

  const Time patience_;
  const std::function<void()> on_silence_;
  std::mutex mutex_;  // guards reset_ and quit_
  std::condition_variable changed_;
  bool reset_ = false;
  bool quit_ = false;
  std::thread thread_;
};

}  // namespace parray::mpi
