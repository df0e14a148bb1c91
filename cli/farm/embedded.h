#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <string>

#include "common/adaptive/passes.h"
#include "proto/inproc_link.h"
#include "worker/accelerator_cache.h"

namespace parray::farm {

/// A coordinator and a worker in this process, joined by in-process links, as `parray render` uses
/// them. Both run in threads of their own.
class EmbeddedFarm {
 public:
  /// `threads`: of the worker, 1 to 4096. `judge_of` takes the SHA-256 of a job's scene and returns
  /// the function that estimates the error of its denoised picture: see
  /// CoordinatorOptions::judge_of. Throws RunError if threads cannot be created.
  explicit EmbeddedFarm(std::uint32_t threads,
                        std::function<PictureJudge(const std::string&)> judge_of = {});
  /// Stops the farm. Waits until each thread has finished its current step: see stop().
  ~EmbeddedFarm() { request_stop(); }
  EmbeddedFarm& operator=(EmbeddedFarm&&) = delete;

  /// Returns a client's end of a link. It must not outlive the farm.
  std::unique_ptr<Link> connect() { return hub_.connect(); }

  /// Returns the cache of the accelerators that the worker has built.
  [[nodiscard]] std::shared_ptr<AcceleratorCache> accelerators() const { return accelerators_; }

  /// Throws the exception that ended coordinator or worker, if any. Thread-safe.
  void check() const;

  /// Drops the work and ends the threads. Returns false if a thread is still in the middle of a
  /// step after `patience` (building an accelerator, a path of a million segments); the destructor
  /// would then wait for that thread.
  [[nodiscard]] bool stop(Time patience);

 private:
  void request_stop();
  std::future<void> start(void (EmbeddedFarm::*work)());
  void run_coordinator();
  void run_worker();

  const std::string fingerprint_;
  const std::uint32_t threads_;
  const std::function<PictureJudge(const std::string&)> judge_of_;
  const std::shared_ptr<AcceleratorCache> accelerators_ = std::make_shared<AcceleratorCache>();
  InprocHub hub_;
  std::unique_ptr<Link> worker_link_ = hub_.connect();
  std::atomic<bool> stop_ = false;
  mutable std::mutex mutex_;  // guards failure_
  std::exception_ptr failure_;
  // Last, so that the threads end before the members that they use: the destructors wait for them.
  std::future<void> coordinator_thread_;
  std::future<void> worker_thread_;
};

}  // namespace parray::farm
