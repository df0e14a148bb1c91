#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/mpi/mpi_options.h"
#include "cli/mpi/mpi_world.h"
#include "common/scene/settings.h"
#include "worker/window_source.h"

namespace parray::mpi {

/// What every rank has to know of a job before it can begin.
struct MpiJob {
  RenderSettings settings;
  MpiMode mode = MpiMode::window;
  std::uint32_t tile = 0;
  std::string fingerprint;  ///< of rank 0's kernels
  std::string scene_bytes;  ///< elsewhere than in rank 0

  /// Only rank 0 takes part.
  [[nodiscard]] bool alone() const {
    return mode == MpiMode::openmp || mode == MpiMode::sequential;
  }
};

/// Collective. Rank 0 sends the job and the scene; without a job, it sends that there is none.
std::optional<MpiJob> broadcast_job(const MpiWorld& world, const MpiJob* job,
                                    const std::string& scene_bytes = {});

/// Collective. Rank 0 sends the pass; without one, it sends that the job is done.
std::optional<RankPass> broadcast_pass(const MpiWorld& world, const MpiJob& job,
                                       const RankPass* pass);

/// A rank as the report names it.
struct RankFacts {
  std::string host;
  std::uint32_t threads = 1;
};

/// The ranks that take part, as each of them knows them.
struct Ranks {
  std::uint32_t count = 1;
  WindowOptions own;             ///< how this rank sizes its leases
  std::vector<RankFacts> facts;  ///< of all, in rank 0; elsewhere empty ones
};

/// Collective, unless rank 0 is alone. `threads`: of this rank.
Ranks find_ranks(const MpiWorld& world, const MpiJob& job, std::uint32_t threads);

}  // namespace parray::mpi
