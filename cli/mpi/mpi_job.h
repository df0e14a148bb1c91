#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cli/mpi/mpi_options.h"
#include "cli/mpi/mpi_world.h"
#include "common/image/row_block.h"
#include "common/scene/settings.h"
#include "common/schedule/work_plan.h"
#include "proto/mpi_window.h"
#include "worker/window_leases.h"

namespace parray {

/// What every rank has to know of a job before it can begin.
struct MpiJob {
  RenderSettings settings;
  MpiMode mode = MpiMode::window;
  std::uint32_t tile = 0;
  std::string fingerprint;  ///< of rank 0's kernels
  std::string scene_bytes;

  /// Only rank 0 takes part.
  [[nodiscard]] bool alone() const {
    return mode == MpiMode::openmp || mode == MpiMode::sequential;
  }
};

/// Collective. Rank 0 sends the job; without one, it sends that there is none.
std::optional<MpiJob> broadcast_job(const MpiWorld& world, const MpiJob* job);

/// What is to be traced before rank 0 decides how to go on: the whole job, or one pass of it.
struct MpiPass {
  std::vector<WorkRect> pending;
  std::vector<SampleRange> samples;  ///< of each pixel, image order; empty: all of `pending`
};

/// Collective. Rank 0 sends the pass; without one, it sends that the job is done.
std::optional<MpiPass> broadcast_pass(const MpiWorld& world, const MpiPass* pass);

/// A rank as the report names it.
struct RankFacts {
  std::string host;
  std::uint32_t threads = 1;
};

/// Facts of the first `participants` ranks, in rank 0; elsewhere empty ones. Collective, unless
/// rank 0 is the only participant.
std::vector<RankFacts> gather_facts(const MpiWorld& world, std::uint32_t own_threads,
                                    std::uint32_t participants);

/// The memory that leases and results go through, and how this rank reaches it.
class Transport {
 public:
  /// `world` outlives the object.
  Transport(const MpiWorld& world, const MpiJob& job);
  ~Transport() { static_cast<void>(mpi_window_.release()); }
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;

  /// Memory for a pass, as WindowLayout wants it; that of the pass before if it is large enough.
  /// Nobody uses it any more. Collective, unless rank 0 is alone. Falls back from a window to
  /// messages, for good, when the window cannot be had, or fails its trial.
  void begin_pass(const WindowLayout& layout);

  /// "window", "messages" or "memory" (rank 0 alone).
  [[nodiscard]] const char* name() const;
  /// Why there is no window although one was asked for; empty otherwise.
  [[nodiscard]] const std::string& fallback_reason() const { return fallback_reason_; }
  [[nodiscard]] bool by_messages() const { return by_messages_; }
  /// The window as this rank reaches it; null in a rank that sends messages.
  [[nodiscard]] Window* window();
  /// Rank 0's memory.
  [[nodiscard]] std::span<std::byte> memory();
  /// Rank 0: lets operations of others come in.
  void progress();
  /// Closes the window. Collective; not called when something has gone wrong and somebody may not
  /// answer: what is not closed stays open until the process ends.
  void close() { mpi_window_.reset(); }

 private:
  void open_window(const WindowLayout& layout);
  void clear(std::size_t zeroed);

  const MpiWorld& world_;
  const bool alone_;
  bool by_messages_;
  std::size_t bytes_ = 0;  ///< of the memory, in rank 0
  std::string fallback_reason_;
  std::unique_ptr<MpiWindow> mpi_window_;
  std::vector<std::uint64_t> local_memory_;  // words, for their alignment
  std::unique_ptr<LocalWindow> local_window_;
};

}  // namespace parray
