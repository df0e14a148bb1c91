#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "common/adaptive/passes.h"
#include "proto/link.h"
#include "worker/accelerator_cache.h"

namespace parray::farm {

/// A coordinator and a worker inside this process, joined by in-process links: what renders for
/// `parray render`. Both run in threads of their own.
class EmbeddedFarm {
 public:
  /// `threads`: of the worker, 1 .. 4096. `judge_of(scene_sha256)`: see CoordinatorOptions; called
  /// only for jobs that need it. Throws RunError when threads cannot be made.
  explicit EmbeddedFarm(std::uint32_t threads,
                        std::function<PictureJudge(const std::string&)> judge_of = {});
  /// Stops; waits for threads in the middle of a step.
  ~EmbeddedFarm();
  EmbeddedFarm(const EmbeddedFarm&) = delete;
  EmbeddedFarm& operator=(const EmbeddedFarm&) = delete;

  /// A client's end. Must not outlive the farm.
  std::unique_ptr<Link> connect();

  /// What its worker has built.
  [[nodiscard]] std::shared_ptr<AcceleratorCache> accelerators() const;

  /// Throws what ended one of the two, if something did. Any thread.
  void check() const;

  /// Drops the work and ends the threads. False: one is still in the middle of a step after
  /// `patience` (an accelerator being built, a path of a million segments), and the destructor
  /// would wait for it.
  [[nodiscard]] bool stop(Time patience);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace parray::farm
