#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "common/adaptive/passes.h"
#include "proto/link.h"
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
  ~EmbeddedFarm();
  EmbeddedFarm& operator=(EmbeddedFarm&&) = delete;

  /// Returns a client's end of a link. It must not outlive the farm.
  std::unique_ptr<Link> connect();

  /// Returns the cache of the accelerators that the worker has built.
  [[nodiscard]] std::shared_ptr<AcceleratorCache> accelerators() const;

  /// Throws the exception that ended coordinator or worker, if any. Thread-safe.
  void check() const;

  /// Drops the work and ends the threads. Returns false if a thread is still in the middle of a
  /// step after `patience` (building an accelerator, a path of a million segments); the destructor
  /// would then wait for that thread.
  [[nodiscard]] bool stop(Time patience);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace parray::farm
